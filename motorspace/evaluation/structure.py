"""How an encoder structures motor sequences: what every row of the structure table measures."""

from contextlib import suppress
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float, Int

from motorspace._errors import UserError
from motorspace._types import Key
from motorspace.analysis import composition
from motorspace.analysis.circle import circular_error
from motorspace.analysis.coordinates import displacement_coordinates
from motorspace.analysis.equivalence import equal_rows, equivalence_auc, equivalence_ratio
from motorspace.analysis.probes import linear_decoder
from motorspace.analysis.topology import Topology, topology
from motorspace.evaluation.evaluate import evaluate
from motorspace.evaluation.prediction import Metrics
from motorspace.evaluation.sampling import present_data
from motorspace.evaluation.subject import (
    LENGTHS,
    Codes,
    Subject,
    commands,
    standard_form_of,
    subject_of,
)
from motorspace.training.data import Data, Given, Logged, base_of
from motorspace.training.run import Run
from motorspace.training.sources import logged_data
from motorspace.trajectories.commands import nominal
from motorspace.trajectories.equivalent import EquivalentSequences, equivalent_sequences

MEASURE_SEED = 3_000_017


class Sampled(NamedTuple):
    """Codes of random sequences, and how they are structured."""

    codes: Codes
    displacements: Float[np.ndarray, "N 3"]
    topology: Topology


def run_topology(
    run: Run, *, data: Data | None = None, seed: int = 0, standard: bool = False
) -> Sampled:
    """The report on a run's codes, equivalent sequences included.

    Of a run in simulation, on fresh random sequences and their nominal displacements; of one on
    a log, on the test blocks and the displacements that really happened.

    Args:
        run: The run.
        data: Where the data are now, if not where the configuration says (see `evaluate`).
        seed: Seed of what is drawn.
        standard: Whether codes are put into standard form.

    Raises:
        UserError: For a run on data of one's own, a log without poses, and codes that have no
            standard form.
    """
    data = present_data(run, data)
    if isinstance(base_of(data), Logged):
        return _on_test_blocks(run, data, seed=seed, standard=standard)
    subject = subject_of(run, standard=standard)
    found = sampled(subject, seed=seed)
    if "equivalence_ratio" in found.topology:
        return found
    measured = equivalence(subject, key=jax.random.key(seed))
    names = ("equivalence_ratio", "equivalence_auc")
    whole = {name: measured[name] for name in names if np.isfinite(measured[name])}
    return found._replace(topology=found.topology.updated(whole))


def _on_test_blocks(run: Run, data: Data, *, seed: int, standard: bool) -> Sampled:
    test, log = logged_data(data).test, base_of(data)
    assert isinstance(log, Logged), "the caller has made sure"
    motors, num_steps = test.experience.motors, test.experience.num_steps
    codes = np.asarray(run.encode(motors, num_steps), np.float64)
    if standard:
        codes = standard_form_of(run, np.asarray(motors[:, 0]))(codes)
    displacements = np.asarray(test.displacements.achieved, np.float64)
    if not np.isfinite(displacements).all():
        raise UserError(
            "the log holds no true poses, so displacements are not known",
            where=log.path,
            remedy="measure its codes beside displacements of your own: "
            "motorspace topology CODES DISPLACEMENTS",
        )
    return Sampled(codes, displacements, topology(codes, displacements, motors, seed=seed))


def structure(subject: Subject, *, seed: int) -> Metrics:
    """Every measure of the codes of fresh random sequences, and of those built to be equivalent.

    No world comes in: codes are compared with the displacements that the commands would cause
    with no walls.
    """
    keys = jax.random.split(jax.random.key(MEASURE_SEED + seed), 3)
    return (
        measures(subject, seed=seed)
        | equivalence(subject, key=keys[0])
        | compositions(subject, key=keys[1])
        | length_errors(subject, key=keys[2])
    )


def measures(subject: Subject, *, seed: int) -> Metrics:
    """The report on the codes of fresh random sequences as numbers by their keys."""
    return values(sampled(subject, seed=seed, subsets=1).topology)


def values(report: Topology) -> Metrics:
    """The measures of a report as plain numbers by their keys."""
    weight = {"orientation_weight": report.weight}
    return weight | {key: float(value) for key, value in report.items()}


def sampled(subject: Subject, *, seed: int, subsets: int = 5) -> Sampled:
    """The report on the codes of fresh random sequences."""
    key = jax.random.key(MEASURE_SEED - 1 - seed)
    motors = commands(subject, (subject.sizes.sequences, subject.horizon), key=key)
    codes, displacements = subject.encode(motors), nominal(subject.agent, motors)
    found = topology(codes, displacements, motors, subsets=subsets, seed=seed)
    return Sampled(codes, displacements, found)


