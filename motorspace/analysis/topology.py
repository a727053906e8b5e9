"""How does the structure of codes compare with that of displacements? Every measure in one call."""

import importlib.util
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from motorspace.analysis import circle, dimension, distances, equivalence, neighbours
from motorspace.analysis.coordinates import (
    COMPONENTS,
    Numbers,
    Points,
    displacement_coordinates,
)
from motorspace.analysis.inputs import checked, checked_groups, checked_options, moderate
from motorspace.analysis.probes import explained, linear_decoder, neighbour_probe
from motorspace.analysis.report import Estimate, Estimates, Topology, over_subsets, report

SUBSET_SIZE = 2000
RANKED_SIZE = 1000
"""Points of a subset whose pairs are ranked, which takes longest."""
MOST_NEIGHBOUR_POINTS = 20_000
NEIGHBOURHOODS = (10, 20, 50)
PARTIAL = {
    "partial_displacement": (distances.partial, (0, 1, 2)),
    "partial_motors": (distances.partial, (0, 2, 1)),
    "partial_motors_affine": (distances.partial, (3, 2, 1)),
    "semipartial_motors": (distances.semipartial, (0, 2, 1)),
}
"""Which two of codes, displacements, motors and affine images are correlated, the third fixed."""
SMALL_TRANSLATION = 0.1
"""Share of the points, those of the smallest translation, in which a circle is looked for."""


def topology(
    codes: ArrayLike,
    displacements: ArrayLike,
    motors: ArrayLike | None = None,
    groups: ArrayLike | None = None,
    *,
    weight: float | None = None,
    subsets: int = 5,
    seed: int = 0,
) -> Topology:
    """Returns a report on how the structure of N codes follows that of their displacements.

    Measures of pairs are means over random subsets of `SUBSET_SIZE` points, with the standard
    error of drawing them. What cannot be measured is left out: without `motors` whether codes
    copy them; without equivalent sequences whether these share a code; without the extra
    `topology` persistent homology and intrinsic dimension.

    Args:
        codes: [N, ...], any numbers, from any encoder.
        displacements: [N, 3]: longitudinal, lateral (world units), orientation change (radians).
        motors: [N, ...], the motor commands behind each code.
        groups: [N] whole numbers: sequences of equal number are equivalent, negative ones are in
            no group. By default displacements that agree to a thousandth are equivalent.
        weight: World units that a unit of (cos, sin) of the orientation change counts for. By
            default orientation has as much variance as translation.
        subsets: How many subsets to draw.
        seed: Seed of the subsets.

    Raises:
        CollapsedCodesError: For codes that are all the same.
        UserError: For fewer than a hundred points, rows that do not belong together, and values
            that are no finite real numbers.

    Example:
        >>> import numpy as np
        >>> displacements = np.random.default_rng(0).uniform(-1, 1, (200, 3))
        >>> report = topology(displacements @ np.eye(3, 5), displacements)
        >>> report["linear_r2.lateral"] > 0.99
        True
    """
    h, d, m = checked(codes, displacements, motors)
    checked_options(weight, subsets, seed)
    h, scale = moderate(h)
    labels = equivalence.equal_rows(d) if groups is None else checked_groups(groups, len(h))
    coordinates = displacement_coordinates(d, weight=weight)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(h))
    drawn = [order]
    if len(h) > SUBSET_SIZE:
        drawn = [rng.choice(len(h), SUBSET_SIZE, replace=False) for _ in range(subsets)]
    some = order[:MOST_NEIGHBOUR_POINTS]
    sample = Sample(h, scale, d, coordinates.points, m, labels, drawn, some, seed)
    estimates = {key: one for family in FAMILIES for key, one in family(sample).items()}
    return report(len(h), coordinates.weight, seed, estimates)


class Sample(NamedTuple):
    """What every family of measures is taken on."""

    codes: Points
    scale: float
    """By what the codes were divided."""
    displacements: Float[np.ndarray, "N 3"]
    points: Points
    """Coordinates of the displacements."""
    motors: Points | None
    groups: equivalence.Labels
    subsets: list[np.ndarray]
    some: np.ndarray
    """The points whose neighbours are looked for in all of them, in random order."""
    seed: int


def variance(sample: Sample) -> Estimates:
    """Returns how much the codes vary, and in how many components."""
    h = sample.codes
    return {
        "total_code_variance": Estimate(h.var(axis=0).sum() * sample.scale**2),
        "participation_ratio": Estimate(dimension.participation_ratio(h)),
        "components_95": Estimate(float(dimension.components_for(h))),
    }


