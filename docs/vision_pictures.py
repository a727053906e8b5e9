"""Draw what eyes see and what is learned from it: `python -m docs.vision_pictures`.

It trains three networks for some minutes. Views of a camera need the extra `vision`.
"""

import math

import jax
import jax.numpy as jnp
import numpy as np

import motorspace as ms
from docs.drawings import PICTURES
from docs.portraits import png

EPOCHS = 300
PLACES = ((10.0, 11.0, 0.3), (30.0, 28.0, 2.3), (20.0, 8.0, -2.0))
ROTATION = 0.4 * math.pi


def main() -> None:
    """Train from colours and from distances, and draw."""
    world, retina = ms.layout("paper", paint="texture:4"), ms.Retina()
    poses = [ms.Pose(*jnp.array([*place, 0.0])) for place in PLACES]
    (PICTURES / "eyes.png").write_bytes(png(ms.view_figure(world, poses, retina)))
    agent = ms.ForwardAgent(ROTATION)
    runs = {
        "distances": ms.RunConfig(ms.Simulated(agent), preset="best"),
        "flat colours": ms.RunConfig(ms.Simulated(agent, retina), preset="vision"),
        "texture of 4 units": ms.RunConfig(
            ms.Simulated(agent, retina, paint="texture:4"), preset="vision"
        ),
    }
    walk = ms.sample(ms.Scenario("paper", agent), num=4000, horizon=6, key=jax.random.key(3))
    rows = []
    for name, config in runs.items():
        run = ms.train(ms.changed(config, {"epochs": EPOCHS}))
        coordinates = ms.pca(np.asarray(run.encode(walk.experience.motors)), 3).coordinates
        rows.append((name, coordinates, np.asarray(walk.displacements.nominal)))
    (PICTURES / "eyes-codes.png").write_bytes(png(ms.codes_figure(rows)))
    walked = ms.record(ms.Scenario("paper", agent), num_steps=60, key=jax.random.key(1))
    seen = ms.with_images(walked, "paper")
    (PICTURES / "images.png").write_bytes(png(ms.images_figure(seen)))


if __name__ == "__main__":
    main()
