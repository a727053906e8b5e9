"""An extension of Griffe, which reads the docstrings for the reference: examples are code."""

import re
from typing import Any

import griffe


class Examples(griffe.Extension):
    """Reads `Example:`, and examples without a heading, as the section `Examples:`."""

    def on_object(self, *, obj: griffe.Object, **kwargs: Any) -> None:
        """Change the docstring of an object before it is parsed."""
        del kwargs
        if obj.docstring is not None:
            obj.docstring.value = with_examples(obj.docstring.value)


def with_examples(text: str) -> str:
    """The docstring with every example in a section of its own."""
    text = re.sub(r"^Example:$", "Examples:", text, flags=re.MULTILINE)
    return re.sub(r"^>>> .*(?:\n.+)*", _section, text, flags=re.MULTILINE)


def _section(example: re.Match[str]) -> str:
    return "Examples:\n" + re.sub(r"^", "    ", example[0], flags=re.MULTILINE)
