"""The guide's code runs as it stands there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[1] / "docs" / "guide.md"


def blocks() -> dict[str, str]:
    """Return the code under each heading; several blocks under one are one script."""
    sections = re.split(r"^## ", PAGE.read_text(), flags=re.MULTILINE) if PAGE.is_file() else []
    code = {text.partition("\n")[0]: re.findall(r"```python\n(.*?)```", text, re.DOTALL) for text in sections}
    return {name: "\n".join(parts) for name, parts in code.items() if parts}


@pytest.mark.parametrize("heading", blocks())
def test_the_code_under_each_heading_runs(heading: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks()[heading], heading, "exec"), {"__name__": "__main__"})
