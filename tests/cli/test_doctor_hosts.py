"""`motes doctor --hosts`: hosts that differ, simulated by an agent that starts everything on this machine."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from launching import Result, command
from same_bits import widths

from motes.cli.hosts import examine, powers_of
from motes.errors import ArgumentError

AGENT = """#!/bin/sh
host=$1
shift
case $host in
  narrow) export MOTES_SIMD={narrow} MOTES_THREADS=1 ;;
  wide) export MOTES_SIMD={wide} MOTES_THREADS=1 ;;
  silent) echo "ssh: connect to host silent port 22: Connection refused" >&2; exit 255 ;;
  bare) unset PYTHONPATH; set -- "$(printf %s "$*" | sed "1s|^[^ ]*|{bare}|")" ;;
  other) set -- "$(printf %s "$*" | sed "1s|^[^ ]*|{other}|")" ;;
  empty) set -- "$(printf %s "$*" | sed "1s|^[^ ]*|/nowhere/python|")" ;;
  broken) export MOTES_SIMD=mmx ;;
esac
exec /bin/sh -c "$*"
"""


def another_python() -> tuple[str, str] | None:
    """Return a Python of another version than this one, and its version, if there is one."""
    found = [Path("/usr/bin/python3"), *sorted(Path.home().glob(".pyenv/versions/*/bin/python"))]
    for python in found:
        ask = [str(python), "-c", "import sys; print('%d.%d' % sys.version_info[:2])"]
        if python.exists():
            told = subprocess.run(ask, capture_output=True, text=True, timeout=30)
            if told.returncode == 0 and told.stdout.split() != [
                f"{sys.version_info[0]}.{sys.version_info[1]}"
            ]:
                return str(python), told.stdout.strip()
    return None


@pytest.fixture(scope="module")
def doctor(tmp_path_factory: pytest.TempPathFactory):
    """Return a function that runs `motes doctor --hosts`."""
    folder = tmp_path_factory.mktemp("agent")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder / "bare")], check=True)
    text = AGENT.format(
        narrow=widths()[0],
        wide=widths()[-1],
        bare=folder / "bare" / "bin" / "python",
        other=(another_python() or ["false"])[0],
    )
    agent = folder / "agent"
    agent.write_text(text)
    agent.chmod(0o755)

    def run(hosts: str, *options: str) -> Result:
        env = {"PRTE_MCA_plm_ssh_agent": str(agent)}
        return command([sys.executable, "-m", "motes", "doctor", "--hosts", hosts, *options], env=env)

    return run


def test_speeds_and_powers_of_hosts_that_differ(doctor) -> None:
    """Each host says what it is; powers are in the order of the ranks that calculate, 1 for the slowest."""
    ended = doctor("narrow:2,wide", "--json")
    assert ended.code == 0, ended.text
    told = json.loads(ended.out)
    narrow, wide = told["hosts"]
    assert (narrow["host"], narrow["ranks"], wide["host"], wide["ranks"]) == ("narrow", 2, "wide", 1)
    assert (narrow["simd"], wide["simd"]) == (widths()[0], widths()[-1])
    assert narrow["threads"] == wide["threads"] == 1
    assert narrow["processor"] == wide["processor"]
    speeds = [narrow["particles_per_s"]] * 2 + [wide["particles_per_s"]]
    assert min(speeds) > 1e4
    assert told["powers"] == {"auto": [1.0], "shared": powers_of(speeds, [0, 1, 2])}
    assert told["problems"] == []


def test_the_report_is_a_table_and_what_to_write(doctor) -> None:
    """The last lines are what a script writes."""
    lines = doctor("wide:2").lines
    assert lines[0].split()[:3] == ["host", "ranks", "threads"]
    assert lines[1].split()[:4] == ["wide", "2", "1", widths()[-1]]
    assert "World(balancer=motes.balance.Pairwise(powers=[1.0]))" in lines
    assert 'World(balancer=motes.balance.Pairwise(powers=[1.0, 1.0]), roles="shared")' in lines
    assert lines[-1] == "no problems found"


def test_powers_are_relative_to_the_slowest_that_calculates() -> None:
    """A slow rank that only draws does not count."""
    assert powers_of([1.0, 4.0, 8.0, 6.0], [2, 3]) == [1.33, 1.0]
    assert powers_of([2.5e6, 1e6], [0, 1]) == [2.5, 1.0]


@pytest.mark.slow  # measures twice on one processor
def test_the_ranks_of_a_host_are_measured_at_the_same_time() -> None:
    """Six ranks that share a processor are slow; one after the other they would be as fast as one."""
    if shutil.which("taskset") is None:
        pytest.skip("needs taskset")
    here = ["taskset", "-c", str(min(os.sched_getaffinity(0))), sys.executable, "-m", "motes.cli.speed"]
    one, six = (json.loads(command([*here, ranks]).lines[-1]) for ranks in (1, 6))
    assert one["threads"] == six["threads"] == 1
    assert six["particles_per_s"] < 0.8 * one["particles_per_s"]


def test_hosts_that_cannot_take_part_are_a_sentence_each(doctor) -> None:
    """And there are no powers, which would be of other hosts."""
    python, version = sys.executable, ".".join(map(str, sys.version_info[:3]))
    sentences = {
        "silent": "silent does not answer: ssh: connect to host silent port 22: Connection refused",
        "bare": f"bare has no motes for {python}: No module named 'motes'",
        "empty": f"empty has no {python}, or no shell: every host needs the same environment "
        "at the same path",
        "broken": "broken cannot be measured: MOTES_SIMD must be sse2, avx2, avx512 or neon, got 'mmx'",
    }
    if found := another_python():
        sentences["other"] = f"other runs Python {found[1]}, this host {version}: one job needs the same"
    ended = doctor(",".join(["wide", *sentences]))
    problems = [line for line in ended.out.splitlines() if line.startswith("problem: ")]
    assert problems == [f"problem: {sentence}" for sentence in sentences.values()], ended.text
    assert ended.code == 1 and "powers" not in ended.out and "wide " in ended.out
    assert "Traceback" not in ended.text


def test_without_ssh_is_a_sentence(tmp_path: Path) -> None:
    """A machine need not have a remote shell."""
    env = {"PATH": str(tmp_path), "PRTE_MCA_plm_ssh_agent": "no-such-shell"}
    (tmp_path / "sh").symlink_to(shutil.which("sh") or "/bin/sh")
    ended = command([sys.executable, "-m", "motes", "doctor", "--hosts", "far"], env=env)
    assert ended.code == 1 and "problem: far cannot be asked: " in ended.out, ended.text


@pytest.mark.parametrize(
    "text", ["", "a,", "a:0", "a:x", "a:-1", "a:1:2", "-oProxyCommand=x", "a,-x", "a b", "a:", "a:9999999999"]
)
def test_what_is_no_list_of_hosts_is_refused(text: str) -> None:
    """Before anything is started."""
    with pytest.raises(ArgumentError, match="hosts must be"):
        examine(text)
