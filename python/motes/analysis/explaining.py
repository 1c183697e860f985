"""Explain what costs a run's time: `Run.explain`."""

from __future__ import annotations

import html
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ._tables import measures
from ._tables.stretches import latest
from .efficiencies import efficiencies, frame_seconds, work_by_rank
from .saving import Saving, saving, told

if TYPE_CHECKING:
    from pandas import DataFrame, Series

    from .run import Run

__all__ = ["Explanation", "Loss", "explain", "frame_s_of", "saving_of", "told_s"]

MOST_SENTENCES = 6
LEAST_PART = 0.02
"""Losses below this fraction of the frame are not reported."""
_SLOW = 1.25
"""A calculator is slow if it takes this many times as long per particle as others."""
_ALONE = {
    "script": "its script takes {own}, compared with {others} on others: do less in Python on this rank, or "
    "use a separate thread",
    "births": "creating particles takes {own}, compared with {others} on others: let calculators create them "
    '(births="calculators")',
    "talk": "reports, plans and packing take {own}, compared with {others} on others: balance less often or "
    'with a simpler balancer, or set combine="together"',
    "picture": "its part of the picture takes {own}, compared with {others} on others: let all ranks draw "
    '(path="tiles" or "composite"), or make the picture smaller',
    "log": "writing the log takes {own}, compared with {others} on others: log to a local disk, or log less",
    "other": "the operating system takes {own} from it, compared with {others} from others: give it a core "
    "of its own",
}


@dataclass(frozen=True)
class Loss:
    """Time lost per frame to one cause.

    Attributes:
        cause: "imbalance", "slow rank", "network", "script", "log", "talk", "system"; or the role of a rank
            for which others wait: "manager", "image generator" or "rank".
        seconds: mean seconds lost per frame.
        rank: the rank responsible; None: all ranks.
        sentence: description of the loss, and advice.
    """

    cause: str
    seconds: float
    rank: int | None
    sentence: str


@dataclass(frozen=True)
class Explanation:
    """Losses of a run's time; prints as sentences, the largest loss first.

    Attributes:
        losses: at most six losses, each with its cause, seconds per frame and a sentence.
        saving: part of the run's time that the best other balancer would save; below 0: it would lose.
        frame_s: mean seconds per frame.
        low: lower bound of `saving`.
        high: upper bound.
        balancer: its name, such as "PrefixCuts"; "": none could be replayed.
    """

    losses: tuple[Loss, ...]
    saving: float
    frame_s: float
    low: float = float("nan")
    high: float = float("nan")
    balancer: str = ""

    @property
    def sentences(self) -> list[str]:
        """The sentences, at most six."""
        if self.losses:
            return [loss.sentence for loss in self.losses]
        return [f"Nothing stands out: no single cause takes {LEAST_PART:.0%} of the frame."]

    def __str__(self) -> str:
        """Return the sentences as lines."""
        return "\n".join(self.sentences)

    __repr__ = __str__

    def html(self) -> str:
        """Return the sentences as an HTML list."""
        lines = "".join(f"<li>{html.escape(text)}</li>" for text in self.sentences)
        return f"<ol>{lines}</ol>"

    _repr_html_ = html


def explain(run: Run) -> Explanation:
    """Return the losses of a run's time; documented in `Run.explain`."""
    seconds = frame_s_of(run)
    losses = [*_of_calculators(run, seconds)]
    times = _settled(run.times)
    if not times.empty:
        spent = times.groupby("rank").mean()
        losses += [*_alone(run, spent, seconds), *_of_all(spent, seconds)]
        losses += _network(run, times, seconds)
    worth = [loss for loss in losses if seconds > 0 and loss.seconds >= LEAST_PART * seconds]
    worth.sort(key=lambda loss: -loss.seconds)
    found = _saving(run)
    return Explanation(
        tuple(worth[:MOST_SENTENCES]), found.part, seconds, found.low, found.high, found.balancer
    )


def saving_of(run: Run) -> float:
    """Return the part of the run's time that the best other balancer would save; below 0: it would lose."""
    return _saving(run).part


