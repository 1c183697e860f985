"""The tables of a recorded run that a replay reads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pandas import DataFrame

__all__ = ["Tables"]


class Tables(Protocol):
    """Data needed from a recorded run; a `Run` has all of them."""

    @property
    def name(self) -> str:
        """The run's name, for error messages."""

    @property
    def calculators(self) -> list[int]:
        """The calculators' ranks in the order of their domains."""

    @property
    def systems(self) -> list[str]:
        """The particle systems' names."""

    def axis(self, system: str) -> str:
        """Return the axes along which a system's domains are cut.

        Args:
            system: the system's name.

        Returns:
            "x", "xz", ...; "hilbert", "morton"; "id" if particles are distributed by id.
        """

    @property
    def speeds(self) -> Mapping[int, float]:
        """Factors by which ranks were slowed down on purpose; empty if none were."""

    @property
    def hosts(self) -> Mapping[int, str]:
        """Each rank's host."""

    @property
    def frames(self) -> DataFrame:
        """The log's table `frames`."""

    @property
    def load(self) -> DataFrame:
        """The log's table `load`."""

    @property
    def density(self) -> DataFrame:
        """The log's table `density`."""

    @property
    def balance(self) -> DataFrame:
        """The log's table `balance`."""

    @property
    def times(self) -> DataFrame:
        """The log's table `times`."""

    @property
    def links(self) -> DataFrame:
        """The log's table `links`."""

    @property
    def facts(self) -> Mapping[str, Any]:
        """Facts about the run, as in run.json."""

    @property
    def balancer(self) -> str:
        """The run's balancer."""
