"""Write docs/environment.md from the table of variables: `python docs/scripts/make_environment.py`."""

from __future__ import annotations

from pathlib import Path

from motes._values.environment import TABLE

PAGE = Path(__file__).resolve().parents[1] / "environment.md"
HEAD = """# Environment variables

They take precedence over the script. A value that is not allowed is an `ArgumentError` that names
the variable. `python -m motes doctor` prints this list with current values.
(`docs/scripts/make_environment.py` writes this page.)

| variable | meaning | allowed | default |
|---|---|---|---|
"""


def page() -> str:
    """Return the whole page."""
    rows = []
    for variable in TABLE.values():
        default = variable.default_text or str(variable.default)
        rows.append(f"| `{variable.name}` | {variable.meaning} | {variable.allowed} | {default} |")
    return HEAD + "\n".join(rows) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page())
