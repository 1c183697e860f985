"""Who may watch a live run."""

from __future__ import annotations

import pytest

from motes._live.access import has_token, is_local, own_page


@pytest.mark.parametrize(
    ("target", "fits"),
    [
        ("/?k=abc", True),
        ("/live?x=1&k=abc", True),
        ("/?k=abd", False),
        ("/?k=", False),
        ("/", False),
        ("/?k=%00", False),
    ],
)
def test_the_token_must_be_there(target, fits):
    assert has_token(target, "abc") is fits


@pytest.mark.parametrize(
    ("origin", "host", "local", "fits"),
    [
        ("http://127.0.0.1:8080", "127.0.0.1:8080", True, True),
        ("http://localhost:9000", "localhost:9000", True, True),  # a tunnel from another port
        ("http://[::1]:8080", "[::1]:8080", True, True),
        (None, "127.0.0.1:8080", True, True),  # not a browser
        ("http://evil.example", "127.0.0.1:8080", True, False),
        ("http://127.0.0.1:9999", "127.0.0.1:8080", True, False),
        ("null", "127.0.0.1:8080", True, False),
        ("http://evil.example:8080", "evil.example:8080", True, False),  # a name that points to this host
        (None, "evil.example:8080", True, False),
        ("http://node17:8080", "node17:8080", False, True),
        ("http://evil.example", "node17:8080", False, False),
        (None, None, True, False),
    ],
)
def test_pages_of_others_are_refused(origin, host, local, fits):
    assert own_page(origin, host, local=local) is fits


def test_what_is_local():
    assert all(map(is_local, ("127.0.0.1", "127.1.2.3", "::1", "localhost")))
    assert not any(map(is_local, ("0.0.0.0", "10.0.0.1", "node17", "", None)))
