"""Numbers and choices that a person gave."""

import subprocess
import sys

import numpy as np
import pytest

from motorspace import UserError
from motorspace.worlds.checks import one_of, positive, whole


def test_what_fits_comes_back():
    assert whole("n", np.int64(3)) == 3
    assert positive("x", 2) == 2.0
    assert one_of("rule", "set", ("set", "turn")) == "set"


@pytest.mark.parametrize(
    ("check", "message"),
    [
        (lambda: whole("n", 0), "n must be at least 1, got 0"),
        (lambda: whole("n", 2.5), "n must be a whole number, got 2.5"),
        (lambda: whole("n", "many"), "n must be a whole number, got 'many'"),
        (lambda: whole("n", True), "n must be a whole number, got True"),
        (lambda: positive("x", "much"), "x must be a number, got 'much'"),
        (lambda: positive("x", np.nan), "x must be above 0 and finite, got nan"),
        (lambda: positive("x", 7.0, at_most=6.0), "x must be above 0 and at most 6, got 7"),
        (lambda: one_of("rule", "nod", ("set", "turn")), "rule must be 'set' or 'turn', got 'nod'"),
    ],
)
def test_what_does_not_fit_is_one_sentence(check, message):
    with pytest.raises(UserError, match=message):
        check()


def test_wrong_types_are_refused_where_annotations_are_not_executed():
    """As for users: with our own annotations executed, as in these tests, they end sooner."""
    code = """
from motorspace import *
from motorspace._errors import UserError
import jax
for wrong in (
    lambda: ForwardAgent("much"), lambda: HolonomicAgent(head_rule="nod"), lambda: Scenario(3),
    lambda: RangeFan(2.5), lambda: LatticeWorld(3, "a"),
    lambda: sample(num="many", horizon=6, key=jax.random.key(0)),
    lambda: sample(num=5, horizon=6, collision="bounce", key=jax.random.key(0)),
):
    try:
        wrong()
    except UserError:
        continue
    raise SystemExit("accepted")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