def equivalence(subject: Subject, *, key: Key) -> Metrics:
    """Do sequences that lead to the same displacement share a code?

    Returns:
        `equivalence_ratio` and `equivalence_auc` of all groups, `equivalence.KIND` by what the
        members of a group differ in, and `equivalence.full_turns.N`: the mean squared distance
        of codes of the same group that differ by N whole turns, over that of all pairs.
    """
    made = _equivalent(subject, key=key)
    motors, groups, kinds, turns, names = made
    codes, flat = subject.encode(motors), motors.reshape(len(motors), -1)
    metrics: Metrics = {
        "equivalence_ratio": equivalence_ratio(codes, groups),
        "equivalence_auc": equivalence_auc(codes, flat, groups),
    }
    for index, name in enumerate(names):
        of_kind = np.where(kinds == index, groups, -1)
        metrics[f"equivalence.{name}"] = equivalence_ratio(codes, of_kind)
    if "full_turns" in names:
        chosen = kinds == names.index("full_turns")
        total = 2 * float(codes.var(axis=0).sum())
        metrics |= _by_turns(
            codes[chosen], turns[chosen], members=subject.sizes.members, total=total
        )
    return metrics


def _equivalent(subject: Subject, *, key: Key) -> EquivalentSequences:
    """Sequences built to be equivalent; where none can be built, those that happen to be."""
    agent, horizon = subject.agent, subject.horizon
    with suppress(UserError):
        return equivalent_sequences(
            agent,
            num_groups=subject.sizes.groups,
            members=subject.sizes.members,
            horizon=horizon,
            key=key,
        )
    motors = commands(subject, (subject.sizes.sequences, horizon), key=key)
    none = np.zeros(len(motors), int)
    groups = equal_rows(nominal(agent, motors))
    return EquivalentSequences(motors, groups, none, none, ())


def _by_turns(codes: Codes, turns: Int[np.ndarray, " N"], *, members: int, total: float) -> Metrics:
    h, n = codes.reshape(-1, members, codes.shape[1]), turns.reshape(-1, members)
    squares = ((h[:, :, None] - h[:, None]) ** 2).sum(axis=-1)
    apart = np.abs(n[:, :, None] - n[:, None])
    other = ~np.eye(members, dtype=bool)
    return {
        f"equivalence.full_turns.{count}": float(squares[(apart == count) & other].mean() / total)
        for count in range(int(apart.max()) + 1)
        if ((apart == count) & other).any()
    }


def compositions(subject: Subject, *, key: Key) -> Metrics:
    """Does the code of two sequences of half the horizon follow from their codes?"""
    encode, length = subject.encode, subject.horizon // 2
    if length == 0:
        return {}
    first, second = (
        commands(subject, (subject.sizes.composed, length), key=k) for k in jax.random.split(key)
    )
    both = encode(np.concatenate([first, second], axis=1))
    codes = encode(first)
    near = first[composition.nearest_other(codes)]
    left = encode(np.concatenate([near, second], axis=1))
    before = encode(np.concatenate([second, first], axis=1))
    right = encode(np.concatenate([second, near], axis=1))
    errors = composition.composition_errors(codes, encode(second), both)
    return {f"composition.{name}": error for name, error in errors.items()} | {
        "congruence.left": composition.congruence_error(both, left),
        "congruence.right": composition.congruence_error(before, right),
    }


def length_errors(subject: Subject, *, key: Key) -> Metrics:
    """Displacement errors at every length, of the linear map fitted at the full horizon.

    Returns:
        `length_error.translation.T` (root mean square, world units), `.orientation.T` (mean
        absolute, degrees) and `translation_size.T`, the translation's own root mean square;
        `length_ratio`, the translation's error at the longest length over that at six commands.
    """
    encode, agent = subject.encode, subject.agent
    fit_key, test_key = jax.random.split(key)
    motors = commands(subject, (subject.sizes.sequences, subject.horizon), key=fit_key)
    points = displacement_coordinates(nominal(agent, motors), weight=1.0).points
    fitted = encode(motors)
    decode = linear_decoder(fitted, points)
    metrics: Metrics = {}
    for length in (n for n in LENGTHS if n <= subject.longest):
        tested = commands(subject, (subject.sizes.sequences // 2, length), key=test_key)
        codes = encode(tested)
        if codes.shape[1] != fitted.shape[1]:
            return {}
        true, decoded = nominal(agent, tested), decode(codes)
        off = ((decoded[:, :2] - true[:, :2]) ** 2).sum(axis=1).mean() ** 0.5
        angles = np.arctan2(decoded[:, 3], decoded[:, 2])
        metrics |= {
            f"length_error.translation.{length}": float(off),
            f"length_error.orientation.{length}": circular_error(angles, true[:, 2]),
            f"translation_size.{length}": float((true[:, :2] ** 2).sum(axis=1).mean() ** 0.5),
        }
    longest, base = (f"length_error.translation.{n}" for n in (LENGTHS[-1], 6))
    ratio = {"length_ratio": metrics[longest] / metrics[base]} if longest in metrics else {}
    return metrics | ratio


def evaluate_with_structure(run: Run, *, num: int = 100_000, seed: int = 0) -> Metrics:
    """`evaluate`, and the report on the run's codes where its data allow one."""
    metrics = dict(evaluate(run, num=num))
    if isinstance(run.config.data, Given):
        return metrics
    try:
        return metrics | values(run_topology(run, seed=seed).topology)
    except UserError:  # the codes have collapsed, or a log holds no poses
        return metrics
