"""Player: a run that goes on beside a notebook's cells."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .._values import arguments

if TYPE_CHECKING:
    from .plays import Play

__all__ = ["Player"]


class Player:
    """A run that goes on beside the notebook's cells. `motes.show` and `motes.launch` return one.

    In a notebook it is a widget: the picture, which the mouse turns; pause, single steps, stop; and the
    world's controls. Elsewhere it is seen in a browser, at `url`.
    """

    _play: Play

    def __init__(self, play: Play) -> None:
        """Take what is played; `motes.show` and `motes.launch` make players.

        Args:
            play: a loop in a thread, or a job.
        """
        self._play = play

    @property
    def running(self) -> bool:
        """Whether it has not come to its end."""
        return not self._play.wait(0)

    @property
    def url(self) -> str | None:
        """Where a browser on this machine sees the run; None before it has begun and after its end."""
        return self._play.url if self.running else None

    @property
    def output(self) -> list[str]:
        """The last lines that the ranks of `motes.launch` have printed, oldest first."""
        return self._play.output()

    def stop(self) -> None:
        """Ask the run to end at the next border between two frames; returns at once.

        A launched run that is asked once more is terminated.
        """
        self._play.stop()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for the run's end. An interrupt asks the run to stop, and is raised when it has.

        Args:
            timeout: seconds; None: as long as it takes.

        Returns:
            Whether the run has ended.
        """
        seconds = None if timeout is None else arguments.number("timeout", timeout, low=0)
        try:
            return self._play.wait(seconds)
        except KeyboardInterrupt:
            self._play.stop()
            self._play.wait(None)
            raise

    def result(self) -> Any:
        """Wait for the run's end, and return what its loop has returned; raise what it has raised.

        Returns:
            The loop's result; None for a launched run.

        Raises:
            MotesError: if a launched run has failed, with the last lines of its output.
        """
        self.wait()
        return self._play.result()

    def __repr__(self) -> str:
        """Name the run and how it is."""
        return f"<Player of {self._play.title!r}, {'running' if self.running else self._play.ending}>"
