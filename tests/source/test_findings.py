"""Findings about other programs: each script says what was guessed and seen, and pins what it installs."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = sorted((ROOT / "findings").iterdir())


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_finding_stands_alone(script):
    text = script.read_text()
    assert script.suffix == ".sh" and os.access(script, os.X_OK)
    assert text.startswith("#!/usr/bin/env bash\n# ")
    for part in ("# Guessed: ", "# Seen: ", "# Versions: ", "set -euo pipefail", "mktemp -d"):
        assert part in text, part
    assert not re.search(r"\bmotes\b", text)
    names = re.findall(r"[\w-]+(?===)", text.split("# Versions: ")[1].splitlines()[0])
    assert names, "no package with its version"
    for line in text.splitlines():
        if "pip install" in line:
            assert all(re.fullmatch(r"[\w-]+==[\w.]+|\$\w+", one) for one in line.split("-q ")[1].split())
    subprocess.run(["bash", "-n", script], check=True)


def test_the_readme_names_them():
    assert len(SCRIPTS) >= 10
    assert "(findings)" in (ROOT / "README.md").read_text()
