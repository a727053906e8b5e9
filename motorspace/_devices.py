"""What kind of device JAX computes on."""

import jax


def on_accelerator() -> bool:
    """Whether JAX computes on a device of many cores, for which each operation is a launch."""
    device = jax.config.jax_default_device  # type: ignore[attr-defined]
    platform = jax.default_backend() if device is None else getattr(device, "platform", device)
    return bool(platform != "cpu")
