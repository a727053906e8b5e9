"""Structure is measured: perfect codes are found perfect, copies of the motors are found out."""

from dataclasses import replace

import equinox as eqx
import jax
import numpy as np
import pytest

import motorspace as ms
from motorspace import ForwardAgent, LatticeAgent, UserError
from motorspace._files import json_text
from motorspace.analysis.coordinates import displacement_coordinates
from motorspace.evaluation.structure import equivalence, length_errors, measures, structure
from motorspace.evaluation.subject import Sizes, Subject, commands, subject_of
from motorspace.models.encoders.baselines import ConstantEncoder
from motorspace.training.run import initial_run
from motorspace.trajectories.commands import nominal

AGENT = ForwardAgent(0.8 * np.pi)
FEW = Sizes(sequences=600, groups=20, composed=300)


def dead_reckoned(motors):
    return displacement_coordinates(nominal(AGENT, motors), weight=1.0).points


def flat(motors):
    return motors.reshape(len(motors), -1)


@pytest.fixture(scope="module")
def found():
    return structure(Subject(dead_reckoned, AGENT, 6, sizes=FEW), seed=0)


def test_displacements_themselves_are_structured_perfectly(found):
    json_text(found)
    assert found["equivalence_ratio"] < 1e-9
    assert found["equivalence_auc"] == pytest.approx(1.0)
    kinds = {key for key in found if key.startswith("equivalence.") and key.count(".") == 1}
    assert kinds == {
        f"equivalence.{kind}"
        for kind in ("split_rotation", "split_translation", "full_turns", "undone")
    }
    assert found["composition.bilinear"] < 1e-6 < found["composition.linear"]
    assert found["length_error.translation.24"] < 1e-3
    assert found["linear_r2.worst"] > 0.9999 and abs(found["winding_number"]) == 1.0


def test_every_key_is_one_of_the_table_of_measures(found):
    for key in found:
        assert ms.measure(key).label


def test_motors_themselves_are_not():
    copied = structure(Subject(flat, AGENT, 6, sizes=FEW), seed=0)
    assert copied["equivalence_ratio"] > 0.1
    assert copied["equivalence_auc"] < 0.8
    assert copied["partial_motors"] > 0.9
    assert not any(key.startswith("length_error") for key in copied)


def test_lattice_sequences_are_grouped_by_their_displacement():
    agent = LatticeAgent()
    subject = Subject(
        lambda motors: displacement_coordinates(nominal(agent, motors)).points, agent, 4, sizes=FEW
    )
    assert equivalence(subject, key=jax.random.key(0))["equivalence_ratio"] < 1e-9


def test_weights_of_the_components_are_told_from_copies_of_the_motors():
    """Exact displacements that weigh orientation otherwise seem to know the motors a little."""
    agent = ForwardAgent(0.4 * np.pi)
    motors = commands(Subject(flat, agent, 6, sizes=FEW), (600, 6), key=jax.random.key(0))
    moved = nominal(agent, motors)
    points = displacement_coordinates(moved).points

    def partial(weight, copied=0.0):
        codes = np.concatenate(
            [points[:, :2], weight * points[:, 2:], copied * flat(motors)], axis=1
        )
        report = ms.topology(codes, moved, motors)
        return report["partial_motors"], report["partial_motors_affine"]

    assert abs(partial(1.0)[0]) < 0.01
    halved, doubled = partial(0.5), partial(2.0)
    assert halved[0] > 0.05 and doubled[0] < -0.05
    assert halved[0] == pytest.approx(halved[1], abs=1e-3)
    assert doubled[0] == pytest.approx(doubled[1], abs=1e-3)
    copying = partial(1.0, copied=0.5)
    assert copying[0] > copying[1] + 0.1


@pytest.fixture(scope="module")
def untrained():
    """A fresh network of `best`."""
    agent = ForwardAgent(0.2 * np.pi)
    return initial_run(ms.RunConfig(ms.Simulated(agent, layout="empty"), preset="best"))


def test_standard_form_leaves_what_an_affine_map_can_read(untrained):
    plain, standard = (
        measures(subject_of(untrained, standard=form)._replace(sizes=FEW), seed=0)
        for form in (False, True)
    )
    assert standard["linear_r2.worst"] == pytest.approx(plain["linear_r2.worst"], abs=0.02)
    assert standard["rank_correlation"] != plain["rank_correlation"]


def test_codes_that_are_no_matrices_have_no_standard_form(untrained):
    model = eqx.tree_at(lambda m: m.encoder, untrained.model, ConstantEncoder(6))
    with pytest.raises(UserError, match="have no standard form"):
        subject_of(replace(untrained, model=model), standard=True)


def test_an_encoder_of_one_length_is_measured_up_to_that_length():
    config = ms.RunConfig(ms.Simulated(AGENT, layout="empty"), ms.ModelConfig(encoder="mlp"))
    subject = subject_of(initial_run(config))._replace(sizes=FEW)
    errors = length_errors(subject, key=jax.random.key(0))
    assert "length_error.translation.6" in errors and "length_error.translation.12" not in errors
