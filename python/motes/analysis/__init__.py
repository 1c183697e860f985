"""Analysis of a run's log: tables, measures, plots, traces, reports, the live view.

`open_run` reads one log, `open_runs` many. Modules are loaded on first use, pandas and matplotlib (the extra
`analysis`) with the first table or plot. Nothing here needs MPI; only `Run.replay` needs the core.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .run import Run, open_run
    from .runs import Runs, open_runs

__all__ = ["Run", "Runs", "open_run", "open_runs"]

if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        """Load a name when it is first used."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        module = importlib.import_module(".runs" if name.endswith("uns") else ".run", __name__)
        globals()[name] = getattr(module, name)
        return globals()[name]


def __dir__() -> list[str]:
    return [*__all__]
