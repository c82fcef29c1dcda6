"""The pages as `make docs` builds them, without a network: formulas, pictures and tables in a browser."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from browser import CHROMIUM, INSTALL, PATIENCE, chromium

for package in ("sphinx", "furo", "myst_nb", "latex2mathml"):
    pytest.importorskip(package, reason="the pages are built by urdf-ik[docs]")

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]
# Sphinx's own main, in a process that ends where a socket would leave the machine or a name would be looked up.
OFFLINE = """
import sys
from sphinx.cmd.build import main

def refuse(event, arguments):
    if event in ("socket.getaddrinfo", "socket.gethostbyname", "socket.sendto"):
        where = arguments[0]
    elif event == "socket.connect":
        where = arguments[1][0] if isinstance(arguments[1], tuple) else None  # a path: a socket of this machine
    else:
        return
    if where not in (None, "localhost", "127.0.0.1", "::1"):
        raise OSError(f"the pages ask the network: {event} {arguments}")

sys.addaudithook(refuse)
sys.exit(main(sys.argv[1:]))
"""

WIDTH = 420
# Right edges of the tables' last cells, before and after each table is scrolled to its end.
LAST_CELLS = """all => {
    const edges = () => all.map(e => [...e.querySelectorAll('td')].pop().getBoundingClientRect().right);
    const before = edges();
    all.forEach(e => { for (const part of [e, e.parentElement]) part.scrollLeft = 1e6; });
    return [before, edges()];
}"""


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the built pages; of the notebooks, which another test executes, only the text."""
    place = tmp_path_factory.mktemp("pages")
    settings = ("-W", "--keep-going", "-q", "-D", "nb_execution_mode=off", "-d", str(place / "doctrees"))
    done = subprocess.run(
        [sys.executable, "-c", OFFLINE, *settings, "-b", "html", str(ROOT / "docs"), str(place / "html")],
        capture_output=True, text=True, timeout=900, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return place / "html"


def test_the_guard_refuses_the_network() -> None:
    """A look-up of a name ends the process that builds the pages."""
    code = OFFLINE.replace("sys.exit(main(sys.argv[1:]))", "import socket; socket.create_connection(('pypi.org', 443))")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1 and "the pages ask the network" in done.stderr


@pytest.mark.skipif(CHROMIUM is None, reason=INSTALL)
def test_a_browser_without_a_network_draws_formulas_pictures_and_wide_tables(pages: Path) -> None:
    """Formulas take room, every picture of the gallery is there, a wide table scrolls instead of being cut off."""
    pytest.importorskip("playwright.sync_api", reason=INSTALL)
    asked: list[str] = []
    with chromium() as browser:
        page = browser.new_page(viewport={"width": WIDTH, "height": 800})
        page.set_default_timeout(1000.0 * PATIENCE)
        page.context.set_offline(True)

        def note(request: Any) -> None:
            asked.append(request.url)

        page.on("request", note)
        page.goto((pages / "explanation" / "spherical-wrist.html").as_uri())
        sizes = page.locator("math").evaluate_all("all => all.map(e => e.getBoundingClientRect().width)")
        assert len(sizes) > 10 and min(sizes) > 3.0
        assert not re.findall(r"\\(?:frac|sin|cos|sqrt)|\$\$", page.locator("article").inner_text())
        page.goto((pages / "gallery.html").as_uri())
        widths = page.locator("article img").evaluate_all("all => all.map(e => e.naturalWidth)")
        shown = re.findall(r"^!\[", (ROOT / "docs" / "gallery.md").read_text(), re.MULTILINE)
        assert len(widths) == len(shown) and min(widths) > 100
        page.goto((pages / "speed.html").as_uri())
        before, after = page.locator("article table").evaluate_all(LAST_CELLS)
        assert max(before) > WIDTH and max(after) <= WIDTH
        assert page.evaluate("document.documentElement.scrollWidth") <= WIDTH
    assert not [url for url in asked if not url.startswith(("file:", "data:"))]
