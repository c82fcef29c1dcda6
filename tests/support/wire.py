"""A page of the viewer without a browser: it connects and sends messages as viser's page does."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from urdf_ik.show.viewer import Viewer

PATIENCE = 60.0


def wait(what: Callable[[], object]) -> None:
    """Wait until ``what()`` is true."""
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end, f"waited {PATIENCE:g} s in vain"
        time.sleep(0.02)


def connect(viewer: Viewer, **options: Any) -> Any:
    """A connection as the page opens it."""
    import viser
    from websockets.sync import client

    own = f"http://127.0.0.1:{viewer.port}"
    options = {"origin": own, "subprotocols": [f"viser-v{viser.__version__}"], "max_size": None} | options
    return client.connect(options.pop("url", viewer.url.replace("http", "ws")), **options)


class WirePage:
    """An open page; its widgets are known by their labels.

    Attributes:
        widgets: identifiers by label.
    """

    def __init__(self, viewer: Viewer) -> None:
        """Open the page, and wait until the viewer counts it."""
        self._viewer, self._connection = viewer, connect(viewer)
        self.widgets: dict[str, str] = {}
        before = len(viewer.server.get_clients())
        self.send(
            "ViewerCameraMessage", wxyz=[1, 0, 0, 0], position=[1, 1, 1], fov=1.0, near=0.1, far=9.0, image_height=10,
            image_width=10, look_at=[0, 0, 0], up_direction=[0, 0, 1],
        )  # fmt: skip
        wait(lambda: len(viewer.server.get_clients()) > before)

    def __enter__(self) -> WirePage:
        return self

    def __exit__(self, *_: object) -> None:
        self._connection.close()

    def send(self, kind: str, **fields: Any) -> None:
        """Send a message."""
        import msgspec.msgpack

        self._connection.send(msgspec.msgpack.encode({"type": kind, **fields}))

    def change(self, label: str, value: Any) -> None:
        """Give a widget a value, as the reader of the page does; a button is given True."""
        while label not in self.widgets:
            self._read()
        self.send("GuiUpdateMessage", uuid=self.widgets[label], updates={"value": value})

    def _read(self) -> None:
        import msgspec.msgpack
        import zstandard

        data = self._connection.recv(timeout=PATIENCE)
        packed = data[16 : 16 + int.from_bytes(data[8:16], "little")]
        for message in msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(packed))["messages"]:
            if "uuid" in message and isinstance(message.get("props"), dict) and "label" in message["props"]:
                self.widgets[message["props"]["label"]] = message["uuid"]
