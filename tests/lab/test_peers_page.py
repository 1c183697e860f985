"""The tables of docs/lab/speed.md are written from the measured figures beside the script."""

from __future__ import annotations

import json

from docs_scripts import script_of_docs

make_peers = script_of_docs("make_peers")


def test_the_page_shows_what_was_measured():
    text = make_peers.PAGE.read_text()
    assert make_peers.page(text, json.loads(make_peers.FILE.read_text())) == text, "make_peers.py --tables"
