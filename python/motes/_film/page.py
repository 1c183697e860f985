"""A film as HTML for notebooks."""

from __future__ import annotations

import base64
import html
import os
from pathlib import Path
from urllib.parse import quote

__all__ = ["video"]

MOST_BYTES = 8_000_000  # largest film that is embedded in a notebook; larger ones are linked by path
_KINDS = {".mp4": "video/mp4", ".mov": "video/mp4", ".mkv": "video/x-matroska"}


def video(path: Path) -> str | None:
    """Return a film as HTML; None if its file is missing, unreadable or of another format."""
    kind = _KINDS.get(path.suffix.lower())
    try:
        small = path.stat().st_size <= MOST_BYTES
        content = path.read_bytes() if small else b""
    except OSError:
        return None
    if kind is None:
        return None
    source = f"data:{kind};base64,{base64.b64encode(content).decode()}" if small else _address(path)
    return (
        f'<video controls loop muted playsinline style="max-width: 100%" src="{html.escape(source)}"></video>'
    )


def _address(path: Path) -> str:
    """Return the file's address relative to the notebook, whose directory is the current one."""
    return quote(Path(os.path.relpath(path)).as_posix())
