"""The notebook about swaps can be read without a kernel: exported, in a browser."""

from pathlib import Path

import pytest
from browser import CHROMIUM, INSTALL, chromium

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason=INSTALL)
def test_the_swap_notebook_can_be_read_without_a_kernel(tmp_path: Path) -> None:
    """Run and exported, a browser shows the tables of the comparison, the picture of the arms and the verdicts."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    exporters = pytest.importorskip("nbconvert.exporters")
    pytest.importorskip("playwright.sync_api", reason=INSTALL)
    notebook = nbformat.read(ROOT / "notebooks" / "02_swap_the_urdf.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    file = tmp_path / "swap.html"
    file.write_text(exporters.HTMLExporter().from_notebook_node(notebook)[0])
    with chromium() as browser:
        page = browser.new_page()
        page.goto(file.as_uri(), wait_until="domcontentloaded")
        tables, pictures = page.locator("table"), page.locator(".jp-RenderedHTMLCommon svg, .jp-RenderedImage img")
        assert tables.count() >= 5 and pictures.count() >= 1
        for shown in (*tables.all(), *pictures.all()):
            box = shown.bounding_box()
            assert box is not None and min(box["width"], box["height"]) > 20
        for words in ("1 difference", "joint_2", "free of contact", "PASSED", "FAILED"):
            assert page.get_by_text(words).first.is_visible(), words
        broken = "Array.from(document.images).filter(i => i.complete && !i.naturalWidth).length"
        assert page.evaluate(broken) == 0 and page.locator(".jp-RenderedText[data-mime-type*=error]").count() == 0