def _saving(run: Run) -> Saving:
    seconds = frame_s_of(run)
    return saving(run, _saved_s(run) / seconds if seconds > 0 and not run.load.empty else float("nan"))


def frame_s_of(run: Run) -> float:
    """Return the mean seconds of a frame."""
    seconds = _seconds(run)
    return float(seconds.mean()) if len(seconds) else 0.0


def _saved_s(run: Run) -> float:
    """Return the mean seconds per frame that perfect balance would save.

    No frame can become shorter than the longest work of a rank that is not a calculator.
    """
    act, seconds = _acting(run), _seconds(run)
    balanced = measures.balanced_s(_settled(run.load), act)
    saved = (act.max(axis=1) - balanced).reindex(seconds.index).fillna(0.0)
    room = seconds
    if not run.times.empty:
        work = work_by_rank(run.times).drop(columns=list(act.columns), errors="ignore")
        room = seconds - work.max(axis=1).reindex(seconds.index).fillna(0.0)
    return float(saved.clip(upper=room.clip(lower=0.0)).mean())


def _settled(table: DataFrame) -> DataFrame:
    """Drop the first frame, which opens files and allocates memory, unless fewer than three would remain."""
    first = table["frame"].min()
    later = table[table["frame"] > first]
    return later if later["frame"].nunique() >= 3 else table


def _seconds(run: Run) -> Series:
    """Return the seconds of each frame."""
    times = _settled(run.times)
    return _settled(run.frames).set_index("frame")["t_frame_s"] if times.empty else frame_seconds(times)


def _acting(run: Run) -> DataFrame:
    """Return the seconds of actions, frame x calculator, including time taken by the operating system."""
    act = measures.by_rank(_settled(run.load), "t_compute_s").fillna(0.0)
    if run.times.empty:
        return act
    spent = run.times.assign(own=run.times["act_s"] + run.times["other_s"])
    own = spent.pivot(index="frame", columns="rank", values="own")
    own = own.reindex(index=act.index, columns=act.columns).fillna(0.0)
    return act.where(act > own, own)


