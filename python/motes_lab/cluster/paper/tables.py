"""Tables 1 to 3 of the paper, one row per cell, and the speed-ups given only in its text."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

__all__ = ["IN_TEXT", "Cell", "cells"]

IN_TEXT = 0
"""The "table" of the speed-ups in the text."""


@dataclass(frozen=True)
class Cell:
    """One measurement of the paper."""

    table: int
    experiment: str
    """"snow" or "fountain"."""
    network: str
    compiler: str
    hosts: str
    """Number and kind of nodes, in brackets the processes on all of them: "8*B", "4*B(8)+2*C(2)"."""
    processes: int
    variant: str
    """Infinite or finite space, static or dynamic balancing: "IS-SLB", "FS-DLB", ..."""
    speedup: float

    @property
    def nodes(self) -> str:
        """The nodes as the paper writes them: "8*B /16 P."."""
        if "(" not in self.hosts:
            return f"{self.hosts} /{self.processes} P."
        terms = re.sub(r"\((\d+)\)", r" (\1 P.)", self.hosts).replace("+", " + ")
        return f"{terms} = {self.processes} P."

    @property
    def finite(self) -> bool:
        """Whether the domains initially divide the scene's own width."""
        return self.variant.startswith("FS")

    @property
    def dynamic(self) -> bool:
        """Whether domains change."""
        return self.variant.endswith("DLB")


def cells(table: int) -> list[Cell]:
    """Read one table, or the figures `IN_TEXT`."""
    name = "text.csv" if table == IN_TEXT else "tables.csv"
    with open(Path(__file__).with_name(name), newline="") as file:
        rows = [row for row in csv.DictReader(file) if int(row.get("table", IN_TEXT)) == table]
    return [
        Cell(
            table=table,
            experiment=row["experiment"],
            network=row["network"],
            compiler=row["compiler"],
            hosts=row["hosts"],
            processes=int(row["processes"]),
            variant=row["configuration"],
            speedup=float(row["speedup"]),
        )
        for row in rows
    ]
