"""The code of the guide's pages runs as printed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = ("guide", "keyframes", "meetings", "shapes", "reading", "running", "ranks", "frames", "other_codes")


def blocks() -> dict[str, str]:
    """Return the code under each heading; several blocks under one heading form one script."""
    if not (DOCS / "guide.md").is_file():
        return {}
    code = {}
    for page in PAGES:
        for text in re.split(r"^## ", (DOCS / f"{page}.md").read_text(), flags=re.MULTILINE):
            found = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
            heading = text.partition("\n")[0]
            if found:
                assert heading not in code, f"two pages have code under {heading!r}"
                code[heading] = "\n".join(found)
    return code


@pytest.mark.parametrize("heading", blocks())
def test_the_code_under_each_heading_runs(heading: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks()[heading], heading, "exec"), {"__name__": "__main__"})
