"""The start of a run: every rank learns about every other, and all agree before anything can block.

Collective, in this order: wait until all ranks are there (`attendance`), exchange where each runs, compare
the settings, let the manager claim the log. An error on one rank is raised on every rank.
"""

from __future__ import annotations

import contextlib
import json
import os
import struct
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from .._io.output import tell
from .._mpi import launchers
from .._run import attendance, collectives, ending, open_worlds
from .._run.losses import lost_ranks, unless_lost
from .._run.peers import Peer, PeerWatch
from .._run.process import OpenRun, process
from .._run.settings import RunSettings
from .._run.threads import MASK_BYTES, Place, are_crowded, most_threads, processors, threads_of
from .._run.waiting import Wait, poll, warn_s
from .._values import environment
from .._values.space import ends_of
from ..errors import ArgumentError, LogError, MotesError, ScriptMismatchError, place

if TYPE_CHECKING:
    from mpi4py import MPI

    from .._checkpoint.finding import Origin
    from .._live.repeating import Repeated

__all__ = ["Met", "begin", "begin_again", "close", "meet"]

_CARD = struct.Struct(f"<i64s64siqQ96s16sii{MASK_BYTES}s48s")  # what each rank reports about itself
_ALL = "other ranks to enter the world"


def begin(comm: MPI.Intracomm, *, without_lost: bool = False) -> OpenRun:
    """Open a run once every rank of `comm` is about to start it. Collective.

    If a rank's script has ended, report it and end the job. The same happens if a rank is lost, unless
    `without_lost` is set: then `process.left` becomes the communicator of the survivors.
    """
    ending.install()  # in case motes did not start MPI
    launchers.check_alone()
    with _left_ends():
        attendance.begin(comm, without_lost=without_lost)
    if without_lost and process.survives and comm.size > 1:
        _count_left(comm)
    return process.open(OpenRun())


def begin_again(comm: MPI.Intracomm, run: OpenRun, *, failed: bool) -> bool:
    """Open a run that was closed between two calls, once every rank of `comm` makes the call. Collective.

    Return whether the call may have `failed` on a rank.
    """
    with _left_ends():
        may_have_failed = attendance.begin(comm, failed=failed)
    process.open(run)
    return may_have_failed


def _count_left(comm: MPI.Intracomm) -> None:
    from mpi4py import MPI

    left = MPI.Intracomm(comm.Shrink())
    if left.size == comm.size:
        with unless_lost():
            left.Free()
        return
    process.left = left
    if left.rank == 0:
        lost = ", ".join(f"rank {rank}" for rank in sorted(lost_ranks(comm)))
        goes = "1 rank continues" if left.size == 1 else f"{left.size} ranks continue"
        tell(f"motes: lost {lost} between two worlds; {goes}")


class Met(NamedTuple):
    """What every rank knows after the handshake."""

    settings: RunSettings
    origin: Origin | None
    """Where the run's checkpoints are, and which one it continues from; None: it has none."""
    repeats: Repeated | None
    """The run whose orders this one repeats, if any."""


def meet(run: OpenRun, comm: MPI.Intracomm, settings: RunSettings, role: str) -> Met:
    """Fill in the run: communicator, peers, log. Collective.

    The returned settings hold the seed that all ranks agreed on and this rank's threads. Every rank raises
    ScriptMismatchError if ranks were given different settings, or whatever `LogDirectory.claim` raises on the
    manager.
    """
    from mpi4py import MPI

    run.role, run.frame, run.warn_s = role, 0, warn_s(settings.stall_s)
    run.noted = open_worlds.enter(process.rank, f"{process.entered + 1}.starts")
    run.comm = duplicate = _duplicate(comm, settings)
    if comm.size > 1 and MPI.Comm.Compare(comm, MPI.COMM_WORLD) not in (MPI.IDENT, MPI.CONGRUENT):
        own = comm.Get_group()
        run.ranks = own.Translate_ranks(list(range(comm.size)), MPI.COMM_WORLD.Get_group())
    wish = int.from_bytes(os.urandom(8), "big") if settings.seed is None else settings.seed
    text = json.dumps(settings.compared()).encode()
    cards = _exchange_cards(duplicate, Peer.here(rank=comm.rank, role=role), wish, text, settings)
    run.peers = [card.peer for card in cards]
    places = [card.place for card in cards]
    run.threads = threads_of(places)
    run.watch = PeerWatch(run.peers, rank=comm.rank)
    _compare(duplicate, cards, text, settings)
    repeats = _find_repeated(run, settings)
    if repeats is not None:
        settings = settings._replace(seed=repeats.seed)
    origin = _find_checkpoint(run, settings)
    seed = cards[0].wish if settings.seed is None else settings.seed
    if origin is not None and origin.manifest is not None:
        seed = origin.manifest.seed
    settings = settings.agreed(
        seed=seed,
        threads=run.threads[comm.rank],
        continued_from=settings.continued_from if origin is None or settings.excerpt else origin.frame,
        crowded=are_crowded(places),
    )
    _claim_log(run, settings)
    process.entered += 1
    open_worlds.note_checkpoints(settings.checkpoint is not None)
    starts, run.noted = run.noted, open_worlds.enter(process.rank, f"{run.peers[0].pid}.{process.entered}")
    open_worlds.leave(starts)
    return Met(settings, origin, repeats)


