"""Errors of blurred views, and prediction of features, against what is known in closed form."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace.models.losses import (
    BLURS,
    blurred_loss,
    encode_all,
    latent_loss,
    prediction_loss,
)
from motorspace.models.model import Scaling, build_model
from motorspace.training.config import ModelConfig, RunConfig, TrainingConfig
from motorspace.training.data import Derived, Given, Simulated
from motorspace.training.fit import task_of
from motorspace.training.objective import extras_for, objective
from motorspace.training.recipe import Recipe
from motorspace.trajectories.transitions import Experience

NUM, PIXELS = 40, 12
SIZE = 3 * PIXELS
SMALL = ModelConfig(encoder="sum", hidden_size=4, code_size=4, width_size=8, depth=1)


PLAIN = TrainingConfig()


def model_for(training=PLAIN):
    scaling = Scaling((1.0,) * SIZE, (1.0,) * 2)
    return build_model(
        SMALL, scaling, horizon=2, extras=extras_for(training), key=jax.random.key(0)
    )


def batch(errors):
    """Transitions whose prediction is off by so much, given the model below."""
    random = np.random.default_rng(0)
    motors = jnp.asarray(random.normal(size=(NUM, 2, 2)), jnp.float32)
    sensors = jnp.asarray(random.uniform(-1, 1, (NUM, SIZE)), jnp.float32)
    steps = jnp.full(NUM, 2)
    model = model_for()
    blank = Experience(sensors, motors, steps, sensors)
    predicted = jax.vmap(model.predict)(sensors, encode_all(model, blank))
    return model, replace(blank, later_sensors=predicted - jnp.asarray(errors, jnp.float32))


def test_an_even_error_is_as_large_when_it_is_blurred():
    model, seen = batch(np.full((NUM, SIZE), 0.5))
    found = blurred_loss(model, seen, encode_all(model, seen), (PIXELS, 3))
    np.testing.assert_allclose(found, len(BLURS) * 0.25, rtol=1e-5)


@pytest.mark.parametrize("view", [(PIXELS, 3), (4, 3, 3), (SIZE,)])
def test_blurring_is_a_gaussian_mean_over_neighbours(view):
    errors = np.random.default_rng(1).normal(size=(NUM, *view))
    expected = 0.0
    for width in BLURS:
        blurred = errors
        for axis in range(1, max(2, errors.ndim - 1)):
            places = np.arange(errors.shape[axis])
            kernel = np.exp(-((places[:, None] - places) ** 2) / (2 * width**2))
            kernel /= kernel.sum(axis=1, keepdims=True)
            blurred = np.moveaxis(np.moveaxis(blurred, axis, -1) @ kernel.T, -1, axis)
        expected += float(np.mean(blurred**2))
    model, seen = batch(errors.reshape(NUM, -1))
    found = blurred_loss(model, seen, encode_all(model, seen), view)
    np.testing.assert_allclose(found, expected, rtol=1e-4)


def test_what_alternates_between_neighbours_is_hardly_seen():
    stripes = np.tile(np.repeat([1.0, -1.0], 3), PIXELS // 2)
    model, seen = batch(np.broadcast_to(stripes, (NUM, SIZE)))
    codes = encode_all(model, seen)
    assert float(prediction_loss(model, seen, codes)) == pytest.approx(1.0, rel=1e-5)
    assert float(blurred_loss(model, seen, codes, (PIXELS, 3))) < 0.05


LATENT = TrainingConfig(latent_weight=1.0, batch_size=NUM, trajectories_per_epoch=NUM)


def test_features_that_say_nothing_cost_most():
    """All zero: nothing to predict, and every standard deviation 1 too low."""
    model = model_for(LATENT)
    nothing = jax.tree.map(lambda leaf: 0 * leaf if eqx.is_array(leaf) else leaf, model.latent)
    _, seen = batch(np.zeros((NUM, SIZE)))
    codes = encode_all(model, seen)
    collapsed = float(latent_loss(replace(model, latent=nothing), seen, codes))
    assert collapsed == pytest.approx(0.99, abs=1e-3)
    assert latent_loss(replace(model, latent=None), seen, codes) == 0


def test_where_features_are_predicted_codes_learn_from_them_alone():
    """The error in sensors has no gradient in the encoder then, and has one otherwise."""
    _, seen = batch(np.random.default_rng(2).normal(size=(NUM, SIZE)))

    def encoders_gradient(training, weight):
        model, recipe = model_for(training), Recipe.of(training, (PIXELS, 3))
        recipe = eqx.tree_at(lambda r: r.weights, recipe, {n: weight for n in recipe.weights})
        arrays, fixed = eqx.partition(model, eqx.is_inexact_array)

        def loss(arrays):
            return objective(
                eqx.combine(arrays, fixed), seen, recipe, jnp.int32(0), key=jax.random.key(0)
            )[0]

        gradient = jax.grad(loss)(arrays)
        return max(float(jnp.abs(leaf).max()) for leaf in jax.tree.leaves(gradient.encoder))

    assert encoders_gradient(LATENT, jnp.float32(0)) == 0
    assert encoders_gradient(LATENT, jnp.float32(1)) > 1e-4
    blurred = replace(LATENT, latent_weight=0.0, blur_weight=1.0)
    assert encoders_gradient(blurred, jnp.float32(0)) > 1e-4


def test_what_is_no_view_is_blurred_side_by_side():
    """Ranges, data of one's own of which nothing is said, and displacements that are predicted."""
    blurred = TrainingConfig(blur_weight=1.0)
    seen = Simulated(sensor="retina")
    shapes = {
        (32, 3): (seen, 96),
        (9,): (Simulated(), 9),
        (7,): (Given(), 7),
        (1,): (Given(), 1),
        (4,): (Derived(seen, "supervised"), 4),
    }
    for shape, (data, num) in shapes.items():
        scaling = Scaling((1.0,) * num, (1.0, 1.0))
        config = RunConfig(data, training=blurred)
        assert task_of(config, scaling, lambda key, epoch: None).recipe.view == shape


def test_views_matter_to_the_program_only_where_they_are_blurred():
    blurred = TrainingConfig(blur_weight=0.5)
    assert Recipe.of(PLAIN, (PIXELS, 3)).view == ()
    assert Recipe.of(blurred, (PIXELS, 3)).view == (PIXELS, 3)
