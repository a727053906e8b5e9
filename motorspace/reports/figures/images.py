"""Pictures of what a camera sees."""

import math

import numpy as np
from matplotlib.figure import Figure

from motorspace._errors import UserError
from motorspace.recordings.recording import Recording
from motorspace.reports.figures.style import new_figure, styled
from motorspace.worlds.checks import whole

COLUMNS = 6


@styled
def images_figure(recording: Recording, num: int = 12) -> Figure:
    """Returns a strip of views in order of time, evenly spread from the first to the last.

    Args:
        recording: A walk with images for readings, such as that of `with_images`.
        num: How many views; all of them where there are fewer.

    Raises:
        UserError: The readings are no images, or `num` is below 1.
    """
    if len(recording.shape) != 3 or recording.shape[2] not in (1, 3):
        raise UserError(
            f"the readings are no images: their shape is {list(recording.shape)}",
            where=recording.name,
            remedy="give a recording with the shape (height, width, 3), such as with_images makes",
        )
    num = min(whole("num", num), len(recording))
    chosen = np.linspace(0, len(recording) - 1, num).round().astype(int)
    images = recording.sensors[chosen].reshape(num, *recording.shape)
    images = np.clip((images + 1) / 2, 0, 1)
    columns = min(num, COLUMNS)
    rows = math.ceil(num / columns)
    height, width, _ = recording.shape
    figure = new_figure(2 * columns, rows * (2 * height / width + 0.3))
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid:
        axes.axis("off")
    for axes, index, image in zip(grid, chosen, images, strict=False):
        axes.imshow(image, cmap="gray", vmin=0, vmax=1)
        axes.set_title(f"scan {index}")
    return figure
