"""Draw the maps of the documentation: `python -m docs.map_pictures LOGS`.

Simulated rooms, and two public logs in the folder LOGS, on which networks learn first. Takes some
ten minutes.
"""

import sys
from pathlib import Path

import jax

import motorspace as ms
from docs.drawings import PICTURES
from motorspace.analysis.paths import aligned
from motorspace.cli.map import panels_of
from motorspace.mapping.rig import learn_rig
from motorspace.mapping.survey import survey
from motorspace.mapping.trials import BIAS, NOISE, unseen_walk
from motorspace.recordings.recording import Recording, sensor_frames
from motorspace.reports.figures.maps import map_figure
from motorspace.studies.logs import STUDY, log_with_beams
from motorspace.studies.reproduce import with_log
from motorspace.training.run import Run

ROOMS = "rooms:2003"


def main(logs: Path) -> None:
    """Draw everything."""
    run = ms.load_pretrained("forward-0.4pi").run
    walk = unseen_walk(run, ROOMS, noise=NOISE, bias=BIAS, key=jax.random.key(5))
    draw("map-rooms", run, walk)
    for job in STUDY.jobs("paper", 1):
        if dict(job.cell)["variant"] == "codes":
            run = ms.train(with_log(job.config, logs))
            draw(f"map-{str(dict(job.cell)['recording']).split('-')[0]}", run, log_with_beams(run))


def draw(name: str, run: Run, walk: Recording) -> None:
    """Put a walk together, and draw it beside the same readings at their true poses."""
    scans = learn_rig(run, walk).scans(walk)
    found, truth = survey(scans), sensor_frames(walk)
    paths = {"with loops": aligned(found.poses, truth), "truth": truth}
    figure = map_figure(panels_of(scans, found, paths, cell=None))
    figure.savefig(PICTURES / f"{name}.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
