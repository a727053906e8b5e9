"""JAX as the command line runs it: one thread, a cache of compiled programs, a device."""

import os
from pathlib import Path

from motorspace._errors import UserError

MOST_CACHED = 2**30
"""Bytes of compiled programs to keep; those used least lately go first."""


def prepare_jax() -> None:
    """Set up JAX. Raises `UserError` for a device that is missing. To be called before its use."""
    # The products are small: a second thread gains a fifth on an idle machine, and loses an
    # order of magnitude when it waits for a core that another process holds.
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")
    # Everything is computed in single precision, whatever the environment asks for; in workers too.
    os.environ["JAX_ENABLE_X64"] = "0"
    import jax

    jax.config.update("jax_enable_x64", False)
    keep_compiled_programs()
    refuse_missing_device()


def keep_compiled_programs() -> None:
    """Compile each program once per machine: later runs, and all processes of one, load it.

    A folder that JAX_COMPILATION_CACHE_DIR names is its owner's, and gets no bound of ours.
    """
    if "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return
    import jax

    caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = caches / "motorspace" / "compiled"
    settings = {
        "jax_compilation_cache_dir": str(folder),
        "jax_compilation_cache_max_size": MOST_CACHED,
    }
    for name, value in settings.items():
        jax.config.update(name, value)
        # Workers must keep to the bound: one entry written without it stops all later writing.
        os.environ[name.upper()] = str(value)


def refuse_missing_device() -> None:
    """Raise `UserError` with the devices there are when JAX_PLATFORMS asks for another."""
    asked = os.environ.get("JAX_PLATFORMS")
    if not asked:
        return
    import jax

    try:
        jax.devices()
    except (RuntimeError, AssertionError):
        jax.config.update("jax_platforms", "")
        present = ", ".join(sorted({device.platform for device in jax.devices()}))
        raise UserError(
            f"there is no device {asked!r} here",
            where="JAX_PLATFORMS",
            remedy=f"choose from: {present}",
        ) from None
