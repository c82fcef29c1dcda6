"""The widgets that stay whatever arm is shown: another arm, and the scene as a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from urdf_ik.model import catalogue

_NO_CHOICE = "catalogue ..."


def add(gui: Any, choose: Callable[[str], None], name: Callable[[], str], page: Callable[[], str]) -> tuple[Any, ...]:
    """Add them: a catalogue, an upload, base and tip of what is uploaded, a button that saves the scene.

    The page chooses among names and sends files of its own: this machine's files are none of its business.

    Args:
        gui: of the viser server.
        choose: called with a catalogue name.
        name: the name of the arm that is shown.
        page: the scene as HTML.
    """
    with gui.add_folder("Another arm", expand_by_default=False, order=1e9):
        names = gui.add_dropdown("Catalogue", (_NO_CHOICE, *catalogue.names()))
        upload = gui.add_upload_button("URDF from this computer", mime_type=".urdf,.xml")
        base, tip = gui.add_text("Base link", ""), gui.add_text("Tip link", "")
    save = gui.add_button("Save the scene as HTML", order=1e9 + 1.0)

    def chosen(event: Any) -> None:
        if event.client_id is not None and names.value in catalogue.names():
            choose(names.value)

    def saved(event: Any) -> None:
        if event.client is not None:
            event.client.send_file_download(f"{Path(name()).name}.html", page().encode(), save_immediately=True)

    names.on_update(chosen)
    save.on_click(saved)
    return names, upload, base, tip, save
