"""Find the newest complete checkpoint: the manager looks for it, and all ranks check it together."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import _core
from .._io.output import tell
from .._run import same_script
from .._run.collectives import broadcast, first_text
from .._values.checkpoint import Checkpoint
from ..errors import ArgumentError, CheckpointError, MotesError
from . import folder
from .manifest import Manifest

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["Origin", "Wishes", "find"]

_WHAT = "other ranks to read the checkpoint"
_SAMPLES = 4096  # minimum number of positions per system from which new cuts are computed
_SAMPLES_EACH = 256  # minimum number of these positions per domain


@dataclass
class Origin:
    """A run's directory of checkpoints, and the checkpoint that it continues from."""

    directory: Path
    """The absolute path, as seen by the manager."""
    wishes: Wishes
    manifest: Manifest | None = None
    """The manifest of the checkpoint to continue from; None: the run starts from frame 0."""
    place: Path = Path()
    """The folder of that checkpoint."""
    world: bytes = b""
    samples: list[list[list[float]]] | None = None
    lock: folder.Lock | None = None
    """The lock of the directory, on the manager."""

    @property
    def frame(self) -> int:
        """The first frame that is still to do."""
        return 0 if self.manifest is None else self.manifest.frame


@dataclass
class Wishes:
    """The settings of a run that decide how it continues."""

    checkpoint: Checkpoint
    seed: int | None
    dt: float
    substeps: int
    periodic: dict[str, list[float]]
    calculators: int
    fresh: bool
    """Remove existing checkpoints and start from frame 0."""
    anyway: bool
    """Continue even if the script has changed."""
    stall_s: float | None
    most: int | None = None
    """The last frame that an excerpt may continue with, which only reads checkpoints; None: any."""


def find(comm: MPI.Intracomm, manager: int, wishes: Wishes) -> Origin:
    """Return the checkpoint that the run continues from. Collective.

    Damaged checkpoints are reported and skipped. All ranks raise CheckpointError if there are checkpoints but
    none is complete, or if the newest complete one is from another script; ArgumentError if another run uses
    the directory. An excerpt changes nothing, and starts from frame 0 if none is complete.
    """
    origin = Origin(Path(wishes.checkpoint.directory).absolute(), wishes)
    error: MotesError | None = None
    candidates: list[tuple[int, Path]] = []
    if comm.rank == manager:
        try:
            if wishes.most is None:
                origin.lock = folder.Lock(origin.directory)
                folder.sweep(origin.directory)
                if wishes.fresh:
                    folder.start_anew(origin.directory)
            candidates = folder.whole(origin.directory)
            if wishes.most is not None:
                most = -1 if wishes.fresh else wishes.most
                candidates = [(frame, path) for frame, path in candidates if frame <= most]
        except MotesError as failure:
            error = failure
        except OSError as failure:
            error = CheckpointError(f"cannot use {origin.directory} for checkpoints: {failure.strerror}")
    _agree(comm, error, wishes)
    content = json.dumps([str(origin.directory), [[frame, str(path)] for frame, path in candidates]])
    directory, listed = json.loads(broadcast(comm, content.encode(), manager, wishes.stall_s, _WHAT))
    origin.directory = Path(directory)
    for frame, path in listed:
        problem = _problem(comm, manager, origin, frame, Path(path), wishes)
        if not problem:
            _check_run(comm, manager, origin, wishes)
            return origin
        if comm.rank == manager:
            tell(f"motes: the checkpoint of frame {frame} is skipped: {problem}")
    if listed and wishes.most is None:
        raise CheckpointError(
            f"none of the {len(listed)} checkpoint(s) in {origin.directory} is complete; "
            "`python -m motes run --fresh ...` (or MOTES_FRESH=1) starts from the beginning"
        )
    return origin


def _agree(comm: MPI.Intracomm, error: MotesError | None, wishes: Wishes) -> None:
    """Raise on all ranks the error that one of them has."""
    text = ""
    if isinstance(error, ArgumentError):
        text = json.dumps(["ArgumentError", error.argument, str(error.value), error.allowed])
    elif error is not None:
        text = json.dumps(["CheckpointError", str(error)])
    rank, failure = first_text(comm, text, wishes.stall_s, _WHAT)
    if not failure:
        return
    kind, *arguments = json.loads(failure)
    agreed: MotesError = ArgumentError(*arguments) if kind == "ArgumentError" else CheckpointError(*arguments)
    agreed.speaker = rank
    raise agreed


