"""Processes that were forked from one in which JAX had started: JAX would wait forever in them."""

import os
import sys

from motorspace._errors import UserError

_jax_had_started = False
_forked = False


def refuse_forked() -> None:
    """Raise `UserError` in a process that JAX cannot work in. Call it before JAX computes."""
    if _forked:
        raise UserError(
            "this process was forked after JAX had started, and JAX does not work in it",
            remedy='start it afresh, for instance with vector_kwargs={"context": "spawn"}, or step'
            ' all environments in one process with vectorization_mode="vector_entry_point"',
        )


def _before() -> None:
    global _jax_had_started
    bridge = sys.modules.get("jax._src.xla_bridge")
    _jax_had_started = bridge is not None and bridge.backends_are_initialized()


def _after_in_child() -> None:
    global _forked
    _forked = _forked or _jax_had_started


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before, after_in_child=_after_in_child)
