"""Every measure on codes for which the right answer is known."""

import numpy as np
import pytest

from motorspace import topology
from motorspace.analysis import circle, composition, dimension, distances, equivalence
from motorspace.analysis.coordinates import displacement_coordinates

NUM = 1200


def rng(seed=0):
    return np.random.default_rng(seed)


def displacements(num=NUM, seed=0, largest=np.pi):
    random = rng(seed)
    return np.concatenate(
        [random.normal(size=(num, 2)), random.uniform(-largest, largest, (num, 1))], axis=1
    )


def rotated(points, seed=3):
    """The points in a random orthonormal basis of ten dimensions, and moved."""
    basis, _ = np.linalg.qr(rng(seed).normal(size=(10, 10)))
    padded = np.pad(points, ((0, 0), (0, 10 - points.shape[1])))
    return padded @ basis + 0.3


DISPLACEMENTS = displacements()
POINTS = displacement_coordinates(DISPLACEMENTS).points


@pytest.fixture(scope="module")
def isometric():
    return topology(rotated(POINTS), DISPLACEMENTS, rng(1).normal(size=(NUM, 6, 2)))


@pytest.fixture(scope="module")
def random():
    return topology(rng(2).normal(size=(NUM, 4)), DISPLACEMENTS, rng(1).normal(size=(NUM, 12)))


def test_an_isometry_is_perfect(isometric):
    assert isometric.normalised_topology_error == pytest.approx(0.0, abs=1e-9)
    assert isometric.metric_error == pytest.approx(0.0, abs=1e-4)
    assert isometric.rank_correlation == pytest.approx(1.0)
    assert isometric.partial_displacement == pytest.approx(1.0)
    assert abs(isometric.partial_motors) < 0.02
    for k in (10, 20, 50):
        assert isometric.trustworthiness[k] == pytest.approx(1.0)
        assert isometric.continuity[k] == pytest.approx(1.0)
    assert isometric.neighbours_to_floor == pytest.approx(1.0)
    assert isometric["linear_r2.worst"] > 0.9999
    assert isometric.orientation_error < 0.1
    assert isometric.circular_correlation == pytest.approx(1.0, abs=1e-4)
    assert abs(isometric.winding_number) == 1
    assert isometric.intrinsic_dimension == pytest.approx(3.0, abs=0.4)
    assert isometric.components_95 == 4


def test_random_codes_are_at_chance(random):
    assert random.normalised_topology_error == pytest.approx(1.0, abs=0.05)
    assert abs(random.rank_correlation) < 0.02
    assert random.trustworthiness[20] == pytest.approx(0.5, abs=0.05)
    assert random.neighbours_to_random == pytest.approx(1.0, abs=0.05)
    assert max(random.linear_r2.values()) < 0.02
    assert max(random.nonlinear_r2.values()) < 0.02
    assert random.orientation_error == pytest.approx(90.0, abs=6.0)
    assert random.intrinsic_dimension == pytest.approx(4.0, abs=0.5)


def test_rotation_and_scale_of_the_codes_change_nothing(isometric):
    again = topology(1e-3 * rotated(POINTS, seed=8), DISPLACEMENTS, rng(1).normal(size=(NUM, 12)))
    for key, one in isometric.items():
        if key == "total_code_variance":
            assert one == pytest.approx(1e6 * again[key])
        elif key != "winding_number":
            assert one == pytest.approx(again[key], rel=1e-3, abs=1e-4), key


def test_the_order_of_the_samples_changes_nothing_but_the_split():
    order = rng(5).permutation(NUM)
    codes = rotated(POINTS) + 0.1 * rng(6).normal(size=(NUM, 10))
    motors = rng(1).normal(size=(NUM, 12))
    one = topology(codes, DISPLACEMENTS, motors)
    other = topology(codes[order], DISPLACEMENTS[order], motors[order])
    for key, value in other.items():
        if key != "loop_persistence":  # which looks at some of the codes
            assert value == pytest.approx(one[key], rel=0.05, abs=0.01), key


def test_codes_that_copy_the_motors_are_recognised():
    motors = rng(1).normal(size=(NUM, 4))
    turns = motors[:, 2:].sum(axis=1, keepdims=True)
    moved = np.concatenate([motors[:, :2], turns], axis=1)
    found = topology(motors, moved, motors)
    assert found.partial_motors > 0.99
    assert found.semipartial_motors > 0.2
    assert found.partial_displacement < found.rank_correlation


