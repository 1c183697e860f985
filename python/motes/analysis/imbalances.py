"""Losses of a run's time to particles that are shared unevenly, and to a calculator that is slow."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ._tables import measures
from .efficiencies import work_by_rank
from .losses import Loss, Part, told_s
from .saving import Saving, saving, sentence_of

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["imbalances", "most_saved", "saved_s", "saving_of_part"]

_SLOW = 1.25
"""A calculator is slow if it takes this many times as long per particle as others."""
_STEADY = 0.5
"""The imbalance is that of certain ranks if at least this fraction of it remains in means over all frames."""
_UNDONE = 0.5
"""Balancing thrashes if at least this fraction of what it moves undoes its previous move."""
_MUCH = 0.2
"""Moves matter if they are at least this fraction of the particles that the fullest rank holds too many."""


def saved_s(part: Part) -> float:
    """Return the mean seconds per frame that perfect balance would save if moving particles cost nothing.

    Then calculators hold particles in proportion to their machines' speeds.

    No frame can become shorter than the longest work of a rank that is not a calculator.
    """
    act, seconds = _acting(part), part.seconds
    saved = (act.max(axis=1) - measures.balanced_s(part.load, act)).reindex(seconds.index).fillna(0.0)
    room = seconds
    if not part.times.empty:
        work = work_by_rank(part.times).drop(columns=list(act.columns), errors="ignore")
        room = seconds - work.max(axis=1).reindex(seconds.index).fillna(0.0)
    return float(saved.clip(lower=0.0, upper=room.clip(lower=0.0)).mean())


def saving_of_part(part: Part) -> Saving:
    """Estimate what balancing would save in a part of a run; NaN if its log lacks the data."""
    return saving(part.run, most_saved(part))


def most_saved(part: Part) -> float:
    """Return the fraction of a part's time that perfect balance would save if it cost nothing, or NaN."""
    known = part.frame_s > 0 and not part.load.empty
    return saved_s(part) / part.frame_s if known else float("nan")


def _acting(part: Part) -> DataFrame:
    """Return the seconds of actions, frame x calculator, including time taken by the operating system."""
    act = measures.by_rank(part.load, "t_compute_s").fillna(0.0)
    if part.times.empty:
        return act
    spent = part.times.assign(own=part.times["act_s"] + part.times["other_s"])
    own = spent.pivot(index="frame", columns="rank", values="own")
    own = own.reindex(index=act.index, columns=act.columns).fillna(0.0)
    return act.where(act > own, own)