def _duplicate(comm: MPI.Intracomm, settings: RunSettings) -> MPI.Intracomm:
    """Return a duplicate of a communicator. Collective."""
    from mpi4py import MPI

    if not process.survives or comm.size == 1:
        duplicate, request = comm.Idup()
        _wait_for(request, comm, settings.stall_s, _ALL)
        return duplicate
    # Open MPI 5.0 crashes if a rank is lost while a communicator is being duplicated.
    duplicate = MPI.Intracomm(comm.Shrink())
    if duplicate.size < comm.size:
        with _left_ends():
            attendance.check_lost(comm)
    return duplicate


def _find_repeated(run: OpenRun, settings: RunSettings) -> Repeated | None:
    """Read the run that this one repeats, if any."""
    if settings.steering is None:
        return None
    from .._live import repeating

    comm, home = run.comm, settings.roles[1]
    assert comm is not None

    try:
        return repeating.agree(
            settings.steering,
            reads=comm.rank == home,
            seed=settings.seed,
            broadcast=lambda text: _broadcast(comm, text, home, settings),
        )
    except ArgumentError as error:
        error.speaker = home
        raise


def _find_checkpoint(run: OpenRun, settings: RunSettings) -> Origin | None:
    """Find the checkpoint that the run continues from; return None if the run takes none."""
    if settings.checkpoint is None:
        return None
    from .._checkpoint.finding import Wishes, find

    assert run.comm is not None
    manager, _, calculators = settings.roles
    return find(
        run.comm,
        manager,
        Wishes(
            checkpoint=settings.checkpoint,
            seed=settings.seed,
            dt=settings.dt,
            substeps=settings.substeps,
            periodic=ends_of(settings.periodic),
            calculators=len(calculators),
            fresh=environment.read("MOTES_FRESH"),
            anyway=environment.read("MOTES_ANYWAY"),
            stall_s=settings.stall_s,
            most=None if settings.excerpt is None else settings.excerpt.first,
        ),
    )


def close(run: OpenRun, *, well: bool) -> None:
    """End a run: afterwards the rank may leave the script, unless another run is open.

    `well`: all ranks reached the end; otherwise skip collective clean-up.
    """
    from .._run import busy

    process.close(run)
    if well and process.survives:
        open_worlds.end(run.noted)
        forget_lost()
    open_worlds.leave(run.noted)
    if run.log is not None:
        run.log.release()
    if run.watch is not None:
        run.watch.close()
    if run.comm is not None and (well or run.comm.size == 1):
        busy.take_notes(run)
        if run.comm != process.left and not lost_ranks(run.comm):
            run.comm.Free()
    run.comm = None


def forget_lost() -> None:
    """Remove the launcher's notes about lost ranks: the others have finished the run without them."""
    from mpi4py import MPI

    for rank in lost_ranks(MPI.COMM_WORLD):
        open_worlds.forget(rank)


class _Card:
    """What a rank reported about itself."""

    def __init__(self, content: Sequence[Any]) -> None:
        (
            rank,
            role,
            host,
            pid,
            started,
            self.wish,
            space,
            self.digest,
            threads,
            most,
            mask,
            machine,
        ) = content
        fields = [field.rstrip(b"\0").decode(errors="replace") for field in (role, host, space, machine)]
        self.peer = Peer(rank, fields[0], fields[1], pid, started, fields[2], fields[3])
        self.place = Place(fields[1], mask, threads, most)


