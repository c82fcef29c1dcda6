"""Sphinx's settings. `make docs` builds the pages; warnings are errors."""

import re
import shutil
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path.insert(0, str(HERE))

import drawings  # noqa: E402  beside this file
import gallery  # noqa: E402
import live  # noqa: E402
import names  # noqa: E402

import urdf_ik  # noqa: E402

project = "urdf-ik"
author = "the urdf-ik authors"
release = version = urdf_ik.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode", "formulas"]
exclude_patterns = ["_build", "_generated", "**.ipynb_checkpoints"]
html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"urdf-ik {release}"
html_theme_options = {"source_repository": "", "navigation_with_keys": True}
html_show_sphinx = False
copyright = "2026, the urdf-ik authors"  # noqa: A001  Sphinx's name for it; the footer shows it
html_static_path = ["_static"]
html_extra_path = ["_generated/live"]  # filled before the pages are written
(HERE / "_generated" / "live").mkdir(parents=True, exist_ok=True)
html_css_files = ["pages.css"]

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
suppress_warnings = ["myst.header"]  # a page's first heading may stand below its picture

# The notebooks stand in notebooks/ and are executed here.
nb_execution_mode = "cache"  # a notebook runs again after a change, and in a fresh checkout
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True
nb_ipywidgets_js: dict[str, dict[str, str]] = {}  # sliders need a kernel, and their scripts a network

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings give types, shapes and units
autodoc_preserve_defaults = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
default_role = "code"

# Links of the pages to files outside docs/, and their places in the build.
OUTSIDE = {
    "../notebooks/": "/notebooks/",
    "../../notebooks/": "/notebooks/",
    "../CHANGELOG.md": "/changelog.md",
    "../CONTRIBUTING.md": "/contributing.md",
}


def copy_sources(app: Any) -> None:
    """Bring notebooks, changelog, drawings and the pages of the reference to where Sphinx reads them."""
    folder = HERE / "notebooks"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for notebook in sorted((ROOT / "notebooks").glob("*.ipynb")):
        shutil.copy(notebook, folder)
    for name in ("CHANGELOG", "CONTRIBUTING"):
        shutil.copy(ROOT / f"{name}.md", HERE / f"{name.lower()}.md")
    drawings.write(HERE / "_generated")
    gallery.write(HERE / "_generated")
    live.write(HERE / "_generated")
    names.write(HERE / "reference")


def point_inside(app: Any, name: str, source: list[str]) -> None:
    """Let links to files of the repository lead to their pages."""
    for outside, inside in OUTSIDE.items():
        source[0] = source[0].replace(f"]({outside}", f"]({inside}")
    if name in ("changelog", "contributing"):
        source[0] = re.sub(r"\]\(docs/", "](/", source[0]).replace("](CHANGELOG.md)", "](/changelog.md)")


def whole_sentences(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Give a constant its sentence back: napoleon takes what stands before a colon for a type."""
    if what in ("attribute", "data") and lines and lines[-1].startswith(":type: "):
        lines[0] = f"{lines.pop().removeprefix(':type: ')}: {lines[0]}"


def setup(app: Any) -> None:
    """Connect these functions to the build."""
    app.connect("autodoc-process-docstring", whole_sentences, priority=600)  # after napoleon's 500
    app.connect("builder-inited", copy_sources)
    app.connect("source-read", point_inside)
