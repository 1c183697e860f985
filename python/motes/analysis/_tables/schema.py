"""Columns of the log's tables: names in order, types, units, meanings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = [
    "ACTIVITIES",
    "EARLIER_PHASES",
    "EVENTS",
    "FRAMES",
    "LOAD",
    "QUANTILES",
    "TABLES",
    "TIMES",
    "WAYS",
    "Column",
    "Table",
]

ACTIVITIES = (
    *("script", "births", "act", "talk", "picture", "log", "checkpoint", "recovery", "other", "wait"),
)
"""Activities that divide a rank's time completely: columns of times.jsonl without the suffix _s."""

EARLIER_PHASES = {"word": "all_reduce", "copies": "replicas", "send leavers": "send migrants"}
"""Names of phases in logs of earlier versions, and their present names."""

QUANTILES = tuple(f"x_q{i:02d}" for i in range(17))
"""Columns of density.jsonl: 17 coordinates that divide a calculator's particles into 16 equal parts."""

WAYS = tuple(f"way_q{i}" for i in range(8))
"""Columns of density.jsonl: how far particles moved in the frame, as quantiles of a sample."""


@dataclass(frozen=True)
class Column:
    """One column: `kind` is int, float or str; all but keys may be null or missing."""

    name: str
    kind: type
    unit: str
    meaning: str
    key: bool = False
    """Whether each row must have a value; integers must then be >= 0."""
    earlier: str = ""
    """The column's name in logs of earlier versions, renamed when read; empty: the same."""
    earlier_values: Mapping[str, str] = field(default_factory=dict)
    """Text values in logs of earlier versions, and their present names."""


@dataclass(frozen=True)
class Table:
    """One file of the log."""

    file: str
    row: str
    columns: tuple[Column, ...]
    required: bool = False
    """Whether every log has the file; other files exist only if there was something to write."""
    unique: tuple[str, ...] = ()
    """Columns that together identify a row; empty if rows may be equal."""


def _columns(text: str) -> tuple[Column, ...]:
    """Parse lines "name kind unit meaning"; a unit of - means none, a kind ending in ! marks a key.

    A name may be followed by / and its earlier name. The kind "phase" is a string, the name of a phase.
    """
    kinds = {"int": int, "float": float, "str": str, "phase": str}
    columns = []
    for line in filter(str.strip, text.splitlines()):
        name, kind, unit, meaning = line.split(maxsplit=3)
        key, kind = kind.endswith("!"), kind.rstrip("!")
        name, _, earlier = name.partition("/")
        values = EARLIER_PHASES if kind == "phase" else {}
        columns.append(Column(name, kinds[kind], "" if unit == "-" else unit, meaning, key, earlier, values))
    return tuple(columns)


_FRAME = "frame int! - number of the frame, from 0\n"
_SYSTEM = "system str! - name of the particle system\n"

FRAMES = Table(
    "frames.jsonl",
    "frame",
    required=True,
    unique=("frame",),
    columns=_columns(
        _FRAME
        + """
        time float s time in the animation at the frame's end
        particles int - particles of all systems after the exchange
        exchanged int - migrants, including those in interactions: the sum of sent
        exchanged_bytes int B migrants and ghosts in messages: the sum of bytes_sent
        dropped int - births and children above the capacity, since the start
        imbalance float - compute seconds of the slowest calculator over their mean; 1 is perfect
        slowest_rank int - that calculator's rank
        t_frame_s float s from the last frame's latest end on any rank to this one's: adds up to the run
        t_create_s float s births; for this and the following phases: the slowest rank
        t_act_s float s the recorded list of actions
        t_report_s float s report and verdict, including the wait for the slowest
        t_exchange_s float s sending migrants to their owners
        t_balance_s float s orders, donations, new cuts
        t_render_s float s the picture: the next three times, and waiting for other ranks' parts
        births_by str - manager or calculators: who created the births; null if there were none
        t_project_s float s making records of particles, sending them; with pictures only, like the next two
        t_draw_s float s drawing records
        t_assemble_s float s image generator: putting other ranks' tiles into the picture
        render_path str - gather, tiles or composite: who drew
        records int - visible particles, counted once per tile they touch
        record_bytes int B size of all records, of which many may stay on their rank
        render_bytes int B messages for the picture
        """
    ),
)

