"""How well are codes organised by displacement? Every measure, for anybody's codes, in one call."""

import importlib.util
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from motorspace._errors import UserError
from motorspace.analysis import circle, collapse, dimension, distances, neighbours
from motorspace.analysis.coordinates import (
    COMPONENTS,
    Numbers,
    Points,
    checked,
    displacement_coordinates,
)
from motorspace.analysis.probes import explained, linear_decoder, neighbour_probe

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


class Estimate(NamedTuple):
    """A measure on random subsets of the points: its mean, and the error of drawing them."""

    mean: float
    error: float
    """Standard error of the mean over the subsets; 0 where all points are measured at once."""


@dataclass(frozen=True)
class Topology:
    """How codes are organised by displacement. `rows` says what is perfect for each measure."""

    num_points: int
    weight: float
    """World units that a radian-like unit of (cos, sin) counts for."""
    seed: int
    code_variance: float
    collapse_ratio: float | None
    equivalence_auc: float | None
    topology_error: Estimate
    normalised_topology_error: Estimate
    metric_error: Estimate
    rank_correlation: Estimate
    partial_displacement: Estimate | None
    partial_motors: Estimate | None
    partial_motors_affine: Estimate | None
    """The same of A p + b, the part of the codes that is affine in displacement.

    Displacement itself has as much where its components weigh otherwise, or another point of the
    body is followed. What `partial_motors` has beyond it comes from codes that bend displacement,
    or know of the motors what displacement does not tell.
    """
    semipartial_motors: Estimate | None
    """What motors explain beyond displacement, of the codes' distances as a whole."""
    trustworthiness: dict[int, Estimate]
    continuity: dict[int, Estimate]
    neighbours_to_random: Estimate
    neighbours_to_floor: Estimate
    linear_r2: dict[str, float]
    nonlinear_r2: dict[str, float]
    orientation_error: float
    """Mean absolute error of the orientation change that a linear map decodes, degrees."""
    circular_correlation: float
    winding_number: float
    loop_persistence: float | None
    intrinsic_dimension: float | None
    participation_ratio: float
    components_95: int

    def rows(self) -> Iterator[tuple[str, float | None, float | None, str]]:
        """(measure, value, error by drawing subsets, what is perfect) of each measure."""
        for part in fields(self):
            value = getattr(self, part.name)
            name, perfect = part.name.replace("_", " "), PERFECT.get(part.name, "")
            if isinstance(value, dict):
                for key, one in value.items():
                    yield f"{name}, {key}", *_split(one), perfect
            else:
                yield name, *_split(value), perfect

    def __str__(self) -> str:
        lines = [f"{'measure':<34} {'value':>10} {'error':>9}  perfect"]
        for name, value, error, perfect in self.rows():
            shown = "" if value is None else f"{value:.4g}"
            about = "" if error is None else f"{error:.2g}"
            lines.append(f"{name:<34} {shown:>10} {about:>9}  {perfect}".rstrip())
        return "\n".join(lines)


PERFECT = {
    "collapse_ratio": "0 (none: 1)",
    "equivalence_auc": "1 (chance: 0.5)",
    "topology_error": "0, on the same sample only",
    "normalised_topology_error": "0 (random: 1)",
    "metric_error": "0",
    "rank_correlation": "1",
    "partial_displacement": "1",
    "partial_motors": "0",
    "partial_motors_affine": "as partial motors",
    "semipartial_motors": "0",
    "trustworthiness": "1 (random: 0.5)",
    "continuity": "1 (random: 0.5)",
    "neighbours_to_random": "near 0 (random: 1)",
    "neighbours_to_floor": "1",
    "linear_r2": "1",
    "nonlinear_r2": "1",
    "orientation_error": "0 degrees (random: 90)",
    "circular_correlation": "1",
    "winding_number": "1 or -1, where orientation closes",
    "loop_persistence": "1, where orientation closes",
    "intrinsic_dimension": "3",
}


def _split(value: Any) -> tuple[float | None, float | None]:
    if isinstance(value, Estimate):
        return value.mean, value.error
    return None if value is None else float(value), None


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
    """How N codes are organised by the displacements that their motor sequences lead to.

    `codes` are [N, ...] and `displacements` [N, 3]: (longitudinal, lateral, orientation change in
    radians). With the `motors` [N, ...] behind the codes it is measured whether codes copy them.
    `groups` [N] numbers the sequences of equal nominal displacement (negative: none); by default
    those are one group whose displacements agree to a thousandth. `weight` is the w of
    `displacement_coordinates`.

    Measures of pairs are means over random `subsets` of `SUBSET_SIZE` points drawn by `seed`, and
    tell the standard error that this brings. Persistent homology and intrinsic
    dimension need the extra `topology`, and are None without it.

    Raises `UserError` for fewer than a hundred points, rows that do not belong together, values
    that are not finite, and codes or displacements that do not vary.
    """
    h, d, m = checked(codes, displacements, motors)
    labels = collapse.equal_rows(d) if groups is None else checked_groups(groups, len(h))
    coordinates = displacement_coordinates(d, weight=weight)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(h))
    drawn = [order]
    if len(h) > SUBSET_SIZE:
        drawn = [rng.choice(len(h), SUBSET_SIZE, replace=False) for _ in range(subsets)]
    some = order[:MOST_NEIGHBOUR_POINTS]
    equivalent = bool((labels >= 0).any())
    return Topology(
        num_points=len(h),
        weight=coordinates.weight,
        seed=seed,
        code_variance=float(h.var(axis=0).sum()),
        collapse_ratio=collapse.collapse_ratio(h, labels) if equivalent else None,
        equivalence_auc=(
            collapse.equivalence_auc(h, m, labels, seed=seed)
            if equivalent and m is not None
            else None
        ),
        participation_ratio=dimension.participation_ratio(h),
        components_95=dimension.components_for(h),
        intrinsic_dimension=_with_extra("skdim", lambda: dimension.intrinsic_dimension(h[some])),
        **_of_pairs(h, coordinates.points, m, drawn),
        **_of_neighbours(h, coordinates.points, drawn),
        **_of_probes(h, d, some),
        **_of_circle(h, d),
    )


