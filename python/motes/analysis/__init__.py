"""The analyst's side of a run's log: tables, measures, plots, traces, reports, the live view.

`open_run` reads one log, `open_runs` many. pandas and matplotlib (the extra `analysis`) are imported when
a table or a plot is asked for, not before.
"""

from .run import Run, open_run
from .runs import Runs, open_runs

__all__ = ["Run", "Runs", "open_run", "open_runs"]
