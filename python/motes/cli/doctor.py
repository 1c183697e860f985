"""Examine this installation: what it consists of, and whether its parts fit together.

  python -m motes doctor
  python -m motes doctor --hosts h1:2,h2:4

If something is wrong, such as a compiled core that does not load, prints one line per problem; exit code 1.

--hosts measures how fast the ranks of each host are, all at the same time, and prints the `powers=` of
`Pairwise` that follow: what the paper does by its table of machines. Each host is asked by the remote shell
that mpirun uses, and must have this Python and motes.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
import json
import os
import platform
import re
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .._io.text import printable
from .._launch import starting
from .._launch.files import folder_of_a_job
from .._mpi.loading import import_mpi, other_libraries, path_of, same_library
from .._values import environment
from ..errors import EXTRAS, ArgumentError, MotesError
from . import hosts
from .parser import add_json, print_figures

__all__ = ["Report", "configure", "examine", "run"]

HELLO_LIMIT_S = 30
# Write each line in one piece; unbuffered, print() would not, and lines of different ranks could mix.
_HELLO = r"""
import sys
from mpi4py import MPI
sys.stdout.write(f'motes-hello rank {MPI.COMM_WORLD.rank} of {MPI.COMM_WORLD.size}\n')
"""

# Run in a separate process: starting MPI or loading a broken core must not end the examination.
_CORE = """
import json, mpi4py
mpi4py.rc.initialize = mpi4py.rc.finalize = False
from motes import _core
from motes._mpi.loading import import_mpi, use_mpi
found = {'abi': use_mpi(import_mpi()), 'simd': _core.simd()}
def roles(size):
    return [_core.describe_role(_core.cast('auto', size), rank) for rank in range(size)]
found['roles'] = {f'n={size}': roles(size) for size in (1, 2, 4)}
print('motes-core ' + json.dumps(found))
"""


@dataclass
class Report:
    """Figures by name, and one sentence per problem."""

    figures: dict[str, Any] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The report as text."""
        verdict = [f"problem: {problem}" for problem in self.problems] or ["no problems found"]
        if "hosts" in self.figures:
            return "\n".join([*hosts.shown(self.figures), "", *verdict])
        width = max(map(len, self.figures))
        lines = [
            f"{name:<{width}}  {_shown(value)}"
            for name, value in self.figures.items()
            if name != "environment"
        ]
        lines += ["", *_variables(self.figures.get("environment", {}))]
        return "\n".join([*lines, "", *verdict])


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `doctor`."""
    parser.add_argument("--hosts", help="measure these hosts, each with the ranks it takes: h1,h2:2")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Print the report; return 1 if there is a problem, else 0."""
    report = examine() if args.hosts is None else _examine_hosts(args.hosts)
    print_figures(args, {**report.figures, "problems": report.problems}, report.text)
    return 1 if report.problems else 0


def _examine_hosts(text: str) -> Report:
    return Report(*hosts.examine(text))


def examine() -> Report:
    """Examine this installation."""
    report = Report()
    report.figures["python"] = f"{platform.python_version()} ({sys.executable})"
    for name in ("motes", "numpy", "mpi4py"):
        _package(report, name, needed=True)
    _package(report, "av", needed=False)
    _environment(report)
    report.figures["threads"] = _threads()
    if importlib.util.find_spec("mpi4py") is not None:
        _mpi(report)
        _core(report)
    return report


def _environment(report: Report) -> None:
    """Add the environment variables that are set, and a problem for each invalid value."""
    values = {}
    for name in environment.TABLE:
        if environment.is_set(name):
            values[name] = os.environ[name]
            try:
                environment.read(name)
            except ArgumentError as error:
                report.problems.append(str(error))
    report.figures["environment"] = values


def _threads() -> str:
    """Return how many threads a script has that runs as one process."""
    from .._run.threads import Place, most_threads, processors, threads_of

    alone = threads_of([Place("", processors(), 0, most_threads())])[0]
    return f"{alone} without mpirun"


