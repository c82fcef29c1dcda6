"""Recording: what a page shows, frame by frame, as an animated GIF or as PNG files in a zip."""

from __future__ import annotations

import io
import threading
import time
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from PIL import Image
    Frame = tuple[float, Image.Image]

KINDS = ("GIF", "PNG files (zip)")
"""What is written."""
MOST_FRAMES = 300
"""A recording ends by itself after so many frames, which are at most 92 MB in memory."""
_WIDTH, _HEIGHT = 640, 480
_PAUSE = 0.1  # s from one frame to the next, where the page draws as fast
_PATIENCE = 20.0  # s that a page may take to draw one
_RECORD, _SAVE = "Record", "Stop and save"


class Recorder:
    """A button that begins to record the page on which it is clicked, and that ends it and saves the file there.

    Attributes:
        kind: what is written.
        button: begins and ends.
        count: frames so far.
    """

    def __init__(self, gui: Any, name: Callable[[], str], say: Callable[[str], None]) -> None:
        """Add the widgets.

        Args:
            gui: of the viser server.
            name: the name of the arm that is shown.
            say: called with why a recording has ended early.
        """
        self._name, self._say = name, say
        self._stop: threading.Event | None = None
        self.count = 0
        with gui.add_folder("Record", expand_by_default=False, order=9e8):
            self.kind = gui.add_dropdown("As", KINDS)
            self.button = gui.add_button(_RECORD, hint="Play a path or drag the target meanwhile")
        self.button.on_click(self._clicked)

    def _clicked(self, event: Any) -> None:
        if self._stop is not None:
            self._stop.set()
        elif event.client is not None:
            self._stop, self.count = threading.Event(), 0
            self.button.label = _SAVE
            threading.Thread(
                target=self._run, args=(event.client, self._stop), name="urdf-ik recorder", daemon=True
            ).start()

    def _run(self, client: Any, stop: threading.Event) -> None:
        frames: list[Frame] = []
        try:
            while len(frames) < MOST_FRAMES and not (frames and stop.wait(_PAUSE)):
                shot = client.get_render(_HEIGHT, _WIDTH, timeout=_PATIENCE)
                frames.append((time.monotonic(), reduced(shot)))
                self.count = len(frames)
        except Exception as error:  # the page has closed, or draws nothing
            self._say(f"The recording ended after {len(frames)} frames: {type(error).__name__}")
        finally:
            self._stop, self.button.label = None, _RECORD
        if frames:
            kind = self.kind.value
            ending = ".gif" if kind == KINDS[0] else ".zip"
            client.send_file_download(
                f"{Path(self._name()).name}{ending}", written(frames, kind), save_immediately=True
            )


def reduced(pixels: NDArray[np.uint8]) -> Image.Image:
    """A frame (h, w, 3 or more) in 256 colours: a byte a pixel."""
    from PIL import Image  # viser brings it

    return Image.fromarray(np.ascontiguousarray(pixels[..., :3])).quantize(256)


def written(frames: Sequence[Frame], kind: str) -> bytes:
    """Frames as a file, each with the moment [s] at which it was seen; ``kind`` is one of ``KINDS``.

    Example:
        >>> import numpy as np
        >>> from PIL import Image
        >>> frames = [(0.1 * k, reduced(np.full((4, 6, 3), 60 * k, np.uint8))) for k in range(3)]
        >>> Image.open(io.BytesIO(written(frames, "GIF"))).n_frames
        3
    """
    file = io.BytesIO()
    if kind != KINDS[0]:
        with zipfile.ZipFile(file, "w") as archive:
            for number, (_, image) in enumerate(frames):
                picture = io.BytesIO()
                image.save(picture, format="PNG")
                archive.writestr(f"{number:04d}.png", picture.getvalue())
        return file.getvalue()
    moments = np.array([moment for moment, _ in frames])
    gaps = np.diff(moments) if len(frames) > 1 else np.array([_PAUSE])
    first, *others = (image for _, image in frames)
    first.save(
        file, format="GIF", save_all=True, append_images=others, loop=0,
        duration=[max(20, round(1000.0 * gap)) for gap in (*gaps, gaps[-1])][: len(frames)],
    )  # fmt: skip
    return file.getvalue()