def test_codes_that_have_collapsed_but_for_three_rows_are_measured():
    codes = np.zeros((NUM, 3))
    codes[:3] = np.eye(3)
    found = topology(codes, DISPLACEMENTS, rng(1).normal(size=(NUM, 4)))
    assert abs(found.rank_correlation) < 0.1 and abs(found.partial_motors) < 0.1
    assert max(found.linear_r2.values()) < 0.02
    assert "intrinsic_dimension" not in found
    equal = distances.rank_correlations(np.ones(5), np.arange(5.0), np.arange(5.0) ** 2)
    np.testing.assert_allclose(equal, [[0, 0, 0], [0, 1, 1], [0, 1, 1]], atol=1e-12)


def test_a_folded_code_tears_nothing_and_is_not_to_be_trusted():
    folded = POINTS * np.array([1.0, 1.0, 1.0, 0.0])
    found = topology(folded + 1e-9 * rng().normal(size=folded.shape), DISPLACEMENTS)
    assert found.linear_r2["sin"] < 0.02
    assert found.continuity[20] > 0.97
    assert found.trustworthiness[20] < 0.96
    assert "partial_motors" not in found and "equivalence_auc" not in found


@pytest.mark.slow
def test_a_large_sample_is_measured_on_subsets_with_a_standard_error():
    many = displacements(num=6000, seed=4)
    points = displacement_coordinates(many).points
    codes = points + 0.2 * rng(4).normal(size=points.shape)
    found = topology(codes, many)
    whole = distances.rank_correlations(
        distances.centred_distances(codes[:3000]), distances.centred_distances(points[:3000])
    )[0, 1]
    estimate = found.rank_correlation
    assert 0 < estimate.standard_error < 0.01
    assert abs(estimate - whole) < 6 * estimate.standard_error + 0.003


def test_equal_weights_of_translation_and_orientation():
    points, weight = displacement_coordinates(DISPLACEMENTS)
    assert points[:, :2].var(axis=0).sum() == pytest.approx(points[:, 2:].var(axis=0).sum())
    assert displacement_coordinates(DISPLACEMENTS, weight=2.0).weight == 2.0
    assert 1.0 < weight < 2.0


def test_the_published_topology_error_by_hand():
    codes, true = np.array([1.0, 2.0, 4.0]), np.array([0.0, 1.0, 2.0])
    by_hand = (0.25 * 1 + 0.5 * np.exp(-25) + 1.0 * np.exp(-50)) / 3
    assert distances.topology_error(codes, true) == pytest.approx(by_hand)


def test_partial_correlation_of_a_common_cause_vanishes():
    cause = rng().normal(size=100_000)
    one, other = (cause + rng(seed).normal(size=cause.shape) for seed in (1, 2))
    correlations = np.corrcoef([one, other, cause])
    assert correlations[0, 1] > 0.45
    assert abs(distances.partial(correlations)) < 0.02


GROUPS = np.repeat(np.arange(200), 6)


def test_equivalence_of_shared_codes_and_of_unrelated_ones():
    shared = rng().normal(size=(200, 5))[GROUPS]
    unrelated = rng(1).normal(size=(1200, 5))
    motors = rng(2).normal(size=(1200, 8))
    assert equivalence.equivalence_ratio(shared, GROUPS) == pytest.approx(0.0)
    assert equivalence.equivalence_auc(shared, motors, GROUPS) == pytest.approx(1.0)
    assert equivalence.equivalence_ratio(unrelated, GROUPS) == pytest.approx(1.0, abs=0.05)
    assert equivalence.equivalence_auc(unrelated, motors, GROUPS) == pytest.approx(0.5, abs=0.05)


def test_collapsed_codes_gain_nothing():
    motors = rng(2).normal(size=(1200, 8))
    collapsed = np.full((1200, 5), 0.3)
    assert np.isnan(equivalence.equivalence_ratio(collapsed, GROUPS))
    assert equivalence.equivalence_auc(collapsed, motors, GROUPS) == pytest.approx(0.5)
    nearly = collapsed + 1e-6 * rng().normal(size=collapsed.shape)
    assert equivalence.equivalence_ratio(nearly, GROUPS) == pytest.approx(1.0, abs=0.1)


def test_codes_that_copy_the_motors_do_not_tell_equivalent_pairs():
    # Equivalent sequences have near motors here, so that distance alone would do.
    motors = rng().normal(size=(200, 8))[GROUPS] + 0.5 * rng(1).normal(size=(1200, 8))
    crowded = np.concatenate([motors, motors[::-1] + 0.01 * rng(2).normal(size=motors.shape)])
    groups = np.concatenate([GROUPS, np.full(1200, -1)])
    assert equivalence.equivalence_auc(crowded, crowded, groups) < 0.75