def imbalances(part: Part) -> Iterator[Loss]:
    """Yield the losses due to unevenly shared particles, and to a calculator that is slow per particle."""
    load = part.load
    if load.empty or load["rank"].nunique() < 2:
        return
    held = measures.by_rank(load.assign(n=load["n_start"] + load["created"]), "n").fillna(0.0)
    act = _acting(part).mean()
    n = held.mean()
    known = n > 0
    if not known.any() or act.max() <= 0:
        return
    each = (act / n)[known].sort_values()
    usual = float(each.iloc[(len(each) - 1) // 2])
    saved = saved_s(part)
    excess = float((held.max(axis=1) - held.mean(axis=1)).mean())
    uneven = min(usual * excess, saved)
    yield _uneven(part, held, excess, uneven)
    slow = int(str(act.idxmax()))
    if slow not in each.index or each[slow] <= _SLOW * usual:
        return
    late = saved - uneven
    yield Loss("slow rank", late, slow, _slow_sentence(part, slow, float(each[slow] / usual), late))


def _uneven(part: Part, held: DataFrame, excess: float, seconds: float) -> Loss:
    """Return the loss of particles held unevenly: by the same rank, in turn, or because of balancing."""
    costs = part.costs(seconds)
    if (thrashing := _thrashing(part, excess)) is not None:
        text = f"Thrashing: {part.run.balancer} moves particles back and forth ({thrashing}), which "
        text += f"costs {costs}"
        advice = "let it act less often, move less at a time or only above a higher threshold"
        return Loss("thrashing", seconds, None, f"{text}: {advice}, or try another balancer.")
    n = held.mean()
    if float(n.max() - n.mean()) >= _STEADY * excess:
        most = int(str(n.idxmax()))
        text = f"Imbalance: rank {most} holds {n.max() / n.mean():.2g} times the mean number of particles"
        return Loss("imbalance", seconds, most, f"{text}, which costs {costs}: {_balancer(part)}.")
    factor = float((held.max(axis=1) / held.mean(axis=1)).mean())
    fullest = held.idxmax(axis=1).value_counts(normalize=True)
    who = ", ".join(f"rank {rank} in {share:.0%} of the frames" for rank, share in fullest.iloc[:3].items())
    text = (
        f"Moving imbalance: the fullest rank holds {factor:.2g} times the mean number of particles, but it "
    )
    text += f"is another one again and again ({who}), which costs {costs}"
    advice = "balance more often, or predict: a Balancer of your own can aim at where particles will be"
    if part.run.balancer.startswith("Static"):
        advice = _balancer(part)
    return Loss("moving imbalance", seconds, None, f"{text}: {advice}.")


def _thrashing(part: Part, excess: float) -> str | None:
    """Return how much of balancing is undone by the next move, as text; None if it is little."""
    rows = part.run.balance
    undone = moved = most = 0.0
    worst = None
    for _, cut in rows[rows["frame"].isin(part.seconds.index)].groupby(["system", "left_rank"]):
        moves = _moves(cut.sort_values("frame"))
        sizes, back = np.abs(moves), moves[1:] * moves[:-1] < 0
        again = float(np.minimum(sizes[1:], sizes[:-1])[back].sum())
        undone, moved = undone + again, moved + float(sizes.sum())
        if again > most:
            pair = "ranks {} and {}".format(*cut[["left_rank", "right_rank"]].iloc[0])
            most, worst = again, f"{int(back.sum())} of {len(moves)} moves between {pair} undo the one before"
    much = _MUCH * excess * len(part.seconds)
    return worst if undone >= _UNDONE * moved and moved >= much else None


def _moves(cut: DataFrame) -> npt.NDArray[np.float64]:
    """Return the particles that moved across a cut at each of its moves, to the right if positive.

    Donors count them. Balancers that replace all cuts have no counts: then they are taken from what the next
    row says of both sides.
    """
    given = cut["given"].to_numpy(np.float64)
    shift = (cut["cut_before"] - cut["cut_after"]).to_numpy(np.float64)
    more = (cut["n_left"] - cut["n_right"]).diff().shift(-1).to_numpy(np.float64)
    moves = np.where(np.isnan(given), np.sign(shift) * np.abs(more) / 2, given)
    known: npt.NDArray[np.float64] = moves[np.nan_to_num(moves) != 0]
    return known


def _slow_sentence(part: Part, rank: int, factor: float, late: float) -> str:
    start = f"Slow rank {rank}: it takes {factor:.2g} times as long per particle as others, which costs "
    start += part.costs(late)
    if not part.times.empty:
        spent = part.times[part.times["rank"] == rank][["act_s", "other_s"]].mean()
        if spent["other_s"] > spent["act_s"]:
            return (
                f"{start}; for {told_s(spent['other_s'])} it slept, or other processes had its core: check "
                "callbacks for sleep or file access, and use no more ranks than cores."
            )
    return f"{start}: {_balancer(part, 'that measures speeds')}, or leave this machine out."


def _balancer(part: Part, which: str = "") -> str:
    saving = saving_of_part(part)
    if saving.balancer:
        return sentence_of(saving)
    if part.run.balancer.startswith("Static"):
        return f"try a balancer{' ' + which if which else ''} (--balancer pairwise, or PrefixCuts())"
    return f"try a balancer other than {part.run.balancer}, or let it act more often"
