"""Whatever the files of a log contain, reading them works or raises LogError with the file's name."""

from __future__ import annotations

import io
import json
import shutil
import tempfile
import warnings
from pathlib import Path
from typing import Any

import pytest
from handmade import load_row, moving_spot, write_log
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import motes
from motes import LogError
from motes._io.text import printable
from motes.analysis._tables.tables import read_facts
from motes.analysis.view import View
from motes.balance import PrefixCuts
from motes.cli import main
from motes.cli.watch import watch

pytest.importorskip("pandas")
pytest.importorskip("matplotlib").use("Agg")

FILES = (
    "run.json",
    "frames.jsonl",
    "load.jsonl",
    "balance.jsonl",
    "density.jsonl",
    "events.jsonl",
    "spans.r0002.jsonl",
)
DEEP = "[" * 100_000 + "]" * 100_000
VALUES = (
    *("null", "true", "-1", "0", "1e999", "-1e999", "NaN", "Infinity", "9" * 30, "9" * 400, "9" * 5000),
    *(
        '""',
        '"x"',
        '"\\ud800"',
        '"\\u001b[31m"',
        "[]",
        "[1, 2]",
        "{}",
        '{"a": [{}]}',
        "0.5",
        "1e308",
        "-1e308",
    ),
    *("2147483648", "9007199254740993", "1000000000000000000", DEEP),
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return moving_spot(tmp_path_factory.mktemp("logs") / "spot", frames=4, calculators=3, particles=600)


def damaged(log: Path, name: str, draw: Any) -> None:
    """Damage one file of a log: a value, a key, a line, or some bytes."""
    path = log / name
    how = draw(st.sampled_from(["value", "value", "value", "drop", "bytes", "repeat", "delete", "swap"]))
    if how == "bytes":
        content = bytearray(path.read_bytes())
        at = draw(st.integers(0, len(content) - 1))
        content[at : at + draw(st.integers(0, 40))] = draw(st.binary(max_size=12))
        path.write_bytes(content)
        return
    separator = "\n" if name.endswith("l") else "\0"
    lines = path.read_text().rstrip().split(separator)
    at = draw(st.integers(0, len(lines) - 1))
    row = json.loads(lines[at])
    if how == "value":
        key = draw(st.sampled_from(sorted(row)))
        row[key] = "<here>"
        lines[at] = json.dumps(row).replace('"<here>"', draw(st.sampled_from(VALUES)))
    elif how == "drop":
        del row[draw(st.sampled_from(sorted(row)))]
        lines[at] = json.dumps(row)
    elif how == "repeat":
        lines.insert(at, lines[at])
    elif how == "delete":
        del lines[at]
    else:
        lines[at], lines[0] = lines[0], lines[at]
    path.write_text(separator.join(lines) + "\n", errors="surrogatepass")


def read_all(log: Path, *, plots: bool) -> list[LogError]:
    """Use every way to read a log; return the LogErrors. Other errors are not caught."""
    run = motes.open_run(log)
    made = []
    for work in (
        run.summary,
        run.warnings,
        lambda: [run.by_rank(column) for column in ("t_compute_s", "n_end", "speed", "domain_hi")],
        lambda: run.replay(PrefixCuts()).summary(),
        lambda: run.to_perfetto(log / "trace.json"),
        lambda: motes.open_runs([log]).speedup(),
        lambda: repr(run),
        lambda: watch(log, once=True, out=io.StringIO()),
        lambda: json.dumps(_figures(log)),
        *((run._repr_html_, lambda: main_report(log)) if plots else ()),
    ):
        try:
            work()
        except LogError as error:
            made.append(error)
    return made


def _figures(log: Path) -> dict[str, Any]:
    view = View(log, read_facts(log))
    view.read()
    return view.figures()


def main_report(log: Path) -> None:
    """Write the report as the command does, which prints only errors of motes."""
    assert main(["report", str(log), "-o", str(log / "report.html")]) in (0, 2)


def check(whole: Path, draw: Any, *, plots: bool) -> None:
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        log = Path(shutil.copytree(whole, Path(folder) / "log"))
        for name in draw(st.lists(st.sampled_from(FILES), min_size=1, max_size=2, unique=True)):
            damaged(log, name, draw)
        try:
            errors = read_all(log, plots=plots)
        except LogError as error:
            errors = [error]
        assert all("log" in str(error) for error in errors), "an error names the log or its file"


# Damage is random and small, so failing examples are readable without shrinking, which is slow.
FUZZ = {
    "deadline": None,
    "suppress_health_check": list(HealthCheck),
    "derandomize": True,
    "phases": [Phase.explicit, Phase.generate],
}


@settings(max_examples=30, **FUZZ)
@given(data=st.data())
def test_a_damaged_log_is_read_or_refused(whole, data):
    check(whole, data.draw, plots=False)


@settings(max_examples=2, **FUZZ)
@given(data=st.data())
def test_a_damaged_log_is_drawn_or_refused(whole, data):
    check(whole, data.draw, plots=True)


@pytest.mark.slow
@settings(max_examples=400, **FUZZ | {"derandomize": False})
@given(data=st.data())
def test_many_damaged_logs_are_drawn_or_refused(whole, data):
    check(whole, data.draw, plots=True)


# --- the file and line that an error names


@pytest.mark.parametrize(
    ("column", "value", "says"),
    [
        ("n_end", "9" * 30, "n_end must be a whole number up to 2^53 or null, got 9999"),
        ("n_end", "9" * 400, "n_end must be a whole number"),
        ("t_compute_s", "9" * 400, "t_compute_s must be a number below 1e100 or null"),
        ("t_compute_s", "1e999", "t_compute_s must be a number below 1e100 or null, got inf"),
        ("t_compute_s", '"x"', "t_compute_s must be a number below 1e100 or null, got 'x'"),
        ("frame", "null", "frame must be a whole number up to 2^53 and >= 0, got None"),
        ("rank", "[1]", "rank must be a whole number"),
        ("system", "7", "system must be a string, got 7"),
        ("speed", "NaN", "NaN is not a number"),
        ("host", DEEP, "damaged row: maximum recursion depth"),
    ],
)
def test_damage_is_named_with_file_and_line(tmp_path, column, value, says):
    log = write_log(tmp_path / "log", [load_row(0, "a", rank, n_end=5, t_compute_s=1.0) for rank in (2, 3)])
    lines = (log / "load.jsonl").read_text().splitlines()
    row = json.loads(lines[1]) | {column: "<here>"}
    lines[1] = json.dumps(row).replace('"<here>"', value)
    (log / "load.jsonl").write_text("\n".join([*lines, lines[0]]) + "\n")
    for read in (lambda: motes.open_run(log).load, lambda: watch(log, once=True, out=io.StringIO())):
        with pytest.raises(LogError) as caught:
            read()
        assert f"{log / 'load.jsonl'}, line 2: " in str(caught.value)
        assert says in str(caught.value)


@pytest.mark.parametrize(
    ("fact", "value", "says"),
    [
        ("calculators", [2, "x"], "calculators must be a list of different ranks, got [2, 'x']"),
        ("calculators", [2, 2], "calculators must be a list of different ranks, got [2, 2]"),
        ("ranks", [{"host": "h"}], "ranks must be a number, or a list of ranks and hosts"),
        ("space", [1], "space must be a string or two numbers, got [1]"),
        ("speeds", {"a": 1}, "speeds must be speeds by rank"),
        ("systems", 5, "systems must be a list of strings"),
        ("manager", "boss", "manager must be a rank"),
    ],
)
def test_damaged_facts_are_named(tmp_path, fact, value, says):
    log = write_log(tmp_path / "log", [load_row(0, "a", 2)], facts={fact: value})
    with pytest.raises(LogError) as caught:
        motes.open_run(log)
    assert str(caught.value).startswith(f"{log / 'run.json'}: {says}")


def test_commands_say_what_is_damaged_in_a_line(tmp_path, capsys):
    log = write_log(tmp_path / "log", [load_row(0, "a", 2)])
    (log / "events.jsonl").write_text('{"frame": 0}\n')
    for command in (["watch", "--wait", "0"], ["watch", "--once"], ["watch", "--json"], ["report"]):
        assert main([command[0], str(log), *command[1:]]) == 2
        said = capsys.readouterr().err
        assert "events.jsonl, line 1: kind must be a string, got None" in said
        assert said.count("\n") == 1


# --- names from elsewhere on a terminal


def test_no_escape_sequence_of_a_log_reaches_the_terminal(tmp_path, capsys):
    evil = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202eabc\n"
    load = [load_row(0, evil, rank, n_end=5, t_compute_s=1.0, domain_hi=0.5) for rank in (2, 3)]
    log = write_log(tmp_path / "log", load, facts={"balancer": evil, "host": evil})
    with (log / "events.jsonl").open("a") as file:
        file.write(json.dumps({"frame": 0, "kind": "rank_lost", "text": evil}) + "\n")
    assert main(["watch", "--once", str(log)]) == 0
    assert main(["watch", "--once", str(log / evil)]) == 2
    assert main(["report", str(log / evil)]) == 2
    said = capsys.readouterr()
    for text in (said.out, said.err):
        assert not set(text) & {"\x1b", "\x07", "\x9b", "\u202e"}
        assert "\\x1b]0;owned\\x07" in text


def test_what_is_printable_stays():
    assert printable("schön 雪 {}[]") == "schön 雪 {}[]"
    assert printable("a\tb\x00\ud800\x7f") == "a\\tb\\x00\\ud800\\x7f"
