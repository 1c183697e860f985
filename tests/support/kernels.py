"""A notebook kernel for tests, with a simple front end: cells, interrupts, messages of widgets."""

from __future__ import annotations

import contextlib
import queue
import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest

pytest.importorskip("ipykernel")
manager = pytest.importorskip("jupyter_client.manager")

HEAD = struct.Struct("<4sIIII")
LIMIT_S = 60


@dataclass
class Cell:
    """The output of a cell."""

    text: str = ""
    """The printed text."""
    error: str = ""
    """The error that ended it, as "ValueError: text"."""
    result: str = ""
    """The value of its last expression, as text."""
    displays: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    """The contents of each display by its name: the first, then each update."""
    status: str = ""


@dataclass
class Widget:
    """The front end's state of a widget."""

    comm: str
    state: dict[str, Any]
    pictures: list[tuple[int, int, int, int]] = field(default_factory=list)  # number, frame, orders, kind
    refusals: list[str] = field(default_factory=list)
    last: bytes = b""
    acknowledges: bool = True

    @property
    def shown(self) -> dict[str, Any]:
        """Return the values that its page shows beside the picture."""
        return self.state["state"]


class Kernel:
    """A kernel and a front end."""

    def __init__(self, client: Any, process: Any) -> None:
        self.client = client
        self.process = process
        self.widgets: dict[str, Widget] = {}
        self._cells: dict[str, Cell] = {}

    @property
    def widget(self) -> Widget:
        """The newest widget of a run."""
        return [one for one in self.widgets.values() if "_esm" in one.state][-1]

    def begin(self, code: str) -> Cell:
        """Start a cell."""
        cell = Cell()
        self._cells[self.client.execute(code)] = cell
        return cell

    def run(self, code: str) -> Cell:
        """Run a cell to its end; it must not raise an error."""
        cell = self.ended(self.begin(code))
        assert not cell.error, f"{cell.error}\n{cell.text}"
        return cell

    def ended(self, cell: Cell) -> Cell:
        """Wait for a cell's end."""
        self.until(lambda: bool(cell.status))
        return cell

    def interrupt(self) -> None:
        """Press the notebook's button."""
        self.process.interrupt_kernel()

    def say(self, widget: Widget, **content: Any) -> None:
        """Send a message as a widget's page does."""
        data = {"method": "custom", "content": content}
        message = self.client.session.msg("comm_msg", {"comm_id": widget.comm, "data": data})
        self.client.shell_channel.send(message)

    def until(self, true: Callable[[], Any], seconds: float = LIMIT_S) -> None:
        """Process the kernel's messages until a condition is true."""
        limit = time.monotonic() + seconds
        while not true():
            left = limit - time.monotonic()
            assert left > 0, f"not within {seconds} s: {self._cells} {self.widgets}"
            with contextlib.suppress(queue.Empty):
                self._hear(self.client.get_iopub_msg(timeout=min(left, 0.1)))

    def _hear(self, message: dict[str, Any]) -> None:
        kind, content = message["msg_type"], message["content"]
        if kind == "comm_open":
            self.widgets[content["comm_id"]] = Widget(content["comm_id"], content["data"]["state"])
        elif kind == "comm_msg" and content["comm_id"] in self.widgets:
            self._hear_widget(self.widgets[content["comm_id"]], content["data"], message["buffers"])
        cell = self._cells.get(message["parent_header"].get("msg_id", ""))
        if cell is None:
            return
        if kind == "stream":
            cell.text += content["text"]
        elif kind == "error":
            cell.error = f"{content['ename']}: {content['evalue']}"
        elif kind == "execute_result":
            cell.result = content["data"]["text/plain"]
        elif kind in ("display_data", "update_display_data"):
            name = content["transient"].get("display_id", "")
            cell.displays.setdefault(name, []).append(content["data"] | {"at": time.monotonic()})
        elif kind == "status" and content["execution_state"] == "idle":
            cell.status = "idle"

    def _hear_widget(self, widget: Widget, data: dict[str, Any], buffers: list[Any]) -> None:
        if data["method"] == "update":
            widget.state |= data["state"]
            for path, buffer in zip(data.get("buffer_paths", ()), buffers, strict=True):
                widget.state[path[0]] = bytes(buffer)
        elif data["content"].get("picture"):
            picture = bytes(buffers[0])
            magic, *head = HEAD.unpack_from(picture)
            assert magic == b"mote"
            widget.pictures.append(tuple(head))
            widget.last = picture[HEAD.size :]
            if widget.acknowledges:
                self.say(widget, ack=head[0])
        elif "refused" in data["content"]:
            widget.refusals.append(data["content"]["refused"])


@contextlib.contextmanager
def kernel(**environment: str) -> Iterator[Kernel]:
    """Start a kernel, and shut it down as a notebook does."""
    process, client = manager.start_new_kernel(kernel_name="python3", **environment)
    try:
        yield Kernel(client, process)
    finally:
        client.stop_channels()
        process.shutdown_kernel(now=False)
