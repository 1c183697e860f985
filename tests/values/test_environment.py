"""The table of environment variables agrees with the code that reads them, the docs and `doctor`."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from docs_scripts import script_of_docs

from motes._values import environment
from motes._values.environment import TABLE
from motes.cli import main
from motes.errors import ArgumentError

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path(environment.__file__).parents[1]
NAME = re.compile(r"""(?<!-D)\b(MOTES_[A-Z_]+)["'`=]""")


def test_the_page_is_the_table():
    made = script_of_docs("make_environment")
    assert made.PAGE.read_text() == made.page(), "run `python docs/scripts/make_environment.py`"


def test_only_the_table_reads_the_environment():
    for path in PACKAGE.rglob("*.py"):
        if path.name != "environment.py":
            found = re.findall(r"environ(?:\.get\(|\[)\W*MOTES_\w+|getenv\(\W*MOTES_\w+", path.read_text())
            assert found == [], path


def test_whatever_is_named_is_in_the_table():
    for path in PACKAGE.rglob("*.py"):
        assert set(NAME.findall(path.read_text())) <= set(TABLE), path
    for path in (ROOT / "cpp").rglob("*.cpp"):
        assert set(re.findall(r'getenv\("(MOTES_\w+)"', path.read_text())) <= set(TABLE), path


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("MOTES_STALL_S", "2.5", 2.5),
        ("MOTES_STALL_S", "", None),
        ("MOTES_SPEEDS", "2:1.0,3:0.5", {2: 1.0, 3: 0.5}),
        ("MOTES_FAN_OUT", "8", 8),
        ("MOTES_BIRTHS", "calculators", "calculators"),
        ("MOTES_BIRTHS", "", None),
        ("MOTES_ALONE", "1", True),
        ("MOTES_ALONE", "0", False),
        ("MOTES_SMPIRUN", "", "smpirun"),
    ],
)
def test_values_are_parsed(monkeypatch, name, text, value):
    monkeypatch.setenv(name, text)
    assert environment.read(name) == value
    assert environment.is_set(name) == bool(text)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        *(("MOTES_STALL_S", text) for text in ("soon", "0", "-1", "inf", "nan")),
        *(("MOTES_FAN_OUT", text) for text in ("0", "x", "1.5", "²", "9" * 30)),
        *(("MOTES_SPEEDS", text) for text in ("2", "2:0", "2:2", "-1:0.5", "a:b", "2:nan")),
        ("MOTES_PROGRESS", "loud"),
        ("MOTES_BIRTHS", "nobody"),
        ("MOTES_SIMD", "mmx"),
        ("MOTES_ALONE", "yes"),
    ],
)
def test_what_is_not_allowed_is_named(monkeypatch, name, text):
    monkeypatch.setenv(name, text)
    with pytest.raises(ArgumentError) as caught:
        environment.read(name)
    assert str(caught.value) == f"{name} must be {TABLE[name].allowed}, got {text!r}"


def test_doctor_prints_the_table(capsys, monkeypatch):
    monkeypatch.setenv("MOTES_FAN_OUT", "3")
    main(["doctor"])
    lines = {
        line.split()[0]: line for line in capsys.readouterr().out.splitlines() if line.startswith("MOTES_")
    }
    assert list(lines) == list(TABLE)
    assert lines["MOTES_FAN_OUT"].endswith("; = 3")
    assert all(variable.meaning in lines[name] for name, variable in TABLE.items())
