"""The public surface: every name is documented, and examples in docstrings run."""

import dataclasses
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import motorspace as ms
from motorspace._kinds import field_docstrings

ROOT = Path(__file__).parents[1]
FUNCTIONS = [name for name in ms.__all__ if inspect.isfunction(getattr(ms, name))]
CLASSES = [name for name in ms.__all__ if inspect.isclass(getattr(ms, name))]


def described(name, text):
    """Whether `Args:` or `Attributes:` of a docstring have a line for a name."""
    return re.search(rf"^ +{name}: \S", text, re.MULTILINE) is not None


def test_functions_and_classes_are_all_there_is():
    assert sorted(FUNCTIONS + CLASSES) == sorted(ms.__all__)
    assert set(ms.__all__) <= set(dir(ms))


@pytest.mark.parametrize("name", ms.__all__)
def test_a_public_name_says_in_one_line_what_it_is(name):
    first = (inspect.getdoc(getattr(ms, name)) or "").partition("\n")[0]
    assert first.endswith(".") and len(first) > 20
    assert first != inspect.getdoc(dict)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_public_function_describes_arguments_results_and_errors(name):
    function = getattr(ms, name)
    text, signature = inspect.getdoc(function), inspect.signature(function)
    assert not [arg for arg in signature.parameters if not described(arg, text)]
    if signature.return_annotation not in (None, inspect.Signature.empty):
        assert "Returns:" in text or re.match(r"Returns? |The |A |Train ", text)


@pytest.mark.parametrize("name", CLASSES)
def test_a_public_class_describes_its_fields_and_methods(name):
    kind = getattr(ms, name)
    text, below = inspect.getdoc(kind), {}
    for ancestor in filter(dataclasses.is_dataclass, kind.__mro__):
        below |= field_docstrings(ancestor)
        text += ancestor.__doc__ or ""
    known = dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ()
    fields = [field.name for field in known]
    assert not [f for f in fields if f not in below and not described(f, text)]
    methods = [
        method
        for method, value in vars(kind).items()
        if not method.startswith("_")
        and (inspect.isfunction(value) or isinstance(value, property | classmethod))
    ]
    assert not [method for method in methods if not inspect.getdoc(getattr(kind, method))]


def test_importing_the_package_imports_no_name_before_it_is_used():
    code = (
        "import motorspace as ms, sys; loaded = {m for m in sys.modules if 'motorspace.' in m};"
        "assert loaded == {'motorspace.environments'}, loaded;"
        "ms.RunConfig; assert 'jax' not in sys.modules; ms.ForwardAgent;"
        "assert 'jax' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)


def test_there_are_examples_that_run():
    """`--doctest-modules` runs them; see the settings of pytest."""
    shown = [p for p in (ROOT / "motorspace").rglob("*.py") if ">>> " in p.read_text()]
    assert len(shown) > 20