def checked_groups(groups: ArrayLike, num: int) -> collapse.Labels:
    """The groups' numbers. Raises `UserError` unless there is one for each of `num` codes."""
    labels = np.asarray(groups)
    if labels.shape != (num,) or not np.issubdtype(labels.dtype, np.integer):
        raise UserError(
            f"the groups are {labels.dtype} of shape {labels.shape}",
            remedy=f"give one whole number for each of the {num:,} codes",
        )
    return labels


def _with_extra(module: str, measure: Callable[[], float | None]) -> float | None:
    return measure() if importlib.util.find_spec(module) else None


def _estimates(samples: list[dict[str, float]]) -> dict[str, Estimate]:
    """Of each measure the mean over the subsets and its standard error."""
    table = {name: np.array([sample[name] for sample in samples]) for name in samples[0]}
    many = len(samples)
    return {
        name: Estimate(
            float(values.mean()), float(values.std(ddof=1) / np.sqrt(many)) if many > 1 else 0.0
        )
        for name, values in table.items()
    }


def _of_pairs(h: Points, p: Points, m: Points | None, subsets: list[np.ndarray]) -> dict[str, Any]:
    samples = []
    for rows in subsets:
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
        sample = {
            "topology_error": distances.topology_error(dh, dp),
            "normalised_topology_error": distances.normalised_topology_error(dh, dp),
            "metric_error": distances.metric_error(dq, dp),
            "rank_correlation": float(ranks[0, 1]),
        }
        if m is not None:
            for name, (correlation, order) in PARTIAL.items():
                sample[name] = correlation(ranks[np.ix_(order, order)])
        samples.append(sample)
    return dict.fromkeys(PARTIAL) | _estimates(samples)


def _of_neighbours(h: Points, p: Points, subsets: list[np.ndarray]) -> dict[str, Any]:
    samples = []
    for rows in subsets:
        near = neighbours.neighbour_error(h[rows], p[rows])
        sample = {"to_random": near.to_random, "to_floor": near.to_floor}
        for k in (k for k in NEIGHBOURHOODS if 2 * k < len(rows)):
            sample[f"trustworthiness {k}"] = neighbours.trustworthiness(h[rows], p[rows], k=k)
            sample[f"continuity {k}"] = neighbours.continuity(h[rows], p[rows], k=k)
        samples.append(sample)
    found = _estimates(samples)

    def by_k(name: str) -> dict[int, Estimate]:
        return {k: found[f"{name} {k}"] for k in NEIGHBOURHOODS if f"{name} {k}" in found}

    return {
        "trustworthiness": by_k("trustworthiness"),
        "continuity": by_k("continuity"),
        "neighbours_to_random": found["to_random"],
        "neighbours_to_floor": found["to_floor"],
    }


def _of_probes(h: Points, d: Float[np.ndarray, "N 3"], some: np.ndarray) -> dict[str, Any]:
    p, (train, test) = displacement_coordinates(d, weight=1.0).points, np.array_split(some, 2)
    decoded, turns = linear_decoder(h[train], p[train])(h[test]), d[test, 2]
    angles = np.arctan2(decoded[:, 3], decoded[:, 2])
    return {
        "linear_r2": _named(explained(decoded, p[test])),
        "nonlinear_r2": _named(neighbour_probe(h[train], p[train], h[test], p[test])),
        "orientation_error": circle.circular_error(angles, turns),
        "circular_correlation": circle.circular_correlation(angles, turns),
    }


def _named(values: Numbers) -> dict[str, float]:
    return dict(zip(COMPONENTS, (float(v) for v in values), strict=True))


def _of_circle(h: Points, d: Float[np.ndarray, "N 3"]) -> dict[str, Any]:
    translation = np.hypot(d[:, 0], d[:, 1])
    small = np.argsort(translation)[: max(100, round(SMALL_TRANSLATION * len(h)))]
    return {
        "winding_number": circle.winding_number(h, d[:, 2]),
        "loop_persistence": _with_extra("gudhi", lambda: circle.loop_persistence(h[small])),
    }