def _of_calculators(run: Run, frame_s: float) -> Iterator[Loss]:
    """Yield the losses due to unevenly shared particles, and to a calculator that is slow per particle."""
    load = _settled(run.load)
    if load.empty or load["rank"].nunique() < 2:
        return
    held = measures.by_rank(load.assign(n=load["n_start"] + load["created"]), "n").fillna(0.0)
    act = _acting(run).mean()
    n = held.mean()
    known = n > 0
    if not known.any() or act.max() <= 0:
        return
    each = (act / n)[known].sort_values()
    usual = float(each.iloc[(len(each) - 1) // 2])
    saved = _saved_s(run)
    uneven = min(float(usual * (held.max(axis=1) - held.mean(axis=1)).mean()), saved)
    most = int(str(n.idxmax()))
    yield Loss(
        "imbalance",
        uneven,
        most,
        f"Imbalance: rank {most} holds {n.max() / n.mean():.2g} times the mean number of particles, which "
        f"costs {told_s(uneven)} of a frame's {told_s(frame_s)}: {_balancer(run)}.",
    )
    slow = int(str(act.idxmax()))
    if slow not in each.index or each[slow] <= _SLOW * usual:
        return
    late = saved - uneven
    yield Loss("slow rank", late, slow, _slow_sentence(run, slow, float(each[slow] / usual), late, frame_s))


def _slow_sentence(run: Run, rank: int, factor: float, late: float, frame_s: float) -> str:
    times = _settled(run.times)
    start = f"Slow rank {rank}: it takes {factor:.2g} times as long per particle as others, which costs "
    start += f"{told_s(late)} of a frame's {told_s(frame_s)}"
    if not times.empty:
        spent = times[times["rank"] == rank][["act_s", "other_s"]].mean()
        if spent["other_s"] > spent["act_s"]:
            return (
                f"{start}; for {told_s(spent['other_s'])} it slept, or other processes had its core: check "
                "callbacks for sleep or file access, and use no more ranks than cores."
            )
    return f"{start}: {_balancer(run)}; or leave this machine out."


def _balancer(run: Run) -> str:
    return told(_saving(run))


def _alone(run: Run, spent: DataFrame, frame_s: float) -> Iterator[Loss]:
    """Yield the losses due to work of one rank for which the others wait."""
    if len(spent) < 2:
        return
    facts = latest(run.facts)
    for rank in map(int, spent.index):
        others = spent.drop(index=rank)
        names = [name for name in _ALONE if name != "other" or rank not in run.calculators]
        own = {name: float(spent[f"{name}_s"].loc[rank]) for name in names}
        usual = {name: float(others[f"{name}_s"].median()) for name in names}
        more = {name: own[name] - usual[name] for name in names}
        excess = sum(max(seconds, 0.0) for seconds in more.values())
        largest = max(more, key=lambda name: more[name])
        who = "rank"
        if rank == facts.get("image_generator") and (largest == "picture" or rank != facts.get("manager")):
            who = "image generator"
        elif rank == facts.get("manager"):
            who = "manager"
        loss = min(excess, float(others["wait_s"].mean()))
        advice = _ALONE[largest].format(own=told_s(own[largest]), others=told_s(usual[largest])) + "."
        slow = list(run.events["text"][run.events["kind"] == "slow_balancer"])
        if who == "manager" and largest == "talk" and slow:
            advice = f"{slow[0]}."
        title = f"Rank {rank}" if who == "rank" else f"{who.capitalize()} (rank {rank})"
        yield Loss(
            who,
            loss,
            rank,
            f"{title}: others wait {told_s(loss)} of a frame's {told_s(frame_s)} for it; {advice}",
        )


def _of_all(spent: DataFrame, frame_s: float) -> Iterator[Loss]:
    """Yield the losses that every rank has, which more ranks do not reduce."""
    script = float(spent["script_s"].min())
    yield Loss(
        "script",
        script,
        None,
        f"Script: its own Python takes {told_s(script)} of a frame's {told_s(frame_s)} on every "
        "rank, which more ranks do not reduce: use arrays instead of loops, or read and write less.",
    )
    log, talk, other = (float(spent[f"{name}_s"].median()) for name in ("log", "talk", "other"))
    yield Loss(
        "log",
        log,
        None,
        f"Log: writing it takes {told_s(log)} of a frame's {told_s(frame_s)}: log to a local disk.",
    )
    yield Loss(
        "talk",
        talk,
        None,
        f"Talk: reports, packing and reading take {told_s(talk)} of a frame's {told_s(frame_s)} on every "
        'rank: use fewer ranks or more particles, or set combine="together".',
    )
    yield Loss(
        "system",
        other,
        None,
        f"System: other processes, sleep or the disk take {told_s(other)} of a frame's {told_s(frame_s)} "
        "from every rank: use no more ranks than cores, on an otherwise idle machine.",
    )


def _network(run: Run, times: DataFrame, frame_s: float) -> Iterator[Loss]:
    """Yield the loss due to messages in flight, or to ranks that wait for a core on a crowded host."""
    transfer = efficiencies(run.times)["transfer"].reindex(sorted(times["frame"].unique()))
    lost = float(((1 - transfer.to_numpy()) * frame_seconds(times).to_numpy()).mean())
    cores = run.facts.get("cores")
    if cores and len(set(run.hosts.values())) == 1 and run.ranks > int(cores):
        yield Loss(
            "system",
            lost,
            None,
            f"System: {run.ranks} ranks share {cores} cores, so a rank whose message has arrived waits for a "
            f"core, which costs {told_s(lost)} of a frame's {told_s(frame_s)}: use no more ranks than cores.",
        )
        return
    sent = run.frames["exchanged_bytes"].mean() + run.frames["render_bytes"].fillna(0.0).mean()
    yield Loss(
        "network",
        lost,
        None,
        f"Network: messages in flight cost {told_s(lost)} of a frame's {told_s(frame_s)} "
        f"({sent / 1024:.3g} KiB of particles and pictures): try a faster network, fewer ranks, "
        'smaller pictures, or combine="together".',
    )


def told_s(seconds: float) -> str:
    """Return seconds as text: "12.3 ms"."""
    return f"{seconds:.3g} s" if seconds >= 1 else f"{seconds * 1e3:.3g} ms"
