"""What another balancer would have done with the loads of an earlier run: no MPI, the same policies."""

from .replay import replay

__all__ = ["replay"]
