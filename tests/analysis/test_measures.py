"""The one table of measures, and how a key is looked up in it."""

import re
import tomllib
from importlib.resources import files

import pytest

from motorspace import UserError
from motorspace.analysis.coordinates import COMPONENTS
from motorspace.analysis.measures import FIELDS, Measure, define, measure, measures


@pytest.mark.parametrize(
    ("key", "label"),
    [
        ("rank_correlation", "rank correlation"),
        ("linear_r2.cos", "linear R², cos"),
        ("linear_r2.worst", "linear R², worst"),
        ("continuity.10", "continuity, k = 10"),
        ("equivalence.split_rotation", "equivalence ratio, split rotation"),
        ("equivalence.full_turns", "equivalence ratio, full turns"),
        ("equivalence.full_turns.2", "equivalence ratio, 2 full turns apart"),
        ("congruence.left", "congruence error, left"),
        ("length_error.translation.24", "translation error, T = 24"),
        ("lattice.r2.3.longitudinal", "R² from 3 components, longitudinal"),
        ("standard.trustworthiness.20", "trustworthiness, k = 20, standard form"),
        ("epoch.50.equivalence.full_turns.1", "equivalence ratio, 1 full turns apart, epoch 50"),
    ],
)
def test_a_key_has_a_label(key, label):
    found = measure(key)
    assert (found.key, found.label) == (key, label)


def test_members_of_a_family_share_what_is_perfect():
    assert {measure(f"trustworthiness.{k}").chance for k in (5, 20)} == {0.5}
    assert measure("standard.linear_r2.sin").perfect == 1.0
    assert measure("orientation_error").title == "orientation error (degrees)"


@pytest.mark.parametrize("key", ["linear_r2.up", "trustworthiness.x", "standard.nothing", ""])
def test_a_key_that_no_measure_has_is_refused(key):
    with pytest.raises(UserError, match="there is no measure"):
        measure(key)


def test_a_misspelt_key_is_answered_with_the_nearest():
    with pytest.raises(UserError, match=r"\(perhaps rank_correlation"):
        measure("rank_corelation")


def test_the_table_is_well_formed():
    table = tomllib.loads((files("motorspace.analysis") / "measures.toml").read_text())
    assert len(table) > 50
    # Studies define further ones beside the table.
    for one in (one for one in measures() if one.key in table):
        assert re.fullmatch(r"[a-z0-9_]+(\.([a-z0-9_]+|\{[a-z]+\}))*", one.key), one.key
        assert one.label and one.meaning.endswith("."), one.key
        assert one.goal != "near" or one.perfect is not None
        # A logarithmic scale shows no perfect 0, and no value of either sign.
        assert not (one.log_scale and one.arbitrary_sign)
    assert FIELDS["component"].split("|") == [*COMPONENTS, "worst"]


def test_what_falls_short_less_is_better():
    def better(key, one, other):
        return measure(key).shortfall(one) < measure(key).shortfall(other)

    assert better("rank_correlation", 0.9, 0.8)
    assert better("prediction.error", 3.0, 4.0)
    assert better("partial_motors", -0.1, 0.2)
    assert better("winding_number", -1.0, 0.0)
    with pytest.raises(UserError, match="no value of components_95 is better"):
        measure("components_95").shortfall(3.0)


def test_a_study_defines_measures_of_its_own():
    own = Measure("toy_study.jumps", "jumps", "How often it jumps.", "low")
    define(own, own)
    assert measure("toy_study.jumps") is own and own in measures()
    with pytest.raises(UserError, match=r"already is another measure 'toy_study\.jumps'"):
        define(Measure("toy_study.jumps", "leaps"))
