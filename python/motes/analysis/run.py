"""One run's log as tables: `motes.open_run`."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._interchange.task_loads import TaskLoads, load_files, read_task_loads
from .._values import arguments
from .._values.space import in_a_row
from ..errors import ArgumentError, LogError
from ._tables import measures, stretches
from ._tables.schema import TABLES
from ._tables.tables import frame_of, read_facts, read_table, with_columns
from .task_tables import facts_of, tables_of

if TYPE_CHECKING:
    from pandas import DataFrame, Series

    from ..balance import Balancer
    from ._plots.one_run import Plots
    from .explaining import Explanation

__all__ = ["Run", "open_run"]


def open_run(path: str | os.PathLike[str]) -> Run:
    """Open the log of a run, which may have been killed or may still be running, or another code's loads.

    All complete rows are read. Each table is read on first use; columns missing from logs of earlier versions
    are empty.

    Load files of vt and LBAF, one per rank, become a run whose frames are phases. Each task that can migrate
    has a place in a row and as many particles of its system, "tasks", as it takes `facts["particle_s"]`.

    Args:
        path: a directory that `World(log=...)` wrote; or the directory of load files NAME.RANK.json, plain or
            compressed with Brotli, DIRECTORY/NAME if there are several, or one of them.

    Returns:
        The run.

    Raises:
        LogError: if files are missing or damaged, naming path and line, or path and field.
        MissingExtraError: if load files are compressed, and Brotli is not installed.
    """
    directory = arguments.file_path("path", path)
    if found := load_files(directory):
        loads = read_task_loads(found)
        tables = {name: frame_of(rows, TABLES[name].columns) for name, rows in tables_of(loads).items()}
        return Run(facts_of(loads), tables, loads=loads)
    return Run(read_facts(directory), {}, path=directory)


class Run:
    """A run: `facts` (run.json) and the log's tables as DataFrames.

    Returned by `open_run`, and by `Run.replay`, which predicts the run under another balancer.
    """

    def __init__(
        self,
        facts: Mapping[str, Any],
        tables: Mapping[str, DataFrame],
        path: str | os.PathLike[str] | None = None,
        *,
        loads: TaskLoads | None = None,
    ) -> None:
        """Set facts and tables; scripts call `motes.open_run`.

        Args:
            facts: contents of run.json.
            tables: tables that are already available, by name: "load", "frames", ...
            path: the log's directory, from which other tables are read when needed; None: there are no other
                tables.
            loads: the tasks of another code's run, which a replay cuts; None: the tables are of particles.
        """
        self.facts = dict(facts)
        self.path = None if path is None else Path(path)
        self._given = dict(tables)
        self._read: dict[str, DataFrame] = {}
        self._torn: list[Path] = []
        self._loads = loads

    # --- tables

    def table(self, name: str) -> DataFrame:
        """Return one of the log's tables as it is in its file.

        Args:
            name: the file's name without its suffix: "frames", "load", "waits", ...
        """
        if name in self._given:
            self._given[name] = with_columns(self._given[name], TABLES[name].columns)
            return self._given[name]
        if name not in self._read:
            if self.path is None:
                self._read[name] = frame_of([], TABLES[name].columns)
            else:
                self._read[name], torn = read_table(self.path, TABLES[name])
                self._torn += torn
        return self._read[name]

    @property
    def frames(self) -> DataFrame:
        """One row per frame: particles, exchanged, imbalance, seconds of each phase."""
        return self.table("frames")

    @property
    def load(self) -> DataFrame:
        """One row per frame, system and calculator: particles, seconds, domain, speed."""
        return self.table("load")

    @property
    def balance(self) -> DataFrame:
        """One row per cut that a balancer evaluated; empty if there were none."""
        return self.table("balance")

    @property
    def density(self) -> DataFrame:
        """One row per frame, system and calculator: quantiles of its particles along the axis."""
        return self.table("density")

    @property
    def events(self) -> DataFrame:
        """Events of the run: its start, its end, and others in between."""
        return self.table("events")

    @property
    def spans(self) -> DataFrame:
        """One row per phase and rank with `World(spans=True)`; else empty."""
        return self.table("spans")

    @property
    def times(self) -> DataFrame:
        """One row per frame and rank: where its time went; empty for replays and old logs."""
        return self.table("times")

    @property
    def walls(self) -> DataFrame:
        """One row per frame and wall of `contact`: the force of particles on it, and its torque."""
        return self.table("walls")

    @property
    def links(self) -> DataFrame:
        """One row per pair of ranks that exchanged messages when the run started: how fast they travelled."""
        return self.table("links")

    def waits(self) -> DataFrame:
        """Return how long ranks waited for each other.

        The rank waited for is the one that was late, often not the sender of the message: if rank 2 waits for
        the verdict of the manager, which still waits for the report of rank 3, both wait for rank 3.

        Returns:
            One row per frame, rank, rank waited for (-1: several) and phase, with seconds. In logs of earlier
            versions the rank waited for is the sender.
        """
        by = ["frame", "rank", "waited_for", "phase"]
        return self.table("waits").groupby(by, sort=False)["seconds"].sum().reset_index()

    @property
    def knows_who_is_late(self) -> bool:
        """Whether `waits` names late ranks, not only senders as in logs of earlier versions."""
        return bool(self.table("waits")["sender"].notna().any())

    def reload(self) -> Run:
        """Discard all tables, to read them again from a run that is still running.

        Returns:
            The run itself.
        """
        self._read.clear()
        self._torn.clear()
        self.__dict__.pop("plot", None)
        return self

    def lacks_rows(self) -> LogError:
        """Return the error of what needs rows of frames, or of calculators, that the log does not have."""
        if len(self.frames):
            return LogError(f"{self.name}: the run has no systems, so there are no particles to show")
        why = ": it ended before the first" if self.finished else " yet"
        return LogError(f"{self.name}: no frames in the log{why}")

    # --- facts

    @property
    def finished(self) -> bool:
        """Whether the run finished; False if it was killed or is still running."""
        if self.path is None and "events" not in self._given:
            return True
        return bool((self.events["kind"] == "end").any())

    @property
    def torn(self) -> list[Path]:
        """Files read so far whose last line is incomplete because the run was killed."""
        return list(self._torn)

    @property
    def name(self) -> str:
        """The log's directory, or the name of a replay."""
        if self.path is None:
            return str(self.facts.get("name", "replay"))
        return self.path.resolve().name

    @property
    def balancer(self) -> str:
        """The balancer as the script wrote it."""
        return str(self.facts.get("balancer") or "Static()")

    @property
    def space(self) -> tuple[float, float] | str | None:
        """The interval that domains initially divided; None (the paper's infinite space); or "fit"."""
        space = self.facts.get("space")
        return (float(space[0]), float(space[1])) if isinstance(space, (list, tuple)) else space

    @property
    def systems(self) -> list[str]:
        """The particle systems' names, in order of creation."""
        return list(self.facts.get("systems") or measures.systems_of(self.load))

    def axis(self, system: str) -> str:
        """Return the axes along which a system's domains are cut.

        Args:
            system: the system's name.

        Returns:
            "x", "xz", ...; "hilbert", "morton"; "id" if particles are distributed by id.
        """
        axes = dict(zip(self.systems, self.facts.get("axes") or [], strict=False))
        return str(axes.get(system, self.facts.get("axis", "x")))

    @property
    def stretches(self) -> list[dict[str, Any]]:
        """Parts of a run that was continued from checkpoints: the first `frame` of each, and its facts.

        A run that was not continued has one part.
        """
        return stretches.of_facts(self.facts)

    def parts(self) -> list[Run]:
        """Divide the run where its ranks or their roles changed: it continued on others, or lost some.

        Returns:
            A run for each part, with the facts and rows of its frames; the run itself if nothing changed.
        """
        starts = stretches.changes(self.facts)
        if len(starts) == 1:
            return [self]
        known = {name: self.table(name) for name in TABLES if name != "spans"}
        parts = []
        for facts, then in zip(starts, [*starts[1:], {"frame": math.inf}], strict=True):
            mine = {
                name: rows[(rows["frame"] >= facts["frame"]) & (rows["frame"] < then["frame"])]
                for name, rows in known.items()
            }
            parts.append(Run({**facts, "name": self.name}, mine))
        return [part for part in parts if len(part.frames)] or [self]

    @property
    def unchanged(self) -> Run:
        """The run up to the first change of its ranks or their roles; the run itself if there is none."""
        return self.parts()[0]

    @property
    def calculators(self) -> list[int]:
        """The calculators' ranks in the order of their domains.

        For a continued run, the calculators of all stretches; each frame has rows only for its own stretch.
        """
        listed = [rank for part in self.stretches for rank in part.get("calculators") or []]
        return list(dict.fromkeys(listed)) or [int(rank) for rank in sorted(self.load["rank"].unique())]

    @property
    def ranks(self) -> int:
        """Number of ranks; the largest number if the run was continued on a different one."""
        listed = self.facts.get("ranks")
        least = len(listed) if isinstance(listed, list) else int(listed or len(self.calculators))
        return max([least, *(len(stretches.ranks_of(part)) for part in self.stretches)])

    @property
    def hosts(self) -> dict[int, str]:
        """Each rank's host; the last one if the run was continued elsewhere."""
        parts = self.stretches
        return {row["rank"]: row.get("host", "") for part in parts for row in stretches.ranks_of(part)}

    @property
    def speeds(self) -> dict[int, float]:
        """Factors by which ranks were slowed down on purpose (MOTES_SPEEDS); empty if none were."""
        return {int(rank): float(speed) for rank, speed in (self.facts.get("speeds") or {}).items()}

    # --- measures

    def by_rank(self, column: str = "t_compute_s", system: str | None = None) -> DataFrame:
        """Return one column of `load` as a table.

        Args:
            column: the column's name.
            system: the system's name; None: the sum over all systems.

        Returns:
            One row per frame, one column per calculator's rank.
        """
        return measures.by_rank(self.load, column, system)

    def imbalance(self, column: str = "t_compute_s", system: str | None = None) -> Series:
        """Compute largest / mean over the calculators; 1 is perfect.

        Args:
            column: measured seconds, or "n_end", particle counts, which are free of noise.
            system: the system's name; None: the sum over all systems.

        Returns:
            One number per frame.
        """
        return measures.imbalance(self.load, column, system)

    def efficiency(self, column: str = "t_compute_s", system: str | None = None) -> Series:
        """Compute mean / largest over the calculators: POP's load-balance efficiency.

        Args:
            column: measured seconds, or "n_end", particle counts, which are free of noise.
            system: the system's name; None: the sum over all systems.

        Returns:
            One number per frame.
        """
        return measures.efficiency(self.load, column, system)

    def efficiencies(self) -> DataFrame:
        """Divide parallel efficiency into factors, as defined by the POP Centre of Excellence.

        parallel = load_balance x communication, and communication = serialisation x transfer, over all ranks.
        `motes.analysis.factors` describes how each is measured.

        Returns:
            One row per frame, and one for the whole run, "all": parallel, load_balance, communication,
            serialisation, transfer, each 0..1. Empty for replays and logs of earlier versions.
        """
        from .efficiencies import efficiencies

        return efficiencies(part.times for part in self.parts())

    def explain(self) -> Explanation:
        """Explain what costs the run's time.

        Returns:
            At most six sentences with advice, the largest loss first; print it. `saving` is the part of the
            time that the best other balancer, `balancer`, would save, between `low` and `high`; below 0, it
            would lose. `losses` has causes and seconds.
        """
        from .explaining import explain

        return explain(self)

    def summary(self) -> dict[str, Any]:
        """Summarise the run in figures.

        Returns:
            Plain values by name, with units in the names; NaN where the log lacks the data.
        """
        from .explaining import most_saved_by

        frames = self.frames
        n = len(frames)
        seconds = float(frames["t_frame_s"].sum()) if n else 0.0
        worth = self.imbalance() if len(self.load) else None
        pop = self.efficiencies()
        factors = {name: float(pop[name].iloc[-1]) if len(pop) else math.nan for name in pop.columns}
        return {
            "run": self.name,
            "ranks": self.ranks,
            "calculators": len(self.calculators),
            "systems": len(self.systems),
            "space": "infinite" if self.space is None else self.space,
            "balancer": self.balancer,
            "finished": self.finished,
            "frames": n,
            "wall_s": seconds,
            "frames_per_s": n / seconds if seconds > 0 else math.nan,
            "particles": int(frames["particles"].max()) if n else 0,
            "mean_imbalance": math.nan if worth is None else float(worth.mean()),
            "mean_efficiency": math.nan if worth is None else float((1 / worth).mean()),
            **{f"{name}_efficiency": value for name, value in factors.items()},
            "balance_would_save": most_saved_by(self),
            "exchanged_per_frame": float(frames["exchanged"].mean()) if n else math.nan,
            "exchanged_bytes_per_frame": float(frames["exchanged_bytes"].mean()) if n else math.nan,
            "moved_to_balance": self._moved(),
        }

    def _moved(self) -> int:
        """Return the number of particles moved by balancing; for bricks, only those counted by donors."""
        rows = [system for system in self.systems if in_a_row(self.axis(system))]
        balance = self.balance
        ordered = balance[balance["given"].notna() | balance["system"].isin(rows)]
        return measures.moved_by_cuts(ordered, self.density)

    def warnings(self) -> list[str]:
        """Return what a reader of this run should know first.

        Returns:
            Sentences, the most important first.
        """
        from .summary import warnings

        return warnings(self)

    # --- plots and exports

    @cached_property
    def plot(self) -> Plots:
        """Plots: `run.plot.imbalance()`, `run.plot.heatmap("n_end")`, ...; each returns a matplotlib Axes."""
        from ._plots.one_run import Plots

        return Plots(self)

    def to_perfetto(self, path: str | os.PathLike[str]) -> Path:
        """Write a trace for ui.perfetto.dev and chrome://tracing: ranks, their phases, counters.

        Args:
            path: path of the file.

        Returns:
            The path.
        """
        from .trace import write_trace

        return write_trace(self, path)

    def to_lbaf(self, directory: str | os.PathLike[str]) -> list[Path]:
        """Write load data for LBAF, the Load Balancing Analysis Framework.

        A frame is a phase. Each calculator's particles form 16 migratable tasks per system, and its other
        work one task that cannot migrate; migrants are messages between neighbours.

        Args:
            directory: where to write motes.0.json, motes.1.json, ...; created if it does not exist.

        Returns:
            The files, one per rank.

        Raises:
            LogError: if the log has no frame, if the run has no systems, or if the files cannot be written.
        """
        from .lbaf import write_lbaf

        return write_lbaf(self, directory)

    def to_otf2(self, directory: str | os.PathLike[str]) -> Path:
        """Write an OTF2 archive for Vampir and Scalasca's tools.

        With `World(spans=True)` it has the phases of all ranks, with waits and messages; otherwise phases are
        estimated from durations. Needs the extra `[otf2]`.

        Args:
            directory: directory of the archive; must be new or empty.

        Returns:
            The archive's anchor file, traces.otf2.

        Raises:
            LogError: if the log has no frame, or the archive cannot be written.
        """
        from .otf2_trace import write_otf2

        return write_otf2(self, directory)

    def replay(
        self,
        balancer: Balancer,
        *,
        powers: Sequence[float] | None = None,
        migrant_s: float | None = None,
    ) -> Run:
        """Predict this run under another balancer, up to the first change of its ranks or their roles.

        Args:
            balancer: the other balancer.
            powers: the machines' powers, one per calculator on any scale, if known; None: measured speeds are
                attributed to the machines, or, of another code's tasks, to the tasks. `motes.replay.predict`
                explains both.
            migrant_s: seconds per migrant for each of its two calculators, for example from
                `motes.cluster.migrant_s(cluster)`. None: as the log tells; load files do not, so nothing.

        Returns:
            A run with the same tables and plots. `frames` also has `t_frame_low_s` and `t_frame_high_s`,
            bounds of each frame's seconds.

        Raises:
            LogError: if the log has no densities.
            ArgumentError: for a wrong argument, such as `migrant_s` for another code's tasks.
        """
        from ..replay import predict, predict_tasks  # need the compiled core, unlike the rest

        if self._loads is None:
            rows = predict(self, balancer, powers=powers, migrant_s=migrant_s)
        elif migrant_s is None:
            rows = predict_tasks(self._loads, balancer, powers=powers)
        else:
            raise ArgumentError(
                "migrant_s", migrant_s, "None: load files do not tell what moving a task costs"
            )
        facts = {
            **self.unchanged.facts,
            "name": f"{self.name} with {balancer!r}",
            "balancer": repr(balancer),
            "replay_of": self.name,
        }
        return Run(facts, {name: frame_of(table, TABLES[name].columns) for name, table in rows.items()})

    def __repr__(self) -> str:
        """Show name, size and balancer."""
        where = self.name if self.path is None else str(self.path)
        return f"<Run {where}: {self.ranks} ranks, {len(self.frames)} frames, {self.balancer}>"

    def _repr_html_(self) -> str:
        from .summary import html

        return html(self)