def shared_codes(sample: Sample) -> Estimates:
    """Returns whether equivalent sequences share a code; nothing where there are none."""
    if not (sample.groups >= 0).any():
        return {}
    ratio = equivalence.equivalence_ratio(sample.codes, sample.groups)
    found = {"equivalence_ratio": Estimate(ratio)}
    if sample.motors is not None:
        auc = equivalence.equivalence_auc(
            sample.codes, sample.motors, sample.groups, seed=sample.seed
        )
        found["equivalence_auc"] = Estimate(auc)
    return found


def pairs(sample: Sample) -> Estimates:
    """Returns whether codes lie apart as their displacements do, and as their motors do."""
    h, p, m = sample.codes, sample.points, sample.motors

    def take(rows: np.ndarray) -> dict[str, float]:
        # The linear map is fitted on other points, where there are some.
        others = np.setdiff1d(np.arange(len(h)), rows) if len(rows) < len(h) else rows
        decoded = linear_decoder(h[others], p[others])(h[rows])
        between = distances.centred_distances
        dh, dp, dq = between(h[rows]), between(p[rows]), between(decoded)
        few = rows[:RANKED_SIZE]
        kinds = [h[few], p[few]]
        if m is not None:
            affine = linear_decoder(p[others], h[others], ridge=1e-12)
            kinds += [m[few], affine(p[few])]
        ranks = distances.rank_correlations(*map(between, kinds))
        partial = PARTIAL.items() if m is not None else ()
        return {
            "rank_correlation": float(ranks[0, 1]),
            **{
                key: correlation(ranks[np.ix_(order, order)])
                for key, (correlation, order) in partial
            },
            "topology_error": distances.topology_error(dh, dp),
            "normalised_topology_error": distances.normalised_topology_error(dh, dp),
            "metric_error": distances.metric_error(dq, dp),
        }

    return over_subsets(take, sample.subsets)


def near_points(sample: Sample) -> Estimates:
    """Returns whether neighbours among the codes are neighbours among the displacements."""
    h, p = sample.codes, sample.points

    def take(rows: np.ndarray) -> dict[str, float]:
        near = neighbours.neighbour_error(h[rows], p[rows])
        sizes = [k for k in NEIGHBOURHOODS if 2 * k < len(rows)]
        trust, continuity = neighbours.trustworthiness, neighbours.continuity
        return (
            {f"trustworthiness.{k}": trust(h[rows], p[rows], k=k) for k in sizes}
            | {f"continuity.{k}": continuity(h[rows], p[rows], k=k) for k in sizes}
            | {"neighbours_to_random": near.to_random, "neighbours_to_floor": near.to_floor}
        )

    return over_subsets(take, sample.subsets)


def probes(sample: Sample) -> Estimates:
    """Returns how well displacements are decoded from codes, fitted on half of the points."""
    h, d = sample.codes, sample.displacements
    p = displacement_coordinates(d, weight=1.0).points
    train, test = np.array_split(sample.some, 2)
    decoded, turns = linear_decoder(h[train], p[train])(h[test]), d[test, 2]
    angles = np.arctan2(decoded[:, 3], decoded[:, 2])
    return {
        **_by_component("linear_r2", explained(decoded, p[test])),
        **_by_component("nonlinear_r2", neighbour_probe(h[train], p[train], h[test], p[test])),
        "orientation_error": Estimate(circle.circular_error(angles, turns)),
        "circular_correlation": Estimate(circle.circular_correlation(angles, turns)),
    }


def _by_component(key: str, values: Numbers) -> Estimates:
    """One measure for each component of the displacement, and that of the worst."""
    found = {
        f"{key}.{name}": Estimate(float(v)) for name, v in zip(COMPONENTS, values, strict=True)
    }
    return found | {f"{key}.worst": min(found.values())}


def closing(sample: Sample) -> Estimates:
    """Returns whether orientation closes into a circle."""
    h, d = sample.codes, sample.displacements
    translation = np.hypot(d[:, 0], d[:, 1])
    small = np.argsort(translation)[: max(100, round(SMALL_TRANSLATION * len(h)))]
    winding = {"winding_number": Estimate(circle.winding_number(h, d[:, 2]))}
    return winding | _with_extra(
        "gudhi", "loop_persistence", lambda: circle.loop_persistence(h[small])
    )


def dimensions(sample: Sample) -> Estimates:
    """Returns in how many dimensions the codes lie."""
    return _with_extra(
        "skdim",
        "intrinsic_dimension",
        lambda: dimension.intrinsic_dimension(sample.codes[sample.some]),
    )


FAMILIES: tuple[Callable[[Sample], Estimates], ...] = (
    shared_codes,
    probes,
    pairs,
    near_points,
    closing,
    dimensions,
    variance,
)
"""All that a report measures, in the order of its table."""


def _with_extra(module: str, key: str, take: Callable[[], float]) -> Estimates:
    """A measure that needs an extra; nothing without it."""
    return {key: Estimate(take())} if importlib.util.find_spec(module) else {}