def _package(report: Report, name: str, *, needed: bool) -> None:
    try:
        report.figures[name] = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        report.figures[name] = None
        if needed:
            report.problems.append(f"the package {name} is not installed")
        elif name == "av":
            wanted = " ".join(f'"{package}"' for package in EXTRAS["video"])
            report.figures[name] = f"not installed: no movies ({sys.executable} -m pip install {wanted})"


def _mpi(report: Report) -> None:
    """Find the launcher and start two ranks."""
    try:
        report.figures["mpi_library"] = str(starting.library())
    except MotesError as error:
        report.problems.append(str(error))
        return
    module = import_mpi()
    report.figures["libmpi"] = path_of(module)
    try:
        mpirun = starting.find_mpirun()
    except MotesError as error:
        report.problems.append(str(error))
        return
    report.figures["mpirun"] = str(mpirun)
    others = [*other_libraries(module), *map(str, starting.other_launchers(mpirun))]
    if others:
        report.figures["other MPIs"] = others
    fits = mpirun.version.fits(starting.library())
    report.figures["mpirun fits library"] = "yes" if fits else "no"
    if not fits:
        report.problems.append(f"{mpirun.path} is {mpirun.version}, but mpi4py uses {starting.library()}")
    try:
        reason = starting.cannot_survive(mpirun.version)
    except ImportError:  # the core, which is reported elsewhere
        reason = "the core does not load"
    report.figures["survives losses"] = "yes: motes run --survive" if reason is None else f"no: {reason}"
    argv = starting.command(2, [sys.executable, "-c", _HELLO], mpirun=mpirun)
    with folder_of_a_job() as (_, own):
        output, problem = _output(argv, {**own, **same_library(module)})
    hello = sorted(re.findall(r"motes-hello (rank \d+ of \d+)", output))
    report.figures["hello"] = hello
    if hello == ["rank 0 of 1"] * 2:
        report.problems.append(
            f"{mpirun.path} starts ranks that do not see each other: it belongs to another MPI"
        )
    elif hello != ["rank 0 of 2", "rank 1 of 2"]:
        report.problems.append(f"two ranks could not be started by `{' '.join(argv[:-1])} ...`: {problem}")


def _core(report: Report) -> None:
    """Load the compiled core and let it look at mpi4py's library."""
    module = sys.modules.get("mpi4py.MPI")  # not there if no library can be loaded
    output, problem = _output([sys.executable, "-c", _CORE], same_library(module) if module else None)
    match = re.search(r"motes-core (.*)", output)
    if match is None:
        report.figures["simd"] = None
        report.problems.append(f"the compiled core does not load: {problem}")
        return
    facts = json.loads(match[1])
    report.figures["simd"] = facts["simd"]
    report.figures["mpi_abi"] = facts["abi"]
    report.figures["roles"] = facts["roles"]


def _output(argv: list[str], variables: Mapping[str, str] | None = None) -> tuple[str, str]:
    """Run a program; return its output and, if it failed, the reason.

    `variables` are added to its environment, unless set in this one.
    """
    try:
        answer = subprocess.run(
            argv,
            capture_output=True,
            text=True,
            timeout=HELLO_LIMIT_S,
            stdin=subprocess.DEVNULL,
            env={**(variables or {}), **os.environ},  # os.environ lacks what MPI added when it started
        )
    except subprocess.TimeoutExpired:
        return "", f"it did not end within {HELLO_LIMIT_S} s"
    except OSError as error:
        return "", str(error)
    return answer.stdout, starting.reason(answer)


def _variables(values: dict[str, str]) -> list[str]:
    """List all environment variables of motes, with their values or defaults."""
    width = max(map(len, environment.TABLE))
    lines = []
    for name, variable in environment.TABLE.items():
        default = variable.default_text or str(variable.default)
        value = f"= {printable(values[name])}" if name in values else f"default: {default}"
        lines.append(f"{name:<{width}}  {variable.meaning}; {value}")
    return lines


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "; ".join(f"{name}: {_shown(part)}" for name, part in value.items())
    if isinstance(value, list):
        return " | ".join(map(str, value))
    return "-" if value is None else str(value)
