"""Probes on codes whose structure is known."""

import numpy as np
import pytest

from motorspace.analysis.equivalence import within_to_total_variance
from motorspace.analysis.probes import displacement_targets, linear_probe

RNG = np.random.default_rng(0)


def test_a_linear_map_of_the_target_is_decoded_perfectly_and_noise_not_at_all():
    targets = RNG.normal(size=(2000, 3))
    codes = targets @ RNG.normal(size=(3, 10))
    perfect = linear_probe(codes[:1000], targets[:1000], codes[1000:], targets[1000:])
    np.testing.assert_allclose(perfect, 1.0, atol=1e-6)
    noise = RNG.normal(size=(2000, 10))
    nothing = linear_probe(noise[:1000], targets[:1000], noise[1000:], targets[1000:])
    assert (np.asarray(nothing) < 0.02).all()


def test_collapsed_codes_decode_nothing():
    targets = RNG.normal(size=(200, 2))
    collapsed = np.full((200, 5), 0.3)
    r2 = linear_probe(collapsed[:100], targets[:100], collapsed[100:], targets[100:])
    assert (np.asarray(r2) < 0.05).all()


def test_within_to_total_variance_on_closed_forms():
    groups = np.repeat(np.arange(10), 50).astype(float)
    shared = np.stack([groups, -groups], axis=1)
    assert within_to_total_variance(shared, groups) == pytest.approx(0.0)
    alternating = np.tile([1.0, -1.0], 250)[:, None]
    assert within_to_total_variance(alternating, groups) == pytest.approx(1.0)
    assert np.isnan(within_to_total_variance(np.ones((500, 2)), groups))


def test_displacement_targets_are_continuous_across_half_a_turn():
    before, after = displacement_targets(np.array([[1.0, 2.0, np.pi], [1.0, 2.0, -np.pi]]))
    np.testing.assert_allclose(before, after, atol=1e-6)
