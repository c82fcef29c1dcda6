"""The notebooks: one question each, in few cells; `--nbmake` runs them all."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))
MOST_CELLS = 12


def cells(notebook: Path) -> list[tuple[str, str]]:
    """Kind and text of each cell."""
    held = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return [(cell["cell_type"], "".join(cell["source"])) for cell in held]


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_a_notebook_asks_one_question_in_few_cells(notebook: Path) -> None:
    """Its first line is the question, no other heading is as large, and what it prints is asserted or drawn."""
    held = cells(notebook)
    assert len(held) <= MOST_CELLS
    kind, first = held[0]
    title = first.splitlines()[0]
    assert kind == "markdown" and title.startswith("# ") and title.endswith("?")
    headings = [
        line for kind, text in held if kind == "markdown" for line in text.splitlines() if line.startswith("# ")
    ]
    assert headings == [title]


def test_one_notebook_is_live_without_the_viewer() -> None:
    """Its widgets move the target, and it imports no viewer: no server has to be reached."""
    live = ["\n".join(text for kind, text in cells(notebook) if kind == "code") for notebook in NOTEBOOKS]
    assert [code for code in live if "import ipywidgets" in code and ".ik(" in code and "viewer" not in code.lower()]
