"""The cameras of the viewer's pages: each new page, and each that asks for it, sees all there is."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

View = tuple[NDArray[np.float64], NDArray[np.float64]]


class Cameras:
    """Turns the cameras of pages.

    Args:
        server: viser's.
        ask: puts a job, under a key, where the arm is not being replaced.
        view: where a camera stands and what it looks at, from its angle of view and its window's aspect.
    """

    def __init__(self, server: Any, ask: Callable[..., object], view: Callable[[float, float], View]) -> None:
        self.server, self.ask, self.view = server, ask, view

    def greet(self, client: Any) -> None:
        """Have a new page see the whole arm, also after it went to viser's first view: a slow one does so late."""

        async def moved(camera: Any) -> None:
            first = self.server.initial_camera
            if np.allclose(camera.position, first.position) and np.allclose(camera.look_at, first.look_at):
                self.ask_for_view(client)

        client.camera.on_update(moved)
        self.ask_for_view(client)

    def framed(self, event: Any) -> None:
        """Have the page of an event see the whole arm."""
        if event.client is not None:
            self.ask_for_view(event.client)

    def ask_for_view(self, client: Any) -> None:
        """Have a page see the whole arm, when the arm is not being replaced."""
        self.ask(("view", client.client_id), lambda: self.frame(client))

    def frame(self, *clients: Any) -> None:
        """Have pages see the whole arm."""
        for client in clients:
            view = self.view(client.camera.fov, client.camera.aspect)
            self.server.get_event_loop().call_soon_threadsafe(self._turn, client, *view)

    def _turn(self, client: Any, position: NDArray[np.float64], look_at: NDArray[np.float64]) -> None:
        """Turn the camera of a page, if it is still open: viser warns of each message to a closed one.

        Only in the server's event loop, which reads the messages of pages. Elsewhere one with an older view could be
        read between the two steps: viser would compare the second with it, and might not send it.
        """
        with suppress(UserWarning):
            if client.client_id in self.server.get_clients():
                client.camera.position, client.camera.look_at = position, look_at
