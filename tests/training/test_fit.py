"""The training loop on problems whose answer is known."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.models.config import ModelConfig
from motorspace.models.losses import (
    code_variance,
    composition_loss,
    encode_all,
    encode_last_two,
    inverse_loss,
    noisy,
    penalty_loss,
    prediction_loss,
    slowness_loss,
    spread,
)
from motorspace.models.model import UNSCALED, Extras, Scaling, build_model
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Given, Simulated
from motorspace.training.fit import fit, init, most_promising, task_of
from motorspace.training.program import train_epochs
from motorspace.training.sources import simulator
from motorspace.trajectories.transitions import Experience

SMALL = TrainingConfig(epochs=30, trajectories_per_epoch=512, batch_size=64, learning_rate=3e-3)
SCALING = Scaling((1.0,), (1.0,))
NETWORK = ModelConfig(hidden_size=16, code_size=4, width_size=32, depth=2)


def configured(training: TrainingConfig = SMALL, network: ModelConfig = NETWORK) -> RunConfig:
    """A run on the experience that the test passes."""
    return RunConfig(Given(), network, training)


def linear_experience(num: int) -> Experience:
    """Sensors that move by the sum of the commands: a displacement they reveal linearly."""
    sensors_key, motors_key = jax.random.split(jax.random.key(0))
    sensors = jax.random.uniform(sensors_key, (num, 1), minval=-1.0)
    motors = jax.random.uniform(motors_key, (num, 3, 1), minval=-1.0)
    return Experience(sensors, motors, jnp.full(num, 3), sensors + motors.sum(axis=1))


def test_fit_learns_what_the_sensors_reveal():
    experience = linear_experience(4096)
    config = configured()
    state = init(config, SCALING, horizon=3)
    before = prediction_loss(state.model, experience, encode_all(state.model, experience))
    trained = fit(config, state, experience).model
    after = prediction_loss(trained, experience, encode_all(trained, experience))
    unmoved = jnp.mean((experience.later_sensors - experience.sensors) ** 2)
    assert after < 0.02 * unmoved
    assert after < before


def test_a_model_without_motors_cannot_beat_the_spread_of_the_displacement():
    experience = linear_experience(4096)
    config = configured(network=replace(NETWORK, encoder="none"))
    state = init(config, SCALING, horizon=3)
    trained = fit(config, state, experience).model
    error = prediction_loss(trained, experience, encode_all(trained, experience))
    assert error > 0.8 * jnp.var(experience.motors.sum(axis=1))


def test_an_untrained_encoder_stays_as_it_was():
    other_losses = {"composition_weight": 1.0, "isometry_weight": 1.0}
    network = replace(NETWORK, encoder="matrix_product", code_size=6)
    config = configured(replace(SMALL, epochs=2, train_encoder=False, **other_losses), network)
    state = init(config, SCALING, horizon=3)
    trained = fit(config, state, linear_experience(512)).model
    for before, after in zip(
        jax.tree.leaves(state.model.encoder), jax.tree.leaves(trained.encoder), strict=True
    ):
        np.testing.assert_array_equal(before, after)
    assert not jnp.array_equal(
        state.model.predictor.mlp.layers[0].weight, trained.predictor.mlp.layers[0].weight
    )


def test_a_loss_that_is_not_finite_stops_the_run():
    experience = linear_experience(512)
    broken = replace_sensors(experience, experience.sensors.at[:256].set(jnp.inf))
    seen = []
    config = configured()
    state = init(config, SCALING, horizon=3)
    with pytest.raises(UserError, match="no longer finite after epoch 1; lower the learning rate"):
        fit(config, state, broken, callback=lambda s, r: seen.extend(r))
    assert seen == []


def replace_sensors(experience: Experience, sensors: jax.Array) -> Experience:
    return Experience(sensors, experience.motors, experience.num_steps, experience.later_sensors)


def test_the_inverse_loss_does_not_reward_smaller_codes():
    experience = linear_experience(256)
    extras = Extras(inverse=True)
    model = build_model(NETWORK, SCALING, horizon=3, extras=extras, key=jax.random.key(0))
    codes = jax.random.uniform(jax.random.key(1), (256, 4))
    shrunk = 0.5 + 0.1 * (codes - 0.5)
    assert inverse_loss(model, experience, shrunk) > inverse_loss(model, experience, codes)
    assert float(code_variance(shrunk)) == pytest.approx(
        0.01 * float(code_variance(codes)), rel=1e-4
    )


def test_slowness_prefers_slow_features_and_more_than_one():
    """Of two random walks, the codes of where they stand beat those of their last steps."""
    steps = jax.random.normal(jax.random.key(2), (4000, 6, 2))
    places = jnp.cumsum(steps, axis=1)
    both, one = (lambda p: 0.1 * p), (lambda p: p * jnp.array([[1.0, 0.01]]))
    slow = {
        "both places": slowness_loss(both(places[:, 5]), both(places[:, 4])),
        "one place": slowness_loss(one(places[:, 5]), one(places[:, 4])),
        "last step": slowness_loss(steps[:, 5], steps[:, 4]),
    }
    assert slow["both places"] < slow["one place"] < slow["last step"]
    # A walk of six steps varies by 6 and moves by 1 in each direction.
    np.testing.assert_allclose(slow["one place"], 1 / 6, rtol=0.1)
    np.testing.assert_allclose(slow["both places"], 1 / 6 * 2**-0.35, rtol=0.1)
    scaled = slowness_loss(3 * both(places[:, 5]), 3 * both(places[:, 4]))
    np.testing.assert_allclose(scaled, slow["both places"], rtol=1e-3)


@pytest.mark.parametrize("encoder", ["lstm", "attention", "matrix_product"])
def test_composition_is_judged_by_the_halves_of_a_sequence_and_one_command_has_none(encoder):
    network, extras = replace(NETWORK, encoder=encoder, code_size=6), Extras(composition=True)
    model = build_model(network, SCALING, horizon=3, extras=extras, key=jax.random.key(0))
    given = linear_experience(64)
    codes = encode_all(model, given)
    loss = composition_loss(model, given, codes)
    assert 0 < float(loss) < np.inf
    first, second = (
        jax.vmap(model.encode)(motors, jnp.full(64, num))
        for motors, num in ((given.motors, 2), (given.motors[:, 2:], 1))
    )
    by_hand = jnp.sum((codes - jax.vmap(model.composition)(first, second)) ** 2, axis=1).mean()
    assert loss == pytest.approx(float(by_hand / spread(codes)), rel=1e-4)
    alone = replace_steps(given, 1)
    assert composition_loss(model, alone, encode_all(model, alone)) == 0.0
    slope = eqx.filter_jit(
        eqx.filter_grad(lambda m: composition_loss(m, alone, encode_all(m, alone)))
    )
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(slope(model)))


def test_commands_are_made_to_keep_lengths_once_the_curriculum_is_over():
    experience = linear_experience(512)
    network = replace(NETWORK, encoder="matrix_product", code_size=6)
    training = replace(SMALL, epochs=16, curriculum=0.5, isometry_weight=1.0)
    config, lost = configured(training, network), []

    def callback(state, _):
        lost.append(float(penalty_loss(state.model, experience)))

    state = init(config, SCALING, horizon=3)
    model = fit(config, state, experience, callback=callback, every=1).model
    assert lost[15] < 0.2 * min(lost[:8])
    matrices, _ = jax.vmap(model.encoder.matrices)(experience.motors.reshape(-1, 1))
    linear = np.asarray(matrices)[:, :-1, :-1]
    stretched = [np.linalg.svd(part, compute_uv=False) ** 2 - 1 for part in linear]
    by_hand = np.mean(np.sum(np.square(stretched), axis=1))
    assert penalty_loss(model, experience) == pytest.approx(by_hand, rel=1e-3)
    lstm = build_model(NETWORK, SCALING, horizon=3, key=jax.random.key(0))
    assert penalty_loss(lstm, experience) == 0.0


def replace_steps(experience: Experience, num: int) -> Experience:
    steps = jnp.full(len(experience), num)
    return eqx.tree_at(lambda e: e.num_steps, experience, steps)


@pytest.mark.parametrize("encoder", ["lstm", "gru", "sum", "mlp"])
def test_the_code_before_the_last_command_is_that_of_the_shorter_sequence(encoder):
    network = replace(NETWORK, encoder=encoder)
    model = build_model(network, SCALING, horizon=3, key=jax.random.key(0))
    experience = linear_experience(32)
    codes, earlier = encode_last_two(model, experience)
    np.testing.assert_allclose(codes, encode_all(model, experience), atol=1e-6)
    shorter = jax.vmap(model.encode)(experience.motors.at[:, 2].set(0.0), jnp.full(32, 2))
    np.testing.assert_allclose(earlier, shorter, atol=1e-6)
    assert np.abs(codes - earlier).max() > 1e-3


def test_the_curriculum_grows_the_sequences_and_ends():
    simulation = Simulated(horizon=4, layout="empty")
    training = replace(SMALL, epochs=10, curriculum=0.4)
    draw = simulator(RunConfig(simulation, training=training))
    longest = [
        int(draw(jax.random.key(0), jnp.array(epoch)).experience.num_steps.max())
        for epoch in range(5)
    ]
    assert longest == [1, 2, 3, 4, 4]
    final = draw(jax.random.key(0), jnp.array(4)).experience.num_steps
    assert (final == 4).all()


def test_noise_is_relative_to_what_each_unit_of_the_code_varies():
    wide, narrow = jax.random.normal(jax.random.key(0), (2, 20_000, 1))
    codes = jnp.concatenate([5 * wide, 0.1 * narrow, jnp.ones_like(wide)], axis=1)
    added = noisy(codes, jnp.array(0.3), key=jax.random.key(1)) - codes
    np.testing.assert_allclose(added.std(axis=0), [1.5, 0.03, 0.0], rtol=0.03, atol=1e-4)
    assert abs(np.corrcoef(added[:, 0], codes[:, 0])[0, 1]) < 0.03


@pytest.mark.parametrize(("curriculum", "same"), [(1.0, False), (0.0, True)])
def test_noise_on_the_code_ends_with_the_curriculum(curriculum, same):
    experience = linear_experience(512)
    plain = replace(SMALL, epochs=2, curriculum=curriculum)
    losses = []
    for training in (plain, replace(plain, code_noise=1.0)):
        config = configured(training)
        state = init(config, SCALING, horizon=3).with_scaling(UNSCALED)
        _, records = train_epochs(state, task_of(config, SCALING, experience), jnp.int32(1))
        losses.append(float(records.prediction_loss[0]))
    assert (losses[0] == losses[1]) is same


def test_what_predicts_the_validation_data_best_is_kept():
    """Noise as sensors: the network learns them by heart and gets worse on other ones."""
    experience = linear_experience(640)
    noise = jax.random.normal(jax.random.key(2), experience.sensors.shape)
    noisy = Experience(
        experience.sensors,
        experience.motors,
        experience.num_steps,
        experience.later_sensors + noise,
    )
    train, validation = noisy[:64], noisy[64:]
    config, log = configured(), []
    state = init(config, SCALING, horizon=3, validated=True)
    state = fit(config, state, train, validation=validation, callback=lambda s, r: log.extend(r))
    errors = [record["validation_loss"] for record in log]
    assert state.best_error == pytest.approx(min(errors))
    selected = prediction_loss(state.selected, validation, encode_all(state.selected, validation))
    assert selected == pytest.approx(min(errors), rel=1e-5)
    assert min(errors) < 0.95 * errors[-1]


def test_averaged_weights_are_the_mean_over_updates():
    one_update = replace(SMALL, epochs=1, trajectories_per_epoch=64, batch_size=64)
    config = configured(replace(one_update, schedule="constant", ema_decay=0.75))
    start = init(config, SCALING, horizon=3)
    after = fit(config, start, linear_experience(64))
    models = (start.model, after.model, after.selected)
    begun, ended, averaged = (m.predictor.mlp.layers[0].weight for m in models)
    assert not jnp.array_equal(begun, ended)
    np.testing.assert_allclose(averaged, 0.75 * begun + 0.25 * ended, rtol=1e-5, atol=1e-7)


def test_of_several_restarts_the_one_that_predicts_best_at_first_is_trained():
    """One of them is trained for the whole run, as if it were the only one."""
    experience = linear_experience(512)
    training = replace(SMALL, restarts=3, seed=4)
    alone = configured(replace(training, restarts=1))
    tried, logs = [], []
    for restart in range(3):
        log = []
        state = init(alone, SCALING, horizon=3, restart=restart)
        state = fit(alone, state, experience, callback=lambda s, r, log=log: log.extend(r))
        tried.append(state)
        logs.append(log)
    early = [log[training.trial_epochs - 1]["prediction_loss"] for log in logs]
    assert training.trial_epochs == 3
    assert len(set(early)) == 3
    best = early.index(min(early))
    assert best != 0, "the seed is one at which restarting helps"
    config, log = configured(training), []
    state = init(config, SCALING, horizon=3)
    state = fit(config, state, experience, callback=lambda s, r: log.extend(r))
    assert log == logs[best]
    for got, wanted in zip(
        jax.tree.leaves(state.model), jax.tree.leaves(tried[best].model), strict=True
    ):
        np.testing.assert_array_equal(got, wanted)


def test_a_restart_whose_loss_is_not_finite_is_no_better_than_others():
    experience = linear_experience(512)
    config = configured(replace(SMALL, restarts=2, epochs=2))
    first, second = (init(config, SCALING, horizon=3, restart=restart) for restart in (0, 1))
    broken = eqx.tree_at(
        lambda s: s.model.predictor.mlp.layers[0].weight, first, replace_fn=lambda w: w * jnp.nan
    )
    task = task_of(config, SCALING, experience)
    (chosen,) = most_promising([config], [broken], [task])
    assert jnp.array_equal(
        chosen.model.predictor.mlp.layers[0].weight, second.model.predictor.mlp.layers[0].weight
    )


def test_without_resampling_every_epoch_sees_the_same_trajectories():
    simulation = Simulated(horizon=2, layout="empty")
    training = replace(SMALL, epochs=10, curriculum=0.0)
    for fresh in (True, False):
        config = RunConfig(simulation, training=replace(training, resample_each_epoch=fresh))
        draw = simulator(config)
        first, second = (draw(jax.random.key(n), jnp.array(n)).experience.motors for n in (0, 1))
        assert jnp.array_equal(first, second) == (not fresh)
