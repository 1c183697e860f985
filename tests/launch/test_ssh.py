"""A lab's PCs: three simulated hosts with a real ssh, and nothing else told to motes or mpirun."""

from __future__ import annotations

import json
import os
import shlex
import sys
from pathlib import Path

import pytest
from hosts import Hosts
from launching import Result, command, python
from ssh import missing, with_ssh

EVERYTHING = Path(__file__).parents[1] / "scenes" / "everything.py"
VARIANTS = json.dumps([{"roles": "auto", "space": None}, {"roles": "shared", "space": [-3, 3]}])
LACK = missing()
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        bool(LACK) and os.environ.get("MOTES_TEST_SSH") != "required", reason=LACK or "nothing lacks"
    ),
]


@pytest.fixture(scope="module")
def hosts(tmp_path_factory):
    with with_ssh(tmp_path_factory.mktemp("hosts")) as up:
        yield up


def motes(hosts: Hosts, *argv: object, timeout: float = 120) -> Result:
    """Run a command of motes on the first host."""
    line = shlex.join(map(str, (sys.executable, "-m", "motes", *argv)))
    return command([hosts.agent, hosts.names[0], line], timeout=timeout)


def test_a_job_over_ssh_has_the_same_digests(hosts: Hosts, tmp_path: Path) -> None:
    """With a host file, and with names."""
    a, b, c = hosts.names
    wanted = sorted(python(EVERYTHING, VARIANTS).lines)
    file = tmp_path / "hosts"
    file.write_text(f"{a} slots=2\n{b} slots=2  # the window seat\n{c} slots=1\n")
    assert sorted(motes(hosts, "run", "-n", 5, "--hostfile", file, EVERYTHING, VARIANTS).lines) == wanted
    assert (
        sorted(motes(hosts, "run", "-n", 3, "--hosts", f"{b},{c},{a}", EVERYTHING, VARIANTS).lines) == wanted
    )


def test_doctor_measures_hosts_over_ssh(hosts: Hosts) -> None:
    """A host that is lost is a sentence."""
    a, b, c = hosts.names
    told = json.loads(motes(hosts, "doctor", "--json", "--hosts", f"{a},{b},{c}").out)
    assert [row["host"] for row in told["hosts"]] == [a, b, c] and told["problems"] == []
    assert told["powers"]["auto"] == [1.0] and min(told["powers"]["shared"]) == 1
    hosts.cut_off(c)
    ended = motes(hosts, "doctor", "--hosts", f"{a},{c}")
    assert ended.code == 1 and f"problem: {c} does not answer: ssh: " in ended.out, ended.text
