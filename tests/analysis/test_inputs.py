"""What anybody may hand in: measured, or refused in a sentence."""

import warnings

import numpy as np
import pytest

from motorspace import UserError, topology
from motorspace.analysis.dimension import intrinsic_dimension
from motorspace.analysis.inputs import CollapsedCodesError, checked, moderate

NUM = 200
RNG = np.random.default_rng(0)
DISPLACEMENTS = RNG.uniform(-1, 1, (NUM, 3))
CODES = DISPLACEMENTS @ RNG.normal(size=(3, 5)) + 0.3


def changed(array, row, column, value):
    array = array.copy()
    array[row, column] = value
    return array


WRONG = {
    "nan": (changed(CODES, 7, 2, np.nan), "the codes hold nan in row 7, column 2"),
    "infinite": (changed(CODES, 7, 2, -np.inf), "the codes hold -inf in row 7"),
    "masked": (np.ma.masked_equal(CODES, CODES[3, 1]), "hold nan in row 3, column 1"),
    "lengths": (CODES[:-1], "there are 199 codes and 200 displacements"),
    "number": (np.float64(3.0), "the codes are a single number"),
    "row": (CODES[:, 0], r"the codes have the shape \(200,\).*shape \(N, 1\)"),
    "no rows": (CODES[:0], r"the codes are empty, of shape \(0, 5\)"),
    "no columns": (CODES[:, :0], r"the codes are empty, of shape \(200, 0\)"),
    "ragged": ([[1.0, 2.0], [3.0]], "the codes are no array"),
    "objects": (CODES.astype(object), "the codes hold object, not real numbers"),
    "complex": (CODES + 1j, "the codes hold complex numbers"),
    "text": (CODES.astype(str), "the codes hold <U32, not real numbers"),
    "dates": (CODES.astype("datetime64[s]"), "not real numbers"),
    "overflow": (1e200 * CODES, r"the codes hold values as large as \de\+200"),
    "long double": (CODES * np.longdouble("1e4000"), "the codes hold inf|-inf"),
    "underflow": (1e-200 * (CODES - 0.3), "whose squares underflow"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_codes_are_refused_in_a_sentence(case):
    codes, message = WRONG[case]
    with pytest.raises(UserError, match=message):
        checked(codes, DISPLACEMENTS, None)


COLLAPSED = {
    "constant": np.full((NUM, 4), 0.3),
    "zero": np.zeros((NUM, 4)),
    "up to float64": 0.3 + 1e-16 * RNG.normal(size=(NUM, 4)),
    "up to float32": (0.3 + 3e-8 * RNG.normal(size=(NUM, 4))).astype(np.float32),
}


@pytest.mark.parametrize("case", COLLAPSED)
def test_codes_that_do_not_vary_have_collapsed(case):
    with pytest.raises(CollapsedCodesError, match="the codes are all the same"):
        checked(COLLAPSED[case], DISPLACEMENTS, None)


def test_wrong_displacements_and_options_are_refused():
    for wrong, message in (
        (DISPLACEMENTS[:, :2], "the displacements have 2 columns"),
        (np.ones((NUM, 3)), "the displacements are all the same"),
        (changed(DISPLACEMENTS, 3, 1, np.inf), "the displacements hold inf in row 3"),
        (1e200 * DISPLACEMENTS, "the displacements hold values as large as 1e.200"),
    ):
        with pytest.raises(UserError, match=message):
            checked(CODES, wrong, None)
    with pytest.raises(UserError, match="99 points are too few"):
        checked(CODES[:99], DISPLACEMENTS[:99], None)
    with pytest.raises(UserError, match="the motors hold <U"):
        checked(CODES, DISPLACEMENTS, CODES.astype(str))
    for options, message in (
        ({"weight": -1.0}, "weight must be positive, got -1"),
        ({"weight": float("nan")}, "weight must be positive, got nan"),
        ({"subsets": 0}, "subsets must be at least 1, got 0"),
        ({"seed": -1}, "seed must be at least 0, got -1"),
        ({"groups": np.zeros(NUM)}, "the groups are float64"),
        ({"groups": np.zeros(3, int)}, r"the groups are int64 of shape \(3,\)"),
    ):
        with pytest.raises(UserError, match=message):
            topology(CODES, DISPLACEMENTS, **options)


def test_numbers_of_any_real_type_are_measured():
    for codes in (CODES > 0, (9 * CODES).astype(int), CODES.astype(np.float16), CODES.tolist()):
        h, d, m = checked(codes, DISPLACEMENTS.tolist(), None)
        assert h.dtype == d.dtype == np.float64 and m is None
    h, _, m = checked(CODES.reshape(NUM, 5, 1), DISPLACEMENTS, CODES.reshape(NUM, 1, 5))
    np.testing.assert_array_equal(h, m)


def test_codes_of_one_column_are_measured():
    found = topology(DISPLACEMENTS[:, :1], DISPLACEMENTS)
    assert found.linear_r2["longitudinal"] > 0.9999 > 0.5 > found.linear_r2["lateral"]
    assert found.winding_number == 0.0
    assert found.intrinsic_dimension == pytest.approx(1.0, abs=0.3)


@pytest.mark.parametrize("scale", [1e-45, 1e-9, 1e9, 1e45])
def test_the_scale_of_codes_changes_their_variance_alone(scale):
    plain = topology(CODES, DISPLACEMENTS)
    scaled = topology(scale * CODES, DISPLACEMENTS)
    for key, value in plain.items():
        factor = scale**2 if key == "total_code_variance" else 1.0
        assert scaled[key] == pytest.approx(factor * value, rel=1e-6, abs=1e-9), key


def test_codes_of_ordinary_scale_are_left_as_they_are():
    codes, scale = moderate(CODES)
    assert codes is CODES and scale == 1.0


def test_displacements_in_degrees_are_warned_of():
    degrees = DISPLACEMENTS * [1.0, 1.0, 180.0]
    with pytest.warns(UserWarning, match="9.% of the orientation changes are more than a full"):
        checked(CODES, degrees, None)
    with warnings.catch_warnings():  # a few are net rotations of several turns
        warnings.simplefilter("error")
        checked(CODES, changed(DISPLACEMENTS, 3, 2, 7.0), None)


@pytest.mark.parametrize("units", [3, 50])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_codes_equal_up_to_rounding_count_once_for_the_dimension(units, dtype):
    rng = np.random.default_rng(1)
    shared = rng.normal(size=(500, 3))[np.repeat(np.arange(500), 4)] @ rng.normal(size=(3, units))
    codes = (shared * (1 + 1e-7 * rng.normal(size=shared.shape))).astype(dtype)
    assert intrinsic_dimension(codes.astype(float)) == pytest.approx(3.0, abs=0.3)
    assert intrinsic_dimension((codes + 1000).astype(dtype).astype(float)) == pytest.approx(
        3.0, abs=0.3
    )


def test_a_heap_of_equal_codes_has_no_dimension():
    codes = RNG.normal(size=(3, 4))[RNG.integers(3, size=9000)] + 1e-8 * RNG.normal(size=(9000, 4))
    assert np.isnan(intrinsic_dimension(codes))
