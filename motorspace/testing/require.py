"""Assertions that tell what is wrong."""

from typing import Any


def require(holds: bool, otherwise: str) -> None:
    """Raise `AssertionError` with a sentence unless something holds."""
    if not holds:
        raise AssertionError(otherwise)


def require_equal(found: Any, wanted: Any, otherwise: str) -> None:
    """Raise `AssertionError` with a sentence unless two objects of options are equal."""
    require(type(found) is type(wanted) and vars(found) == vars(wanted), otherwise)
