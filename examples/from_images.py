"""Learn the space of displacements from what a camera sees: needs the extra `vision`.

The network is given commands and images of 12 x 16 pixels; nothing tells it where it is.
"""

import math

import jax

import motorspace as ms
from motorspace.models.model import Scaling

EPOCHS, HORIZON = 200, 6

walk_key, fresh_key = jax.random.split(jax.random.key(0))
scenario = ms.Scenario("paper", ms.ForwardAgent(max_rotation=0.4 * math.pi))
walk = ms.record(scenario, num_steps=20_000, key=walk_key)
try:
    seen = ms.with_images(walk, "paper", ms.Camera(height=12, width=16))
except ms.UserError as error:  # without MiniWorld, or without libraries that draw
    raise SystemExit(f"no images: {error}") from None
print(f"{len(seen)} images of shape {seen.shape}")

# The shape lets views be blurred; short sequences come first and teach the commands.
data = ms.Given("images of a walk", shape=seen.shape)
config = ms.changed(ms.RunConfig(data, preset="vision"), dict(epochs=EPOCHS))
growing = config.training.curriculum_epochs
source = ms.draw_windows(seen, num=2000, horizon=HORIZON, curriculum_epochs=growing)
scaling = Scaling(seen.sensor_scale, (1.0, 1.0))

fresh = ms.sample(scenario, num=4000, horizon=HORIZON, key=fresh_key)
for name, epochs in (("untrained", 1), ("trained", EPOCHS)):
    given = ms.changed(config, dict(epochs=epochs, train_encoder=epochs > 1))
    run = ms.train(given, source, scaling=scaling)
    report = ms.topology(run.encode(fresh.experience.motors), fresh.displacements.achieved)
    linear = {part: f"{value:.3f}" for part, value in report.linear_r2.items()}
    print(f"linear R² of the {name} code:", linear)
