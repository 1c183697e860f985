"""The page about heaps shows what its script measures."""

from __future__ import annotations

import pytest
from docs_scripts import script_of_docs


@pytest.mark.slow
def test_the_page_of_heaps_tells_what_is_measured():
    made = script_of_docs("make_heaps")
    rows = made.PAGE.read_text().split(made.MARK)[1].splitlines()[2:]
    assert len(rows) == len(made.CASES)
    for row, case in list(zip(rows, made.CASES, strict=True))[:2]:
        assert made.measure(*case).split(" | ")[:-1] == row.split(" | ")[:-1], (
            "run docs/lab/scripts/make_heaps.py"
        )