def _problem(
    comm: MPI.Intracomm, manager: int, origin: Origin, frame: int, path: Path, wishes: Wishes
) -> str:
    """Return why a checkpoint cannot be used; if it can, store it in `origin` and return "". Collective."""
    problem, content = "", b""
    if comm.rank == manager:
        try:
            content = _read(path, frame)
        except (CheckpointError, OSError) as error:
            problem = str(error)
    _, problem = first_text(comm, problem, wishes.stall_s, _WHAT)
    if problem:
        return problem
    content = broadcast(comm, content, manager, wishes.stall_s, _WHAT)
    length = int.from_bytes(content[:8], "little")
    manifest = Manifest.from_bytes(content[8 : 8 + length], path / folder.MANIFEST)
    _, problem = first_text(comm, _damage(comm, path, manifest), wishes.stall_s, _WHAT)
    if problem:
        return problem
    origin.manifest, origin.place, origin.world = manifest, path, content[8 + length :]
    samples = b""
    if comm.rank == manager:
        samples = json.dumps(_samples(path, manifest, wishes.calculators)).encode()
    origin.samples = json.loads(broadcast(comm, samples, manager, wishes.stall_s, _WHAT))
    return ""


def _read(path: Path, frame: int) -> bytes:
    """Return the manifest's length, the manifest and the world's bytes; raise an error for damaged ones."""
    text = (path / folder.MANIFEST).read_bytes()
    manifest = Manifest.from_bytes(text, path / folder.MANIFEST)
    if manifest.frame != frame:
        raise CheckpointError(f"{path} contains a checkpoint of frame {manifest.frame}")
    world = (path / folder.WORLD).read_bytes()
    if len(world) != manifest.world["bytes"] or _core.crc32c(world) != manifest.world["crc32c"]:
        raise CheckpointError(f"{path / folder.WORLD} has changed since it was written")
    return len(text).to_bytes(8, "little") + text + world


def _damage(comm: MPI.Intracomm, path: Path, manifest: Manifest) -> str:
    """Verify the checksums of this rank's share of the parts; return what is wrong, or ""."""
    for entry in manifest.parts[comm.rank :: comm.size]:
        try:
            part = _core.PartFile(str(path / entry.file), True)
        except RuntimeError as error:
            return str(error)
        rows = dict(part.rows)
        expected = dict(zip(manifest.systems, entry.rows, strict=True))
        if part.frame != manifest.frame or rows != expected:
            return f"{path / entry.file} belongs to another checkpoint"
    return ""


def _samples(path: Path, manifest: Manifest, calculators: int) -> list[list[list[float]]]:
    """Return sampled positions of each system, as lists of x, y and z."""
    samples: list[list[list[float]]] = [[[], [], []] for _ in manifest.systems]
    wanted = max(_SAMPLES, _SAMPLES_EACH * calculators)
    for entry in manifest.parts:
        part: Any = None
        for system, rows in enumerate(entry.rows):
            total = manifest.particles[system]
            most = -(-wanted * rows // total) if total else 0
            if most == 0:
                continue
            part = part or _core.PartFile(str(path / entry.file), False)
            for axis, values in enumerate(part.sample(system, most)):
                samples[system][axis].extend(values)
    return samples


def _check_run(comm: MPI.Intracomm, manager: int, origin: Origin, wishes: Wishes) -> None:
    """Raise CheckpointError on all ranks if the checkpoint is from another script or other settings."""
    error: MotesError | None = None
    if comm.rank == manager:
        try:
            _compare(origin, wishes)
        except CheckpointError as failure:
            error = failure
    _agree(comm, error, wishes)


def _compare(origin: Origin, wishes: Wishes) -> None:
    manifest = origin.manifest
    assert manifest is not None
    where = f"the checkpoint of frame {manifest.frame} in {origin.directory} was written by a different run: "
    changed = same_script.changed_setting(
        (
            ("seed", manifest.seed, manifest.seed if wishes.seed is None else wishes.seed),
            ("dt", manifest.dt_s, wishes.dt),
            ("substeps", manifest.substeps, wishes.substeps),
            ("periodic", manifest.periodic, wishes.periodic),
        )
    )
    if changed:  # cannot be overruled by MOTES_ANYWAY: the particles would differ
        raise CheckpointError(
            f"{where}{changed}; "
            "`python -m motes run --fresh ...` (or MOTES_FRESH=1) starts from the beginning"
        )
    difference = same_script.difference(manifest.script, same_script.facts())
    if difference and not wishes.anyway:
        raise CheckpointError(
            f"{where}{difference}; `python -m motes run --anyway ...` (or MOTES_ANYWAY=1) continues "
            "anyway, --fresh (or MOTES_FRESH=1) starts from the beginning"
        )
