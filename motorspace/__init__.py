"""Learn the space of displacements of an agent from its motor commands and its sensors.

One verb per stage: `sample` and `record` what an agent does, `train` on it, `evaluate` the run,
measure the `topology` of codes. The public names stand in `__init__.pyi`; each is imported when
it is first used, so that `import motorspace` costs nothing.
"""

import lazy_loader

from motorspace.environments import register_with_gymnasium

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

register_with_gymnasium()
