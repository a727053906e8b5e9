"""The study of vision: its runs, what stands beside what, and measures of a small run."""

from dataclasses import replace

import numpy as np
import pytest

import motorspace as ms
from motorspace.studies import vision, vision_jobs, vision_rows
from motorspace.studies.rows import Row, known_measure
from motorspace.training.data import simulated
from motorspace.training.settings import changed


def row(variant, paint="flat", study="vision", **measures):
    cell = {"agent": "forward", "rotation": 0.4, "paint": paint, "variant": variant}
    return Row(study, cell, 1000, {0: measures})


def test_every_run_is_in_a_place_of_its_own_and_seeds_have_colours_of_their_own():
    jobs = vision.jobs("quick", 2)
    assert len({job.cell for job in jobs}) * 2 == len({(job.cell, job.seed) for job in jobs})
    assert len({(job.cell, job.seed) for job in jobs}) == len(jobs)
    seen = [job for job in jobs if dict(job.cell)["variant"] == "vision"]
    paints = {
        job.seed: {simulated(j.config.data).paint for j in seen if j.seed == job.seed}
        for job in seen
    }
    assert not paints[0] & paints[1]
    assert {job.measure for job in jobs} == vision.STUDY.measures.keys()


def test_the_oracle_learns_with_the_curriculum_of_its_place():
    (oracle,) = (
        job
        for job in vision.jobs("fifth", 1)
        if dict(job.cell)
        == {"agent": "holonomic", "paint": "flat", "rotation": 0.8, "variant": "oracle"}
    )
    training = oracle.config.training
    assert training.curriculum == ms.RunConfig(preset="vision").training.curriculum > 0
    assert oracle.config.model.encoder == "identity" and training.blur_weight > 0


def test_rows_have_their_oracles_and_distances_beside_them():
    r2 = {"linear_r2.worst": 0.9}
    found = vision_rows.rows(
        [
            row("vision", **{"vision.error": 0.6, "vision.persistence": 1.5}, **r2),
            row("oracle", **{"vision.error": 0.5}),
            row("untrained", **{"vision.error": 0.9, "linear_r2.worst": 0.1}),
            Row(
                "structure",
                {"agent": "forward", "rotation": 0.4, "variant": "best"},
                1000,
                {0: {"linear_r2.worst": 0.99}},
            ),
        ]
    )
    assert found[0]["vision.to_oracle"].mean == pytest.approx(1.2)
    (errors,) = vision_rows.error_lines(found)
    assert [errors[head]["mean"] for head in ("codes", "oracle", "untrained")] == [0.6, 0.5, 0.9]
    (beside,) = vision_rows.beside_lines(found)
    assert [beside[head]["mean"] for head in ("colours", "distances", "untrained")] == [
        0.9,
        0.99,
        0.1,
    ]


def test_runs_are_compared_seed_by_seed():
    two = row("vision", **{"vision.error": 0.6, "linear_r2.worst": 0.9})
    two = replace(two, runs={**two.runs, 1: {"vision.error": 9.0, "linear_r2.worst": 0.5}})
    found = vision_rows.rows(
        [
            two,
            row("oracle", **{"vision.error": 0.5}),
            row("light", **{"linear_r2.worst": 0.88}),
        ]
    )
    assert found[0]["vision.to_oracle"].values == pytest.approx([1.2])
    assert found[2]["vision.lost_to_light"].values == pytest.approx([0.02])


def test_half_a_texture_is_a_point_of_the_curve_and_no_place_of_its_own():
    found = [row("vision", vision_jobs.HALF, **{"linear_r2.worst": 0.7})]
    assert vision_rows.structure_lines(found) == []
    assert [line["paint"] for line in vision_rows.curve_lines(found)] == [vision_jobs.HALF]


def test_errors_of_scaled_angles_are_beside_that_of_the_right_scale():
    at = row(vision_jobs.SCALED, **{"prediction.error": 0.2})
    found = [
        replace(at, cell={**at.cell, "angle": angle}, runs={0: {"prediction.error": error}})
        for angle, error in ((1.0, 0.2), (1.25, 0.3))
    ]
    lines = vision_rows.angle_lines(found)
    increase = [line["increase of the error, %"]["mean"] for line in lines]
    assert increase == pytest.approx([0, 50])


def test_the_curve_is_in_order_of_wavelengths_and_pixels():
    rows = [
        row("vision", paint, **{"linear_r2.worst": 0.5}) for paint in ("texture:1", "texture:12")
    ]
    fine = row("pixels", "texture:1", **{"linear_r2.worst": 0.7})
    found = [*rows, replace(fine, cell={**fine.cell, "pixels": 128})]
    lines = vision_rows.curve_lines(found)
    assert [(line["paint"], line["pixels"]) for line in lines] == [
        ("texture:12", 32),
        ("texture:1", 32),
        ("texture:1", 128),
    ]
    errors = [replace(r, runs={0: {**r.runs[0], "vision.error": 0.9}}) for r in found]
    r2, error = vision_rows.curve_figure(errors).axes
    assert len(r2.get_lines()) == len(error.get_lines()) >= 2, "a line for each wavelength"


@pytest.mark.slow
def test_a_small_run_is_measured():
    config = changed(vision_jobs.FLAT.seen("quick", 0), {"epochs": 20, "num_rays": 8})
    run = ms.train(config)
    found = vision.measured_codes(run, 1000)
    assert all(known_measure(key) for key in found if not key.startswith("collapsed"))
    assert all(np.isfinite(found[key]) for key in found if key.startswith("vision."))
    assert found["vision.persistence"] > 1
