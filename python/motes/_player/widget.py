"""The widget that shows a run in a notebook. Imports anywidget."""

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
    """A player that is a widget. Its page has the view of the live page; messages go through the kernel."""

    _esm = files.read("view.js") + files.read("widget.js", __package__)
    _css = files.read("view.css")
    state = traitlets.Dict().tag(sync=True)
    """What the page shows beside the picture."""
    last = traitlets.Bytes().tag(sync=True)
    """The last picture, once the run has ended: the saved notebook has it."""

    def __init__(self, play: Play) -> None:
        """Show what is played."""
        self._lock = threading.Lock()
        self._said: dict[str, Any] = {}  # by the run
        self._facts: dict[str, Any] = {"title": play.title}  # that come before what the run says
        self._newest = b""
        self._left = False
        anywidget.AnyWidget.__init__(self, state=dict(self._facts))
        Player.__init__(self, play)
        self.on_msg(self._hear_page)
        play.face = self

    # --- what the play says, in its threads

    def tell(self, **facts: Any) -> None:
        """Show these facts; None takes one back."""
        if self._left:
            return
        with self._lock:
            merged = {**self._facts, **facts}
            self._facts = {name: fact for name, fact in merged.items() if fact is not None}
            self._update()
            if facts.get("ended") and self._newest:
                self.last = self._newest

    def hear(self, message: dict[str, Any]) -> None:
        """Show what the run says."""
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
        """Send nothing any more: what carries messages is gone."""
        self._left = True

    def _update(self) -> None:
        self.state = {**self._said, **self._facts}

    # --- what the page says, in the thread of the cells

    def _hear_page(self, _: Any, content: Any, __: Any) -> None:
        """Pass on a message of the page; nonsense is ignored here, or refused by the run."""
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
        """Name the run and how it is."""
        return Player.__repr__(self)
