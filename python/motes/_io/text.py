"""Text from files on its way to a terminal."""

from __future__ import annotations

__all__ = ["printable"]


def printable(text: str) -> str:
    r"""Return the text with control characters written as escapes, such as `\x1b`.

    Names come from files that others wrote: an escape sequence in one must not reach the terminal. Line
    ends, characters that reverse the direction of writing, and halves of surrogate pairs are escaped, too.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)
