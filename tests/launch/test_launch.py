"""Finding the right mpirun and its flags; `run` and `doctor`, with real and fake launchers."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from mpiruns import FIVE, FOUR, HYDRA

from motes._launch import starting
from motes._launch.hosts import reachable
from motes._launch.starting import Mpirun, Version
from motes.cli import doctor, main
from motes.cli import run as run_command
from motes.cli.parser import Parser
from motes.errors import ArgumentError, MotesError


def motes(*argv: str, limit: float = 40, **changes: str) -> subprocess.CompletedProcess[str]:
    """Run `python -m motes` as a user does."""
    job = [sys.executable, "-m", "motes", *argv]
    return subprocess.run(
        job, capture_output=True, errors="replace", timeout=limit, env={**os.environ, **changes}
    )


def toy_launcher(folder: Path, *, says: str) -> str:
    """Make a fake mpirun of another MPI: it starts the ranks, but they do not see each other."""
    path = folder / "mpirun"
    path.write_text(
        f'#!/bin/sh\nif [ "$1" = --version ]; then echo "{says}"; exit; fi\n'
        'n=$2; shift 2\nwhile [ "$1" != "$TOY_PYTHON" ]; do shift; done\n'
        'export PMI_SIZE=$n PMI_RANK=0\nwhile [ $n -gt 0 ]; do "$@"; PMI_RANK=1; n=$((n-1)); done\n'
    )
    path.chmod(0o755)
    return str(path)


# --- which MPI


@pytest.mark.parametrize(
    ("text", "version"),
    [
        ("Open MPI v5.0.11, package: Open MPI root@x, ident: 5.0.11", ("Open MPI", "5.0.11")),
        ("mpirun (Open MPI) 4.1.4\n\nReport bugs to http://www.open-mpi.org/", ("Open MPI", "4.1.4")),
        ("mpiexec (OpenRTE) 4.1.4\n\nReport bugs to", ("Open MPI", "4.1.4")),
        ("MPICH Version:      4.0.2\nMPICH Release date: Thu Apr  7", ("MPICH", "4.0.2")),
        ("HYDRA build details:\n    Version:                                 4.0.2\n", ("MPICH", "4.0.2")),
        ("Intel(R) MPI Library 2021.5 for Linux* OS", ("Intel MPI", "2021.5")),
        ("Intel(R) MPI Library for Linux* OS, Version 2021.5 Build 20211102", ("Intel MPI", "2021.5")),
        ("something else", ("unknown", "")),
    ],
)
def test_versions_are_read_from_libraries_and_launchers(text, version):
    assert starting._version(text) == version


def test_a_launcher_fits_its_own_library_only():
    library = Version("Open MPI", "5.0.3")
    assert FIVE.version.fits(library)
    assert not FOUR.version.fits(library)
    assert not HYDRA.version.fits(library)


def test_versions_are_compared_as_numbers():
    ten = Mpirun("/opt/ten/mpirun", Version("Open MPI", "10.0.1"))
    argv = starting.command(4, [], mpirun=ten, hosts="a,b:2")
    assert argv[-2:] == ["--map-by", "node:OVERSUBSCRIBE"], "10 comes after 5"
    assert Version("Open MPI", "5.0rc1").fits(Version("Open MPI", "5.00.2"))


def test_the_launcher_found_is_of_the_library_in_use(monkeypatch):
    monkeypatch.delenv("MOTES_MPIRUN", raising=False)
    assert starting.find_mpirun().version.fits(starting.library())


def test_a_launcher_can_be_named(monkeypatch, tmp_path):
    monkeypatch.setenv("MOTES_MPIRUN", toy_launcher(tmp_path, says="HYDRA build details: Version: 4.0.2"))
    assert starting.find_mpirun() == (str(tmp_path / "mpirun"), ("MPICH", "4.0.2"), "")
    monkeypatch.setenv("MOTES_MPIRUN", "no/such/mpirun")
    with pytest.raises(MotesError, match="MOTES_MPIRUN=no/such/mpirun"):
        starting.find_mpirun()


def test_launchers_of_another_mpi_are_named(monkeypatch, tmp_path):
    monkeypatch.delenv("MOTES_MPIRUN", raising=False)
    path = toy_launcher(tmp_path, says="mpirun (Open MPI) 2.0.1")
    monkeypatch.setattr(starting, "_launchers", lambda: [path])
    with pytest.raises(MotesError, match=r"no mpirun of that MPI was found; found: .*\(Open MPI 2.0.1\)"):
        starting.find_mpirun()


# --- which flags


@pytest.fixture
def two_cores(monkeypatch):
    """Fix the settings that depend on the machine and the user."""
    for name in ("SLURM_JOB_ID", "SLURM_NTASKS", "PBS_NODEFILE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr(os, "geteuid", lambda: 1000, raising=False)


YIELD = "--mca mpi_yield_when_idle 1"
UNBOUND = "--bind-to none"


@pytest.mark.parametrize(
    ("mpirun", "ranks", "place", "flags"),
    [
        (FIVE, 2, {}, "--oversubscribe"),
        (FIVE, 3, {}, f"--oversubscribe {YIELD}"),
        (FIVE, 3, {"hosts": "a,b:2"}, f"--host a:1,b:2 {UNBOUND}"),
        (FIVE, 4, {"hosts": "a,b:2"}, f"--host a:1,b:2 {UNBOUND} {YIELD} --map-by node:OVERSUBSCRIBE"),
        (FOUR, 4, {"hosts": "a,b:2"}, f"--host a:1,b:2 {UNBOUND} {YIELD} --map-by node --oversubscribe"),
        (HYDRA, 4, {"hosts": "a,b:2"}, "-hosts a,b:2"),
        (HYDRA, 4, {}, ""),
    ],
)
def test_flags(two_cores, mpirun, ranks, place, flags):
    argv = starting.command(ranks, ["python", "x.py"], mpirun=mpirun, options=["--quiet"], **place)
    assert argv == [mpirun.path, "-n", str(ranks), *flags.split(), "--quiet", "python", "x.py"]


@pytest.mark.parametrize(
    ("options", "variables"),
    [
        ("--bind-to core", {}),
        ("-bind-to core", {}),
        ("--map-by ppr:2:node:PE=2", {}),
        ("--cpu-set 0,1", {}),
        ("--rankfile ranks", {}),
        ("--prtemca hwloc_default_binding_policy core", {}),
        ("", {"PRTE_MCA_hwloc_default_binding_policy": "core"}),
        ("", {"OMPI_MCA_hwloc_base_binding_policy": "core"}),
    ],
)
def test_who_asks_for_a_binding_gets_it(two_cores, monkeypatch, options, variables):
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    argv = starting.command(5, [], mpirun=FIVE, hosts="a,b:2", options=options.split())
    assert "none" not in argv and argv.count("--map-by") == 1


def test_ranks_on_several_hosts_are_not_bound():
    """This also holds for more ranks than cores."""
    script = "import motes, os; print(motes.World(seed=1).size, len(os.sched_getaffinity(0)), flush=True)"
    ranks = (os.cpu_count() or 1) + 1
    ended = motes("run", "-n", str(ranks), "--hosts", f"localhost:{ranks}", "-c", script)
    assert ended.stdout.splitlines() == [f"{ranks} {len(os.sched_getaffinity(0))}"] * ranks, ended.stderr


@pytest.mark.parametrize(
    ("lines", "flags"),
    [
        ("a slots=2\nb slots = 2 # fast\n\n", UNBOUND),
        ("a slots=1\nb slots=1\n", f"{UNBOUND} {YIELD} --map-by node:OVERSUBSCRIBE"),
        ("a\nb slots=1\n", UNBOUND),
    ],
)
def test_flags_of_a_hostfile(two_cores, tmp_path, lines, flags):
    hosts = tmp_path / "hosts"
    hosts.write_text(lines)
    argv = starting.command(4, [], mpirun=FIVE, hostfile=str(hosts))
    assert argv[3:] == ["--hostfile", str(hosts), *flags.split()]


@pytest.mark.parametrize(
    ("ranks", "flags"), [(6, UNBOUND), (7, f"{UNBOUND} {YIELD} --map-by node:OVERSUBSCRIBE")]
)
def test_a_scheduler_knows_the_places(two_cores, monkeypatch, tmp_path, ranks, flags):
    with monkeypatch.context() as slurm:
        slurm.setenv("SLURM_JOB_ID", "7")
        slurm.setenv("SLURM_NTASKS", "6")
        assert starting.command(ranks, [], mpirun=FIVE)[3:] == flags.split()
        argv = starting.command(2, [], mpirun=FIVE, hosts="a,b")
        assert argv[3:] == ["--host", "a:1,b:1", *UNBOUND.split()], "what is asked for counts"
    (tmp_path / "nodes").write_text("a\na\na\nb\nb\nb\n")
    monkeypatch.setenv("PBS_NODEFILE", str(tmp_path / "nodes"))
    assert starting.command(ranks, [], mpirun=FIVE)[3:] == flags.split()


def test_root_is_allowed_only_when_it_is_root(two_cores, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    assert "--allow-run-as-root" in starting.command(2, [], mpirun=FIVE)


# --- the command line


@pytest.mark.parametrize(
    ("line", "parts"),
    [
        ("-n 4 x.py a -n 7", ("", "x.py a -n 7")),
        ("--hosts a,b:2 -n4 x.py -- y", ("", "x.py -- y")),
        ("-n 4 -- --bind-to none x.py a", ("--bind-to none", "x.py a")),
        ("-n 4 -m pack.age --flag -n 3 -- y", ("", "-m pack.age --flag -n 3 -- y")),
        ("-n 4 -c code a -m b", ("", "-c code a -m b")),
        ("-n 4 -- --bind-to none -m pack", ("--bind-to none", "-m pack")),
        ("-n 4 -- --mca plm_rsh_agent /bin/sh x.py b", ("--mca plm_rsh_agent /bin/sh", "x.py b")),
        ("-n 4 -- --mca a b -- /bin/sh -- y", ("--mca a b", "/bin/sh -- y")),
    ],
)
def test_mpiruns_options_and_the_program_are_told_apart(line, parts):
    parser = Parser()
    run_command.configure(parser)
    args = parser.parse_args(line.split())
    assert args.ranks == 4
    assert run_command.split_program(args) == tuple(part.split() for part in parts)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("run -n 4 no_such.py", "script no_such.py does not exist"),
        ("run -n 4", "no script given"),
        ("run -n 0 -c pass", "n must be in 1.."),
        ("run -n 99999999999 -c pass", "the number of ranks on this machine, with 16 MB for each, got 999"),
        ("run -n 99999999999 --hosts a -c pass", "n must be in 1..1000000, the number of ranks, got 999"),
        ("run -n 2 --hostfile nowhere -c pass", "hostfile nowhere does not exist"),
        ("run -n 2 --hostfile a --hosts b -c pass", "either --hosts or --hostfile"),
    ],
)
def test_wrong_arguments_are_answered_in_a_sentence(capsys, line, message):
    assert main(line.split()) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("name", ["-oProxyCommand=touch x", "a b", "$(x)", "", "-v", "a;b", "u@-x", "a\n-x"])
def test_names_that_are_none_of_a_host_are_refused(tmp_path, name):
    """Launchers and ssh would take them for options."""
    for hosts in (name, f"node1:2,{name}:2"):
        with pytest.raises(ArgumentError, match="hosts must be names of hosts"):
            starting.command(2, ["x.py"], hosts=hosts)
        with pytest.raises(ArgumentError, match="hosts must be names of hosts"):
            reachable(hosts)
    if name not in ("", "a b"):
        (tmp_path / "hosts").write_text(f"node1 slots=2\n{name} slots=2\n")
        with pytest.raises(ArgumentError, match="hostfile must be names of hosts"):
            starting.command(2, ["x.py"], hostfile=str(tmp_path / "hosts"))


def test_too_few_ranks_are_an_argument_error():
    with pytest.raises(ArgumentError):
        starting.command(0, [], mpirun=FIVE)


HELLO = "from mpi4py import MPI; import sys; print(MPI.COMM_WORLD.size, sys.argv[1:]); sys.exit(7)"


@pytest.mark.parametrize("ranks", [1, 3])
def test_run_starts_a_script_and_passes_on_its_exit_code(tmp_path, ranks):
    script = tmp_path / "hello.py"
    script.write_text(HELLO)
    ended = motes("run", "-n", str(ranks), str(script), "a", "-n", "9")
    assert ended.stdout.splitlines() == [f"{ranks} ['a', '-n', '9']"] * ranks, ended.stderr
    assert ended.returncode == 7


def test_the_launchers_files_are_its_own_and_do_not_stay(tmp_path):
    """mpirun fails to start if a killed mpirun with the same process id left its files."""
    script = tmp_path / "where.py"
    script.write_text("import os; from mpi4py import MPI; print(os.environ['PMIX_SERVER_TMPDIR'])")
    jobs = [motes("run", "-n", "2", str(script), TMPDIR=str(tmp_path)) for _ in range(2)]
    first, second = (Path(job.stdout.split()[0]).parent for job in jobs)
    assert first != second
    assert all(folder.parent == tmp_path and not folder.exists() for folder in (first, second))


def test_an_interrupt_reaches_the_job(tmp_path):
    code = "import time; print('up', flush=True); time.sleep(600)"
    argv = [sys.executable, "-m", "motes", "run", "-n", "2", "-c", code]
    job = subprocess.Popen(argv, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert job.stdout is not None
    assert "up" in job.stdout.readline()  # from one rank, or from both
    job.send_signal(signal.SIGINT)
    job.communicate(timeout=60)
    assert job.returncode != 0


# --- doctor


def test_doctor_reports_and_counts_problems(capsys):
    code = main(["doctor", "--json"])
    report = json.loads(capsys.readouterr().out)
    assert report["hello"] == ["rank 0 of 2", "rank 1 of 2"]
    assert report["roles"]["n=4"] == ["image generator", "manager", "calculator 0", "calculator 1"]
    assert code == (1 if report["problems"] else 0)


def test_doctor_sees_ranks_that_do_not_see_each_other(monkeypatch, tmp_path):
    monkeypatch.setenv("MOTES_MPIRUN", toy_launcher(tmp_path, says="HYDRA build details: Version: 4.0.2"))
    monkeypatch.setenv("TOY_PYTHON", sys.executable)
    report = doctor.Report()
    doctor._mpi(report)
    assert report.figures["hello"] == ["rank 0 of 1", "rank 0 of 1"]
    assert any("do not see each other" in problem for problem in report.problems)
    assert any("is MPICH 4.0.2, but mpi4py uses" in problem for problem in report.problems)


def test_doctor_waits_for_no_launcher_forever(monkeypatch, tmp_path):
    path = tmp_path / "mpirun"
    says = "mpirun (Open MPI) 5.0.1"
    path.write_text(f'#!/bin/sh\n[ "$1" = --version ] && echo "{says}" && exit\nexec sleep 30\n')
    path.chmod(0o755)
    monkeypatch.setenv("MOTES_MPIRUN", str(path))
    monkeypatch.setattr(doctor, "HELLO_LIMIT_S", 0.3)
    report = doctor.Report()
    doctor._mpi(report)
    assert any("did not end within 0.3 s" in problem for problem in report.problems)


# --- several hosts


@pytest.mark.parametrize(
    ("rank", "code"),
    [
        ("open_worlds.enter(0, '1.1')", 1),
        ("open_worlds.leave(open_worlds.enter(0, '1.1'))", 0),
        ("open_worlds.enter(0, '1.1'); open_worlds.leave(open_worlds.enter(0, '1.1'))", 1),
        ("open_worlds.enter(0, '1.1'); sys.exit(3)", 3),
        ("open_worlds.enter(4, '1.1'); open_worlds.end(open_worlds.enter(0, '1.1'))", 0),
        ("open_worlds.enter(0, '1.2'); open_worlds.end(open_worlds.enter(4, '1.1'))", 1),
        ("open_worlds.enter(0, '1.1'); os.kill(os.getpid(), 9)", 137),
        ("open_worlds.enter(0, '1.1'); sys.exit(9)", 137),
        ("open_worlds.leave(open_worlds.enter(0, '1.1')); sys.exit(9)", 9),
    ],
)
def test_exit_code_0_of_a_launcher_is_checked_against_open_worlds(rank, code):
    launcher = [sys.executable, "-c", f"import os, sys; from motes._run import open_worlds; {rank}"]
    run = f"from motes._launch.supervisor import supervise; raise SystemExit(supervise({launcher!r}).code)"
    ended = subprocess.run([sys.executable, "-c", run], capture_output=True, text=True, timeout=40)
    assert ended.returncode == code, ended.stderr
    assert ("rank(s) 0" in ended.stderr) == (code == 1)
