"""Learn the space of displacements from what a camera sees; needs the extra `vision`."""

import math
from pathlib import Path

import jax

import motorspace as ms

walk_key, fresh_key = jax.random.split(jax.random.key(0))
scenario = ms.Scenario("paper", ms.ForwardAgent(max_rotation=0.4 * math.pi))
walk = ms.record(scenario, num_steps=6000, key=walk_key)
try:
    seen = ms.with_images(walk, "paper")  # 24 x 32 pixels in colour at each of 6,001 places
except ms.UserError as error:  # without MiniWorld, and without libraries that draw
    raise SystemExit(f"no images: {error}") from None
ms.images_figure(seen).savefig(Path("images.png"))

config = ms.RunConfig(
    ms.Given("images of a walk"),
    preset="best",
    training=ms.changed(
        ms.RunConfig(ms.Given(), preset="best"), {"epochs": 40, "restarts": 1}
    ).training,
)
