"""The notebooks: one question each, in few cells; `--nbmake` runs them all."""

import json
from pathlib import Path

NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))
MOST_CELLS = 12


def test_a_notebook_asks_one_question_in_few_cells() -> None:
    """Its first line is the question, and no other heading is as large."""
    for notebook in NOTEBOOKS:
        cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
        lines = ["".join(cell["source"]).splitlines() for cell in cells if cell["cell_type"] == "markdown"]
        headings = [line for each in lines for line in each if line.startswith("# ")]
        assert len(cells) <= MOST_CELLS, notebook.name
        assert headings == [lines[0][0]] and headings[0].endswith("?"), notebook.name
