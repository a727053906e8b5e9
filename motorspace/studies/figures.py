"""The paper's figures, drawn from finished runs of the studies table1, lattice and robots."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from motorspace.running.jobs import Job
from motorspace.studies.cells import CONTINUOUS, LATTICES
from motorspace.studies.study import Budget, study_named

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure

    from motorspace.training.run import Run

SHOWN_ROTATIONS = (0.2, 0.4, 0.8)
FIGURE_SEED = 2_000_003
NUM_CODES = 8000


def write_figures(folder: Path, budget: Budget) -> list[Path]:
    """Draw every figure that the finished runs of seed 0 allow, as PNG files.

    Args:
        folder: Where `reproduce` has put the runs; the figures are written there.
        budget: The budget of the runs.

    Returns:
        The files.
    """
    from motorspace._files import write_atomically
    from motorspace.reports.figures.style import png

    written = []
    for name, figure in _figures(folder, budget):
        written.append(folder / f"{name}.png")
        write_atomically(written[-1], png(figure, dots_per_inch=70))
    return written


def _figures(folder: Path, budget: Budget) -> "Iterator[tuple[str, Figure]]":
    from motorspace.analysis.projections import ica, pca
    from motorspace.reports.figures.codes import codes_figure, lattice_figure
    from motorspace.reports.figures.style import JET

    for agent in CONTINUOUS:
        rows = []
        for job in _of_seed_0("table1", budget, agent=agent, variant="paper"):
            rotation = dict(job.cell)["rotation"]
            if rotation in SHOWN_ROTATIONS and (run := _finished(folder, job)):
                codes, displacements = codes_of(run)
                title = f"{agent}, r = {rotation} π"
                rows.append((title, pca(codes).coordinates, displacements))
                if rotation == SHOWN_ROTATIONS[-1]:
                    row = (title, ica(codes), displacements)
                    yield f"ica-{agent}", codes_figure([row], axis_name="IC")
        if rows:
            yield f"codes-{agent}", codes_figure(rows, colours=JET)
            yield f"codes-{agent}-uniform", codes_figure(rows)
    for study, setting, draw in (
        ("lattice", "variant", lattice_figure),
        ("robots", "recording", codes_figure),
    ):
        rows = [
            (str(dict(job.cell)[setting]).replace("-", " "), pca(codes).coordinates, displacements)
            for job in _of_seed_0(study, budget)
            if dict(job.cell)["variant"] in (*LATTICES, "paper") and (run := _finished(folder, job))
            for codes, displacements in [codes_of(run)]
        ]
        if rows:
            yield study, draw(rows)


def codes_of(run: "Run") -> "tuple[np.ndarray, np.ndarray]":
    """Codes of fresh trajectories, or of the test blocks of a log, and what they led to."""
    import jax
    import numpy as np

    from motorspace.evaluation.sampling import draw_test
    from motorspace.training.data import Logged
    from motorspace.training.sources import logged_data

    if isinstance(run.config.data, Logged):
        found = logged_data(run.config.data).test
    else:
        found = draw_test(run.config.data, NUM_CODES, key=jax.random.key(FIGURE_SEED))
    codes = run.encode(found.experience.motors, found.experience.num_steps)
    return np.asarray(codes), np.asarray(found.displacements.achieved)


def _of_seed_0(study: str, budget: Budget, **settings: str) -> list[Job]:
    jobs = study_named(study).jobs(budget, 1)
    return [job for job in jobs if settings.items() <= dict(job.cell).items()]


def _finished(folder: Path, job: Job) -> "Run | None":
    from motorspace.training.folder import finished
    from motorspace.training.run import load_run

    place = folder / job.study / job.folder
    return load_run(place) if finished(place) else None
