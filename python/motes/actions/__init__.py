"""Actions on particles as values (paper 3.1.5). `System` has one method per action, which records it.

In formulas, v is a particle's velocity in m/s, x its position in m, dt the (sub)step in seconds. `forces` has
actions that accelerate, `guides` those that follow fields and paths, `targets` those that set or approach
given values, `motion` those that move, bounce, sort and kill, `between` those between particles, `laws` those
that a script writes itself. All names are exported here.
"""

from __future__ import annotations

from typing import Any

from ..errors import missing
from . import between, forces, guides, laws, motion, targets
from .base import Action, Where
from .between import *  # noqa: F403
from .forces import *  # noqa: F403
from .guides import *  # noqa: F403
from .laws import *  # noqa: F403
from .motion import *  # noqa: F403
from .targets import *  # noqa: F403

__all__ = ["Action", "Where"]
__all__ += motion.__all__
__all__ += forces.__all__
__all__ += guides.__all__
__all__ += targets.__all__
__all__ += between.__all__
__all__ += laws.__all__


def __getattr__(name: str) -> Any:
    raise missing("motes.actions", name, __all__)


def __dir__() -> list[str]:
    return [*__all__]
