"""Losses of a run's time to single ranks for which others wait, to work that all ranks have, to messages."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from .efficiencies import chain_by_frame, work_by_rank
from .losses import Loss, Part, told_s

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["delays"]

_IDLE = 0.5
"""A script waits rather than works if it is without the processor for at least this fraction of its time."""
_FEW, _SHORT_S = 10_000, 5e-3
"""Particles per calculator, and seconds, below which a frame is too small for its ranks."""
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
_ASLEEP = (
    "its script takes {own}, compared with {others} on others, mostly without the processor: it sleeps, "
    "waits for files or the network, or other processes have its core"
)


def delays(part: Part) -> Iterator[Loss]:
    """Yield the losses of a part of a run that are not about the shares of its calculators."""
    yield from _seldom(part)
    if part.times.empty:
        return
    spent = part.times.groupby("rank").mean()
    yield from _alone(part, spent)
    yield from _of_all(part, spent)
    yield from _network(part, spent)


def _seldom(part: Part) -> Iterator[Loss]:
    """Yield the losses in single frames: checkpoints, and recovery in a part's first frame."""
    times = part.run.times
    saving = part.times.groupby("frame")["checkpoint_s"].max()
    checkpoint = float(saving.mean()) if len(saving) else 0.0
    often = int((saving > 0.1 * saving.max()).sum())
    yield Loss(
        "checkpoint",
        checkpoint,
        None,
        f"Checkpoints: writing them takes {part.costs(checkpoint)} on average, in {often} frames: write them "
        "less often (Checkpoint(every=...)), or to a faster disk.",
    )
    lost = float(times["recovery_s"].max()) if len(times) else 0.0
    each = lost / max(part.frames, 1)
    yield Loss(
        "recovery",
        each if lost > 0 else 0.0,
        None,
        f"Recovery: a loss of ranks cost {told_s(lost)}, to restore replicas and to run frames again: "
        f"{part.costs(each)} on average; the others then share the lost ranks' particles.",
    )


def _alone(part: Part, spent: DataFrame) -> Iterator[Loss]:
    """Yield the losses due to work of one rank for which the others wait."""
    if len(spent) < 2:
        return
    for rank in map(int, spent.index):
        others = spent.drop(index=rank)
        names = [name for name in _ALONE if name != "other" or rank not in part.run.calculators]
        idle = float(spent["script_idle_s"].loc[rank])
        own = {name: float(spent[f"{name}_s"].loc[rank]) for name in names}
        if part.crowded:  # the script's time without the processor is counted in _network
            own["script"] -= idle
        usual = {name: float(others[f"{name}_s"].median()) for name in names}
        more = {name: own[name] - usual[name] for name in names}
        excess = sum(max(seconds, 0.0) for seconds in more.values())
        largest = max(more, key=lambda name: more[name])
        who = _who(part, rank, largest)
        loss = min(excess, _waited_for(part, rank, others))
        text = _ALONE[largest]
        if largest == "script" and not part.crowded and idle > _IDLE * own["script"]:
            text = _ASLEEP
        advice = text.format(own=told_s(own[largest]), others=told_s(usual[largest])) + "."
        slow = list(part.run.events["text"][part.run.events["kind"] == "slow_balancer"])
        if who == "manager" and largest == "talk" and slow:
            advice = f"{slow[0]}."
        title = f"Rank {rank}" if who == "rank" else f"{who.capitalize()} (rank {rank})"
        yield Loss(who, loss, rank, f"{title}: others wait {part.costs(loss)} for it; {advice}")


def _who(part: Part, rank: int, work: str) -> str:
    """Return the role in which a rank is late with some work."""
    facts = part.run.facts
    if rank == facts.get("image_generator") and (work == "picture" or rank != facts.get("manager")):
        return "image generator"
    return "manager" if rank == facts.get("manager") else "rank"


