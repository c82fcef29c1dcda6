"""Files that a page uploads: one at a time, of bounded size; an unfinished one is dropped when its page closes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from urdf_ik.errors import printable

MAX_BYTES = 16 * 2**20
"""Greatest size of a file; a URDF of 500 links has less than one of these."""
_MAX_PARTS, _MAX_UNFINISHED = 1024, 4


class Uploads:
    """Takes the place of viser's own upload, which keeps whatever is sent.

    Attributes:
        unfinished: bytes that have come so far of each file that is on its way, by the page that sends it.
    """

    def __init__(self, server: Any, button: Any, done: Callable[[bytes], None], say: Callable[[str], None]) -> None:
        """Have ``done`` called with each file that is chosen with ``button``, and ``say`` with what is refused."""
        from viser import _messages as messages

        self.unfinished: dict[int, _File] = {}
        self._button, self._done, self._say = button, done, say
        self._acknowledge = messages.FileTransferPartAck
        self._connection = server._websock_server
        for kind, take in ((messages.FileTransferStartUpload, self._begin), (messages.FileTransferPart, self._part)):
            self._connection.unregister_handler(kind)
            self._connection.register_handler(kind, take)
        self._connection.on_client_disconnect(lambda client: self.unfinished.pop(client.client_id, None) and None)

    def _begin(self, client: int, message: Any) -> None:
        self.unfinished.pop(client, None)
        size, count = message.size_bytes, message.part_count
        if message.source_component_uuid != self._button._impl.uuid:
            return
        if not (isinstance(size, int) and isinstance(count, int) and size >= 0 and 0 <= count <= _MAX_PARTS):
            return
        if size > MAX_BYTES:
            self._say(f"{printable(message.filename)} is larger than {MAX_BYTES >> 20} MiB; a URDF holds no meshes")
            return
        while len(self.unfinished) >= _MAX_UNFINISHED:
            self.unfinished.pop(next(iter(self.unfinished)))
        self.unfinished[client] = _File(message.transfer_uuid, size, count)
        if not count:
            self._finish(client)

    def _part(self, client: int, message: Any) -> None:
        file = self.unfinished.get(client)
        if file is None or file.transfer != message.transfer_uuid:
            return
        part, content = message.part_index, message.content
        wrong = part in file.parts or part not in range(file.count) or not isinstance(content, bytes)
        if wrong or file.received + len(content) > file.size:
            del self.unfinished[client]
            return
        file.parts[part] = content
        file.received += len(content)
        self._connection.queue_message(
            self._acknowledge(message.source_component_uuid, file.transfer, file.received, file.size)
        )
        if len(file.parts) == file.count:
            self._finish(client)

    def _finish(self, client: int) -> None:
        file = self.unfinished.pop(client)
        if file.received == file.size:
            self._done(b"".join(file.parts[k] for k in range(file.count)))


class _File:
    """The received parts of a file."""

    def __init__(self, transfer: str, size: int, count: int) -> None:
        self.transfer, self.size, self.count = transfer, size, count
        self.parts: dict[int, bytes] = {}
        self.received = 0
