"""Load balancers (paper 3.2.5)."""

from __future__ import annotations

__all__ = ["Balancer", "Static"]


class Balancer:
    """Base of all balancers."""


class Static(Balancer):
    """Cuts stay where they are."""

    def __repr__(self) -> str:
        """Show the call."""
        return "Static()"