LOAD = Table(
    "load.jsonl",
    "frame, system and calculator",
    required=True,
    unique=("frame", "system", "rank"),
    columns=_columns(
        _FRAME
        + _SYSTEM
        + """
        rank int! - MPI rank of the calculator
        host str - its host
        n_start int - particles at the frame's start
        n_end int - particles after the exchange: n_start + created - killed - sent + received
        created int - born in this domain
        killed int - removed
        sent int - migrated to another calculator
        received int - migrated from another calculator
        bytes_sent int B migrants and ghosts sent
        t_compute_s float s from the first action to the last, by the run's clock
        t_rescaled_s float s the same, scaled to the particles after the exchange (paper 3.2.4)
        t_exchange_s float s exchange, including waits; per rank, the same in each system's row
        t_wait_s float s waiting for messages in all phases; per rank
        t_image_s float s its part of the picture; per rank
        t_project_s float s part of it: making records of its particles, sending them; per rank
        domain_lo float m lower end of the domain along the first cut axis; null: extends to infinity
        domain_hi float m upper end; by id, both are fractions 0..1 of the ids, along a curve, of its length
        domain_y_lo float m lower end along y, for bricks also cut along y
        domain_y_hi float m upper end
        domain_z_lo float m lower end along z, for bricks also cut along z
        domain_z_hi float m upper end
        speed float particles/s particles processed per second of compute
        pack_each_s float s packing a migrant, mean so far; without any, as tried with a few particles
        unpack_each_s float s unpacking a migrant, likewise
        search_each_s float s per particle: looking for a cut, or making a histogram, likewise
        migrant_bytes float B a migrant in a message
        interactions/meetings int - pair interactions in this frame; null for none, like all that follow
        pairs int - pairs within reach in all interactions, counted at both ends
        ghosts/copies int - ghosts sent to other calculators
        interaction_bytes/copied_bytes int B ghosts, and migrants in interactions, sent
        most_in_a_cell int - largest number of particles in a cell as wide as the reach
        overlap_99 float - 99th percentile of overlaps in the last sub-step, over the sum of the radii
        neighbour_ranks/hops int - largest number of calculators to which an interaction sent messages
        t_interact_s/t_meet_s float s interactions, including waits
        t_interact_wait_s/t_meet_wait_s float s waiting for other calculators in interactions
        """
    ),
)

BALANCE = Table(
    "balance.jsonl",
    "cut evaluated",
    unique=("frame", "system", "left_rank"),
    columns=_columns(
        _FRAME
        + _SYSTEM
        + """
        left_rank int! - calculator on the left of the cut
        right_rank int! - calculator on its right
        n_left int - particles on the left
        n_right int - particles on the right
        t_left_s float s rescaled compute time on the left
        t_right_s float s on the right
        speed_left float particles/s smoothed speed on the left
        speed_right float particles/s on the right
        ordered int - particles ordered to move: + left to right, - right to left; null: cut by shares
        given int - particles given, same sign; fewer than ordered where several share a coordinate
        axis str - axis of the cut; hilbert, morton: of that curve; id: a cut between ids
        cut_before float m the cut
        cut_after float m the cut from the next frame on
        policy str - who decided; Diffusive with manager=False: neighbours, before the exchange
        """
    ),
)

DENSITY = Table(
    "density.jsonl",
    "frame, system and calculator",
    unique=("frame", "system", "rank"),
    columns=_columns(_FRAME + _SYSTEM + "rank int! - calculator\nn int - particles")
    + tuple(
        Column(name, float, "m", f"{i}/16 of the particles are left of it; null: no particles")
        for i, name in enumerate(QUANTILES)
    )
    + tuple(
        Column(f"{axis}{name[1:]}", float, "m", f"the same along {axis}, for bricks also cut along {axis}")
        for axis in "yz"
        for name in QUANTILES
    )
    + tuple(
        Column(name, float, "m", f"{2 * i + 1}/16 of a sample moved less far along the first cut axis")
        for i, name in enumerate(WAYS)
    ),
)