def _exchange_cards(
    comm: MPI.Intracomm, me: Peer, wish: int, text: bytes, settings: RunSettings
) -> list[_Card]:
    import hashlib

    from mpi4py import MPI

    card = _CARD.pack(
        me.rank,
        me.role.encode()[:64],
        me.host.encode()[:64],
        me.pid,
        me.started,
        wish,
        me.space.encode()[:96],
        hashlib.sha256(text).digest()[:16],
        settings.threads or 0,
        most_threads(),
        processors(),
        _machine().encode()[:48],
    )
    cards = bytearray(_CARD.size * comm.size)
    _wait_for(comm.Iallgather([card, MPI.BYTE], [cards, MPI.BYTE]), comm, settings.stall_s, _ALL)
    return [_Card(content) for content in _CARD.iter_unpack(bytes(cards))]


def _machine() -> str:
    import numpy as np

    from .. import _core

    return f"{_core.simd()}, NumPy {np.__version__}"


def _compare(comm: MPI.Intracomm, cards: Sequence[_Card], text: bytes, settings: RunSettings) -> None:
    """Raise ScriptMismatchError if ranks were given different settings; name the ranks and the difference."""
    digests = [card.digest for card in cards]
    model = max(range(len(cards)), key=lambda rank: (digests.count(digests[rank]), -rank))
    different = [rank for rank, digest in enumerate(digests) if digest != digests[model]]
    if not different:
        return
    first = different[0]
    theirs = json.loads(_broadcast(comm, text, model, settings))
    its = json.loads(_broadcast(comm, text, first, settings))
    names = [name for name in theirs if its.get(name) != theirs[name]]
    listed = "; ".join(
        f"World({name}=...) is {its.get(name)!r} on rank {first} and {theirs[name]!r} on rank {model}"
        for name in names
    )
    who = f"ranks {', '.join(map(str, different))}" if len(different) > 1 else ""
    where = place(first, role=cards[first].peer.role, frame=0)
    message = f"{where}: its script differs from the other ranks': {listed}"
    message += f" ({who} differ from rank {model})" if who else ""
    raise ScriptMismatchError(message, frame=0, ranks=tuple(different), speaker=first)


def _claim_log(run: OpenRun, settings: RunSettings) -> None:
    """Let the manager claim the log's directory; if that raises, every rank raises the same error."""
    if settings.log is None:
        return
    assert run.comm is not None
    manager = settings.roles[0]
    verdict = b""
    if run.comm.rank == manager:
        try:
            from .._run.log_directory import LogDirectory

            run.log = LogDirectory.claim(settings.log, continued=settings.continued_from > 0)
        except (ArgumentError, LogError) as error:
            verdict = _as_bytes(error, process.describe(run))
    failure = _broadcast(run.comm, verdict, manager, settings)
    if not failure:
        return
    agreed = _from_bytes(failure)
    agreed.speaker = manager
    raise agreed


def _as_bytes(error: MotesError, where: str) -> bytes:
    if isinstance(error, ArgumentError):
        content = ["ArgumentError", error.argument, os.fspath(error.value), error.allowed]  # type: ignore[call-overload]
    else:
        content = ["LogError", f"{where}: {error}"]
    return json.dumps(content).encode()


def _from_bytes(failure: bytes) -> MotesError:
    kind, *arguments = json.loads(failure)
    return ArgumentError(*arguments) if kind == "ArgumentError" else LogError(*arguments)


def _broadcast(comm: MPI.Intracomm, data: bytes, root: int, settings: RunSettings) -> bytes:
    return collectives.broadcast(comm, data, root, settings.stall_s, _ALL, wait=_wait_for)


def _wait_for(request: MPI.Request, comm: MPI.Comm, stall_s: float | None, what: str) -> None:
    def done() -> bool:
        if process.survives:  # a loss can be survived only during a run: before it, there are no replicas
            attendance.check_lost(comm)
        return request.Test()

    with _left_ends():
        poll(done, Wait(stall_s, what))


@contextlib.contextmanager
def _left_ends() -> Iterator[None]:
    """End the job if a rank that the run needs has left the script or is lost."""
    try:
        yield
    except attendance.Left as left:
        ending.end_left(left.rank, lost=left.lost)
