"""The notebook widget that shows a run. Imports anywidget."""

from __future__ import annotations

import json
import threading
from typing import Any

import anywidget
import traitlets

from .._live import files
from .player import Player
from .plays import Play

__all__ = ["WidgetPlayer"]


class WidgetPlayer(Player, anywidget.AnyWidget):
    """A player as a widget, with the view of the live page; messages go through the kernel."""

    _esm = files.read("view.js") + files.read("widget.js", __package__)
    _css = files.read("view.css")
    state = traitlets.Dict().tag(sync=True)
    """The facts that the page shows beside the picture."""
    last = traitlets.Bytes().tag(sync=True)
    """The last picture, set when the run has ended, so that the saved notebook has it."""

    def __init__(self, play: Play) -> None:
        """Show a play."""
        self._lock = threading.Lock()
        self._said: dict[str, Any] = {}  # the run's last state
        self._facts: dict[str, Any] = {"title": play.title}  # take precedence over the run's state
        self._newest = b""
        self._left = False
        anywidget.AnyWidget.__init__(self, state=dict(self._facts))
        Player.__init__(self, play)
        self.on_msg(self._hear_page)
        play.face = self

    # --- messages from the play, in its threads

    def tell(self, **facts: Any) -> None:
        """Show these facts; None removes one."""
        if self._left:
            return
        with self._lock:
            merged = {**self._facts, **facts}
            self._facts = {name: fact for name, fact in merged.items() if fact is not None}
            self._update()
            if facts.get("ended") and self._newest:
                self.last = self._newest

    def hear(self, message: dict[str, Any]) -> None:
        """Show a message of the run: its state, or the refusal of an order."""
        if self._left:
            return
        if "refused" in message:
            self.send(message)
            return
        with self._lock:
            self._said = message
            self._update()

    def show(self, picture: bytes) -> None:
        """Send a picture to the page."""
        self._newest = picture
        if not self._left:
            self.send({"picture": True}, buffers=[picture])

    def leave(self) -> None:
        """Stop sending: the channel to the page is gone."""
        self._left = True

    def _update(self) -> None:
        self.state = {**self._said, **self._facts}

    # --- messages from the page, in the thread of the cells

    def _hear_page(self, _: Any, content: Any, __: Any) -> None:
        """Pass on a message of the page; invalid ones are ignored here, or refused by the run."""
        if not isinstance(content, dict) or len(content) != 1:
            return
        if "looks" in content:
            self._play.looks()
        elif "ack" in content:
            self._play.seen(content["ack"])
        elif content.get("stop") is True:
            self._play.stop()
        elif json.dumps(content):
            self._play.order(content)

    def __repr__(self) -> str:
        """Name the run and its state."""
        return Player.__repr__(self)
