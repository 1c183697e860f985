"""Makes text from files safe to print on a terminal."""

from __future__ import annotations

__all__ = ["printable"]


def printable(text: str) -> str:
    r"""Return the text with control characters written as escapes, such as `\x1b`.

    Names come from files that others wrote: an escape sequence in one must not reach the terminal. Newlines,
    characters that change the direction of text, and unpaired surrogates are escaped, too.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)