def _waited_for(part: Part, rank: int, others: DataFrame) -> float:
    """Return how long the other ranks waited because of this one, in seconds per frame.

    Logs of earlier versions know only whose message was awaited, which says little: there, all waits count.
    """
    waits = part.run.waits()
    if not part.run.knows_who_is_late:
        return float(others["wait_s"].mean())
    late = (waits["waited_for"] == rank) & waits["frame"].isin(part.times["frame"])
    frames = max(part.times["frame"].nunique(), 1)
    return float(waits["seconds"][late & (waits["rank"] != rank)].sum()) / len(others) / frames


def _of_all(part: Part, spent: DataFrame) -> Iterator[Loss]:
    """Yield the losses that every rank has, which more ranks do not reduce."""
    idle = float(spent["script_idle_s"].min())
    script = float((spent["script_s"] - spent["script_idle_s"]).min())
    yield Loss(
        "script",
        script,
        None,
        f"Script: its own Python takes {part.costs(script)} on every "
        "rank, which more ranks do not reduce: use arrays instead of loops, or read and write less.",
    )
    picture, log, talk, other = (
        float(spent[f"{name}_s"].agg(of))
        for name, of in (("picture", "min"), ("log", "median"), ("talk", "median"), ("other", "median"))
    )
    yield Loss(
        "picture",
        picture,
        None,
        f"Picture: drawing takes {part.costs(picture)} on every rank: make the picture or its particles "
        "smaller, or draw every other frame.",
    )
    yield Loss("log", log, None, f"Log: writing it takes {part.costs(log)}: log to a local disk.")
    yield Loss(
        "talk",
        talk,
        None,
        f"Talk: reports, packing and reading take {part.costs(talk)} on every "
        'rank: use fewer ranks or more particles, or set combine="together".',
    )
    if part.crowded:
        return  # counted in _network
    yield Loss(
        "system",
        other,
        None,
        f"System: other processes, sleep or the disk take {part.costs(other)} "
        "from every rank: use no more ranks than cores, on an otherwise idle machine.",
    )
    yield Loss(
        "script",
        idle,
        None,
        f"Script: on every rank it is without the processor for {part.costs(idle)}: it sleeps, waits for "
        "files or the network, or other processes have its core.",
    )


def _network(part: Part, spent: DataFrame) -> Iterator[Loss]:
    """Yield the loss due to messages in flight, or to ranks that wait for a core on a crowded host."""
    frames = part.times["frame"].unique()
    chain = float(chain_by_frame(part.run.times).reindex(frames).mean())
    work = float(work_by_rank(part.times).mean().max())
    lost = max(part.frame_s - max(chain, work), 0.0)
    run = part.run
    if part.crowded:
        idle, other = float(spent["script_idle_s"].min()), float(spent["other_s"].median())
        lost += idle + other
        where = (
            f"{told_s(idle)} in the script, {told_s(other)} in actions and pictures, the rest when messages"
        )
        yield Loss(
            "system",
            lost,
            None,
            f"System: {run.ranks} ranks share {run.facts['cores']} cores, so ranks that could work wait, "
            f"which costs {part.costs(lost)} ({where} have arrived): use no more ranks than cores.",
        )
        return
    yield _in_flight(part, spent, lost)


def _in_flight(part: Part, spent: DataFrame, lost: float) -> Loss:
    """Return the loss of messages in flight: the network's, or that of frames too small for their ranks."""
    run = part.run
    held = run.load.groupby(["frame", "rank"])["n_end"].sum().mean() if len(run.load) else 0.0
    act, talk = float(spent["act_s"].max()), float(spent["talk_s"].median())
    if held < _FEW and part.frame_s < _SHORT_S and act < lost:
        return Loss(
            "small frames",
            lost,
            None,
            f"Small frames: messages in flight cost {part.costs(lost)}, more than the actions "
            f"({told_s(act)}) on {held:.3g} particles per calculator; reports and packing take "
            f"{told_s(talk)}: "
            'use fewer ranks or more particles, or set combine="together".',
        )
    sent = run.frames["exchanged_bytes"].mean() + run.frames["render_bytes"].fillna(0.0).mean()
    return Loss(
        "network",
        lost,
        None,
        f"Network: messages in flight cost {part.costs(lost)} "
        f"({sent / 1024:.3g} KiB of particles and pictures): try a faster network, fewer ranks, "
        'smaller pictures, or combine="together".',
    )
