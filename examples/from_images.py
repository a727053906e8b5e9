"""Learn the space of displacements from what a camera sees: needs the extra `vision`.

The network is given commands and images of 24 x 32 pixels; nothing tells it where it is.
"""

import math

import jax

import motorspace as ms

walk_key, fresh_key = jax.random.split(jax.random.key(0))
scenario = ms.Scenario("paper", ms.ForwardAgent(max_rotation=0.4 * math.pi))
walk = ms.record(scenario, num_steps=6000, key=walk_key)
try:
    seen = ms.with_images(walk, "paper")
except ms.UserError as error:  # without MiniWorld, or without libraries that draw
    raise SystemExit(f"no images: {error}") from None
pairs = ms.windows(seen, horizon=3, per_scan=True)
print(f"{len(seen)} images of shape {seen.shape}, {len(pairs.experience.motors)} transitions")

best = ms.RunConfig(ms.Given("a walk with images"), preset="best")
trained = ms.changed(best, dict(epochs=250))  # of three networks that which predicts best
untrained = ms.changed(best, dict(epochs=1, restarts=1, train_encoder=False, curriculum=0.0))
fresh = ms.sample(scenario, num=4000, horizon=3, key=fresh_key)
for name, config in (("untrained", untrained), ("trained", trained)):
    run = ms.train(config, pairs.experience)
    report = ms.topology(run.encode(fresh.experience.motors), fresh.displacements.achieved)
    linear = {part: f"{value:.3f}" for part, value in report.linear_r2.items()}
    print(f"linear R² of the {name} code:", linear)
