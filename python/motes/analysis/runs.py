"""Comparison of runs: `motes.open_runs`, and the paper's speed-up tables."""

from __future__ import annotations

import glob
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from .. import _extras
from .._values import arguments
from ..errors import ArgumentError, LogError, MotesWarning
from .run import Run, open_run

if TYPE_CHECKING:
    from pandas import DataFrame

    from ._plots.many_runs import RunsPlots

__all__ = ["Runs", "configuration", "open_runs"]


def open_runs(pattern: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> Runs:
    """Open all logs that match a pattern, in the order of their names.

    Args:
        pattern: a glob pattern such as "runs/*", or a list of paths; a directory that is not a log itself
            stands for the logs in it.

    Returns:
        The runs; paths that are not logs are skipped.

    Raises:
        LogError: if no log is found.
    """
    if isinstance(pattern, (str, os.PathLike)):
        paths = [Path(name) for name in sorted(glob.glob(os.fspath(pattern)))]
        if len(paths) == 1 and paths[0].is_dir() and not (paths[0] / "run.json").is_file():
            paths = sorted(paths[0].iterdir())
    else:
        wanted = arguments.listed("pattern", pattern, "a pattern of paths, or a list of them")
        paths = [arguments.file_path("pattern", name) for name in wanted]
        missing = [path for path in paths if not (path / "run.json").is_file()]
        if missing:
            raise LogError(f"{missing[0]} is not a run's log: it has no run.json")
    logs = [path for path in paths if (path / "run.json").is_file()]
    if not logs:
        raise LogError(
            f"{os.fspath(pattern) if isinstance(pattern, (str, os.PathLike)) else '[]'}: found no run's log"
        )
    return Runs([open_run(path) for path in logs])


def configuration(run: Run) -> str:
    """Return the paper's name: IS or FS for infinite or finite space; SLB or DLB for static or dynamic."""
    space = {None: "IS", "fit": "fit"}.get(run.space if not isinstance(run.space, tuple) else "", "FS")
    return f"{space}-{'SLB' if _kind(run) in ('Static', 'None') else 'DLB'}"


def _kind(run: Run) -> str:
    return run.balancer.partition("(")[0].rpartition(".")[2]


def _scene(run: Run) -> str:
    argv = run.facts.get("argv") or [""]
    return Path(argv[0]).stem if argv[0] else str(run.facts.get("script_sha256", ""))[:8]


class Runs(Sequence[Run]):
    """A sequence of runs to compare."""

    def __init__(self, runs: Iterable[Run]) -> None:
        """Make a sequence of runs; scripts call `motes.open_runs`.

        Args:
            runs: the runs, in the order to show them.
        """
        self._runs = list(runs)

    @overload
    def __getitem__(self, index: int) -> Run: ...

    @overload
    def __getitem__(self, index: slice) -> Runs: ...

    def __getitem__(self, index: int | slice) -> Run | Runs:
        """Return a run, or a slice of the runs."""
        return Runs(self._runs[index]) if isinstance(index, slice) else self._runs[index]

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(self._runs)

    def __iter__(self) -> Iterator[Run]:
        """Iterate over the runs."""
        return iter(self._runs)

    @property
    def table(self) -> DataFrame:
        """One row per run: its `summary()`, with the scene and the paper's name of its configuration."""
        rows = [{"scene": _scene(run), "configuration": configuration(run), **run.summary()} for run in self]
        table: DataFrame = _extras.pandas().DataFrame(rows).set_index("run")
        return table

    def where(self, **facts: Any) -> Runs:
        """Select runs by facts or figures.

        Args:
            **facts: required values: `runs.where(ranks=4, balancer="Static()")`.

        Returns:
            The runs that match all of them.
        """
        return Runs(run for run in self if _matches(run, facts))

    def speedup(
        self,
        baseline: Run | str | os.PathLike[str] | Mapping[str, Any] | float | None = None,
        *,
        layout: Literal["paper", "long"] = "paper",
    ) -> DataFrame:
        """Compute speed-up and efficiency over a baseline, from wall-clock seconds per frame.

        Only frames that both runs have are compared. Efficiency is speed-up divided by the number of
        calculators.

        Args:
            baseline: a run, a log's path, facts that identify one (`{"ranks": 1}`), or seconds per frame.
                None: the run of the same scene on one rank; if there is none, the slowest of those with the
                fewest calculators, with a MotesWarning.
            layout: "paper": one row per number of calculators, with columns IS-SLB, FS-SLB, IS-DLB, FS-DLB as
                in the paper's Tables 1 and 3 (the median of several runs of one kind; one column per dynamic
                balancer if there are several). "long": one row per run.

        Returns:
            The table. `attrs["baseline"]`, and the column `baseline` of "long", name the baseline: names of
            runs, or seconds per frame.
        """
        layout = arguments.choice("layout", layout, ("paper", "long"))
        if not self._runs:
            raise LogError("no runs to compare")
        dynamic = {_kind(run) for run in self if configuration(run).endswith("DLB")}
        rows = [self._speedup_row(run, baseline, several=len(dynamic) > 1) for run in self]
        table = _extras.pandas().DataFrame(rows).set_index("run")
        names = dict.fromkeys(table["baseline"])
        for base in self if baseline is None else ():
            if base.name in names and base.ranks > 1:
                text = f"no run of {_scene(base)} on one rank: speed-up is relative to {base.name}, on "
                text += f"{base.ranks} ranks, {len(base.calculators)} of them calculators"
                warnings.warn(text, MotesWarning, stacklevel=2)
        result = table if layout == "long" else _paper_layout(table)
        result.attrs["baseline"] = ", ".join(names)
        return result

    def _speedup_row(self, run: Run, baseline: Any, *, several: bool) -> dict[str, Any]:
        over, reference, seconds = self._reference(run, baseline)
        name = configuration(run)
        if several and name.endswith("DLB"):
            name += f" {_kind(run)}"
        speedup = reference / seconds if seconds > 0 else float("nan")
        return {
            "run": run.name,
            "scene": _scene(run),
            "ranks": run.ranks,
            "calculators": len(run.calculators),
            "space": "infinite" if run.space is None else run.space,
            "balancer": run.balancer,
            "configuration": name,
            "s_per_frame": seconds,
            "baseline": over,
            "speedup": speedup,
            "efficiency": speedup / len(run.calculators),
        }

    def _reference(self, run: Run, baseline: Any) -> tuple[str, float, float]:
        """Return the baseline's name, its seconds per frame and the run's, over the frames that both have."""
        if isinstance(baseline, (int, float)) and not isinstance(baseline, bool):
            if not baseline > 0:
                raise ArgumentError("baseline", baseline, "more than 0 seconds per frame")
            return f"{baseline:g} s", float(baseline), _seconds(run, len(run.frames))
        base = self._base_run(run, baseline)
        common = min(len(run.frames), len(base.frames))
        return base.name, _seconds(base, common), _seconds(run, common)

    def _base_run(self, run: Run, baseline: Any) -> Run:
        if isinstance(baseline, Run):
            return baseline
        if isinstance(baseline, (str, os.PathLike)):
            return open_run(baseline)
        same = [other for other in self if _scene(other) == _scene(run)]
        if isinstance(baseline, Mapping):
            same = [other for other in same if _matches(other, baseline)]
            if not same:
                raise ArgumentError("baseline", dict(baseline), f"facts of a run of {_scene(run)}")
        elif baseline is not None:
            raise ArgumentError(
                "baseline", baseline, "a run, a path, facts of a run, seconds per frame or None"
            )
        fewest = min((len(other.calculators), other.ranks) for other in same)
        same = [other for other in same if (len(other.calculators), other.ranks) == fewest]
        return max(same, key=lambda other: _seconds(other, len(other.frames)))

    @cached_property
    def plot(self) -> RunsPlots:
        """Plots of many runs: `runs.plot.speedup()`, ...; each returns a matplotlib Axes."""
        from ._plots.many_runs import RunsPlots

        return RunsPlots(self)

    def __repr__(self) -> str:
        """Show the runs."""
        return f"<{len(self)} runs: {', '.join(run.name for run in self)}>"

    def _repr_html_(self) -> str:
        from .summary import runs_html

        return runs_html(self)


def _seconds(run: Run, frames: int) -> float:
    return float(run.frames["t_frame_s"].iloc[:frames].mean()) if frames else float("nan")


def _matches(run: Run, wanted: Mapping[str, Any]) -> bool:
    values = {**run.facts, **run.summary(), "space": run.space, "calculators": len(run.calculators)}
    values |= {"configuration": configuration(run), "scene": _scene(run)}
    return all(key in values and _equal(values[key], value) for key, value in wanted.items())


def _equal(have: Any, want: Any) -> bool:
    if isinstance(have, tuple) and isinstance(want, (list, tuple)):
        return list(have) == list(want)
    return type(want) is not bool and have == want or have is want


def _paper_layout(table: DataFrame) -> DataFrame:
    index = ["ranks", "calculators"] if table["scene"].nunique() == 1 else ["scene", "ranks", "calculators"]
    wide = table.pivot_table(
        index=index,
        columns="configuration",
        values=["speedup", "efficiency"],
        aggfunc="median",
        observed=True,
    )
    order = sorted(table["configuration"].unique(), key=_column_order)
    columns = [(measure, name) for measure in ("speedup", "efficiency") for name in order]
    return wide.reindex(columns=_extras.pandas().MultiIndex.from_tuples(columns, names=["", "configuration"]))


def _column_order(name: str) -> tuple[int, str]:
    paper = ("IS-SLB", "FS-SLB", "IS-DLB", "FS-DLB")
    head = name.partition(" ")[0]
    return paper.index(head) if head in paper else len(paper), name