TIMES = Table(
    "times.jsonl",
    "frame and rank",
    unique=("frame", "rank"),
    columns=_columns(
        _FRAME
        + """
        rank int! - MPI rank
        wall_s float s from the end of the previous frame to the end of this one: the sum of the next ten
        script_s float s the script: its own Python, and what it does with the picture
        births_s float s creating particles and distributing them
        act_s float s the recorded list; on a rank with one thread: processor time
        talk_s float s reports, verdicts, exchange, balancing: packing, reading, deciding; no waiting
        picture_s float s projecting, drawing, assembling
        log_s float s writing the log
        checkpoint_s float s writing checkpoints, and restoring one
        recovery_s float s after a loss of ranks: restoring replicas, and the frames that the loss destroyed
        other_s float s the rest: taken by the operating system from births, act and picture; between phases
        wait_s float s waiting for other ranks, in all phases
        messages_s float s part of these: calls that send and receive without waiting
        script_idle_s float s part of script_s without the processor: asleep, waiting for files, or preempted
        chain_s float s longest chain of work so far, over all ranks: the run's time if messages took no time
        """
    ),
)

WAITS = Table(
    "waits.jsonl",
    "frame, rank, rank waited for and phase",
    unique=("frame", "rank", "waited_for", "sender", "phase"),
    columns=_columns(
        _FRAME
        + """
        rank int! - the rank that waited
        waited_for int - the rank that was late; -1: several
        sender int - in the file: the rank whose message was awaited, which may itself wait for the late one
        phase phase! - of the awaited message: begin, report, ...; leave: until its own messages had left
        seconds float s how long
        """
    ),
)

WALLS = Table(
    "walls.jsonl",
    "frame and wall",
    unique=("frame", "wall"),
    columns=_columns(
        _FRAME
        + """
        wall int! - number of the wall in this frame, in the order of the systems and their contacts
        shape str - its shape
        force_x_n float N force of all particles on the wall, mean over the frame's sub-steps
        force_y_n float N the same along y
        force_z_n float N the same along z
        torque_x_nm float N*m its torque about the wall's origin (World.force)
        torque_y_nm float N*m the same about y
        torque_z_nm float N*m the same about z
        """
    ),
)

LINKS = Table(
    "links.jsonl",
    "pair of ranks, measured when the run starts",
    unique=("frame", "rank", "other"),
    columns=_columns(
        _FRAME
        + """
        rank int! - MPI rank that sent messages, the manager or a calculator
        other int! - MPI rank that sent them back
        message_s float s from sending a short message to having received it
        byte_s float s in addition, per byte of a longer message
        """
    ),
)

EVENTS = Table(
    "events.jsonl",
    "event",
    required=True,
    columns=_columns(
        _FRAME
        + "kind str! - start, continued, recovered, end, crowded, overlap, softened, unseen, slow_balancer\n"
        + "text str - what happened"
    ),
)

SPANS = Table(
    "spans.r*.jsonl",
    "phase of a frame on a rank",
    columns=_columns(
        _FRAME
        + "rank int! - the file's rank\nphase phase! - act, exchange, ...\n"
        + _SYSTEM.replace("!", "")
        + "start_s float! s since the run's start, on a clock common to all ranks\nend_s float! s its end\n"
        + "cpu_s float s processor time of the rank's thread; null: overlaps other phases\n"
        + "waited_for int - in rows of phase wait (inside another phase): the rank waited for; -1: several\n"
        + "message phase - phase of the awaited message"
    ),
)

TABLES = {
    "frames": FRAMES,
    "load": LOAD,
    "balance": BALANCE,
    "density": DENSITY,
    "events": EVENTS,
    "spans": SPANS,
    "times": TIMES,
    "waits": WAITS,
    "walls": WALLS,
    "links": LINKS,
}