def test_rows_that_occur_once_are_in_no_group():
    labels = equivalence.equal_rows(np.array([[1.0, 2], [3, 4], [1.0002, 2], [5, 6]]))
    assert labels[0] == labels[2] >= 0
    assert labels[1] == labels[3] == -1


@pytest.mark.parametrize("times", [1, -1, 2])
def test_codes_wind_as_often_as_they_go_round(times):
    turns = rng().uniform(-np.pi, np.pi, 2000)
    codes = np.stack([np.cos(times * turns), np.sin(times * turns)], axis=1)
    assert abs(circle.winding_number(codes, turns)) == abs(times)


def test_an_arc_and_a_segment_do_not_wind():
    turns = rng().uniform(-1, 1, 2000)
    codes = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    assert circle.winding_number(codes, turns) == 0


def test_the_seam_of_a_circle_and_of_an_arc():
    whole = displacements(num=4000, seed=9)
    points, turns = displacement_coordinates(whole).points, whole[:, 2]
    assert circle.seam_gap(rotated(points), points, turns) == pytest.approx(1.0, abs=1e-6)
    assert circle.seam_gap(whole, points, turns) > 10
    assert np.isnan(circle.seam_gap(points, points, 0.5 * turns))


def test_persistence_separates_a_circle_from_a_line_a_disc_and_a_torus():
    angles = np.linspace(0, 2 * np.pi, 160, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    assert circle.loop_persistence(ring) > 0.9
    assert circle.loop_persistence(np.stack([angles, 0 * angles], axis=1)) < 0.1
    disc = ring * np.sqrt(rng().uniform(size=(160, 1)))
    assert circle.loop_persistence(disc) < 0.3
    other = rng(1).uniform(0, 2 * np.pi, 160)
    torus = np.concatenate([ring, np.stack([np.cos(other), np.sin(other)], axis=1)], axis=1)
    assert circle.loop_persistence(torus) < 0.5


def test_circular_measures_by_hand():
    turns = rng().uniform(-np.pi, np.pi, 500)
    assert circle.circular_error(turns + 2 * np.pi, turns) == pytest.approx(0.0, abs=1e-9)
    assert circle.circular_error(turns + np.pi / 2, turns) == pytest.approx(90.0)
    assert circle.circular_correlation(turns + 0.4, turns) == pytest.approx(1.0)
    assert circle.circular_correlation(-turns, turns) == pytest.approx(-1.0, abs=0.1)


def test_dimensions_of_a_plane_in_ten_dimensions():
    plane = rotated(rng().normal(size=(3000, 2)))
    assert dimension.intrinsic_dimension(plane) == pytest.approx(2.0, abs=0.15)
    assert dimension.participation_ratio(plane) == pytest.approx(2.0, abs=0.02)
    assert dimension.components_for(plane) == 2


def test_composition_that_is_linear_bilinear_or_none():
    first, second = rng(1).normal(size=(2, 2000, 3))
    added = composition.composition_errors(first, second, first + second)
    assert added["linear"] < 1e-4 and added["bilinear"] < 1e-3
    product = composition.composition_errors(first, second, first * second)
    assert product["linear"] > 0.9 and product["bilinear"] < 1e-3 and product["network"] < 0.2
    unrelated = composition.composition_errors(first, second, rng(2).normal(size=(2000, 3)))
    assert unrelated["linear"] == pytest.approx(1.0, abs=0.1)


def test_congruence_is_0_where_the_code_says_all_and_1_where_it_says_nothing():
    codes = rng().normal(size=(2000, 3))
    assert composition.congruence_error(codes, codes) == 0.0
    unrelated = rng(1).normal(size=(2000, 3))
    assert composition.congruence_error(codes, unrelated) == pytest.approx(1.0, abs=0.05)


def test_an_accelerator_finds_the_same_distances(monkeypatch):
    points = rng().normal(size=(40, 7)) + 100.0
    ours = distances.centred_distances(points)
    monkeypatch.setattr("motorspace._devices.on_accelerator", lambda: True)
    theirs = distances.centred_distances(points)
    assert theirs.shape == (40 * 39 // 2,) and not np.array_equal(ours, theirs)
    np.testing.assert_allclose(theirs, ours, rtol=1e-5)
