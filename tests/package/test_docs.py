"""The pages: what they show is what the package prints, every public name is in the reference, every link leads on."""

import contextlib
import importlib
import io
import re
import subprocess
import sys
from pathlib import Path

import pytest

import urdf_ik
from urdf_ik.ik.families import registry

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
COMMAND = (DOCS / "command.md").read_text()
MADE = {"_build", "_generated", "reference", "notebooks", "changelog.md", "contributing.md"}
PAGES = sorted(page for page in DOCS.rglob("*.md") if page.relative_to(DOCS).parts[0] not in MADE)
# Blocks that run one after the other, each followed by what it prints.
SHOWN = [page for page in PAGES if "```python\n" in page.read_text()]


@pytest.mark.filterwarnings("ignore:no QP solver:UserWarning")
@pytest.mark.parametrize("page", [ROOT / "README.md", *SHOWN], ids=lambda page: str(page.relative_to(ROOT)))
def test_code_prints_what_stands_below_it(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The Python blocks of a page, run in a folder of their own, print the text blocks that follow them."""
    text = page.read_text()
    if "import pink" in text:
        pytest.importorskip("pink")
    for package in ("xacro", "mujoco"):
        if f".[{'mjcf' if package == 'mujoco' else package}]" in text:
            pytest.importorskip(package)
    monkeypatch.chdir(tmp_path)
    pairs = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", text, re.DOTALL)
    assert pairs
    names: dict[str, object] = {}
    for code in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, str(page), "exec"), names)
        shown = dict(pairs).get(code)
        assert shown is None or printed.getvalue() == shown


def test_every_public_name_is_in_the_reference(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each name of urdf_ik, and each that a documented room names, has its directive; each page is listed."""
    monkeypatch.syspath_prepend(str(DOCS))
    importlib.import_module("names").write(tmp_path)
    reference = "\n".join(page.read_text() for page in tmp_path.glob("*.md"))
    missing = [name for name in urdf_ik.__all__ if not re.search(rf":: urdf_ik\.{name}$", reference, re.MULTILINE)]
    for room in re.findall(r"automodule:: urdf_ik\.([\w.]+)", reference):
        names = getattr(importlib.import_module(f"urdf_ik.{room}"), "__all__", ())
        there = set(re.findall(rf"urdf_ik\.{room}[\w.]*\.(\w+)$", reference, re.MULTILINE))
        missing += [f"{room}.{name}" for name in names if name not in there]
    assert not missing, missing
    listed = (tmp_path / "index.md").read_text().splitlines()
    assert {page.stem for page in tmp_path.glob("*.md")} - {"index"} <= set(listed)


def test_every_page_is_reached_and_every_link_leads_to_a_file() -> None:
    """A page stands in a table of contents; a link to a file has one, and an anchor a heading."""
    listed = set()
    for page in PAGES:
        text = page.read_text()
        for block in re.findall(r"```\{toctree\}\n(.*?)```", text, re.DOTALL):
            entries = [line for line in block.splitlines() if line and not line.startswith(":")]
            listed |= {(page.parent / f"{entry}.md").resolve() for entry in entries}
        for link in re.findall(r"\]\(([^):]+)\)", re.sub(r"```.*?```", "", text, flags=re.DOTALL)):
            file, _, anchor = link.partition("#")
            if "_generated" in file or file.startswith("reference/"):
                continue
            target = (page.parent / file).resolve() if file else page
            if "notebooks/" in file:  # copied there when the pages are built
                target = ROOT / "notebooks" / target.name
            assert target.exists(), (page.name, link)
            headings = re.findall(r"^#+ (.*)$", target.read_text(), re.MULTILINE) if anchor else []
            slugs = {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
            assert not anchor or anchor in slugs, (page.name, link)
    assert {page for page in PAGES if page.name != "index.md" or page.parent != DOCS} <= listed


def test_formulas_need_no_network() -> None:
    """Every formula of the pages becomes MathML as a whole, and no setting of the pages asks another server."""
    latex2mathml = pytest.importorskip("latex2mathml.converter", reason="the docs' extra brings it")
    pages = [*(ROOT / "docs").rglob("*.md"), ROOT / "README.md"]
    count = 0
    for page in pages:
        text = re.sub(r"```.*?```|`[^`]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        for display, inline in re.findall(r"\$\$(.+?)\$\$|\$([^$\n]+?)\$", text, flags=re.DOTALL):
            drawn = latex2mathml.convert(display or inline)
            assert drawn.startswith("<math") and not re.findall(r"\\[A-Za-z]+", drawn), (page.name, display or inline)
            count += 1
    assert count > 100
    settings = (ROOT / "docs" / "conf.py").read_text(encoding="utf-8")
    assert "mathjax" not in settings and "http" not in settings and 'html_math_renderer = "mathml"' in settings


def test_every_room_stands_in_the_layout() -> None:
    """Each module and folder of the package is named on the page that says which does what."""
    page = (ROOT / "CONTRIBUTING.md").read_text()
    package = ROOT / "src" / "urdf_ik"
    rooms = {path.stem for path in package.glob("*.py")} | {path.parent.name for path in package.glob("*/__init__.py")}
    assert {room for room in rooms if not re.search(rf"`{room}/?`", page)} == {"__init__"}


def test_every_family_has_a_page_that_says_where_it_comes_from() -> None:
    """The explanation names the file of each family's solver or of its Python side."""
    pages = "\n".join(page.read_text() for page in (DOCS / "explanation").glob("*.md"))
    modules = {family.prepare.__module__.rpartition(".")[2] for family in registry.every()}
    headers = {"general": "elimination.hpp"}
    missing = [name for name in modules if f"{name}.hpp" not in pages and headers.get(name, "?") not in pages]
    assert not missing, missing


def test_links_of_the_readme_lead_to_files() -> None:
    """Those of the README and of CONTRIBUTING, too."""
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md"):
        for link in re.findall(r"\]\(([^)#:]+)[)#]", page.read_text()):
            assert (page.parent / link).exists(), (page.name, link)


def test_the_command_prints_what_is_shown() -> None:
    """`urdf-ik ik zyyzyz_6r` prints what its page shows; errors, which are rounding, may differ in their digits."""
    shown = re.search(r"`make run` and `urdf-ik ik zyyzyz_6r` print:\s*```text\n(.*?)```", COMMAND, re.DOTALL)
    assert shown is not None
    command = [sys.executable, "-m", "urdf_ik.cli", "ik", "zyyzyz_6r"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    table = "#  in limits"
    assert printed.split(table)[0] == shown[1].split(table)[0]
    rounding = re.compile(r"\d\.\de-\d+|\b0\b")
    first, second = (rounding.sub("E", text.split(table)[1]).split() for text in (printed, shown[1]))
    assert first == second


def test_the_shortened_outputs_are_lines_of_the_whole() -> None:
    """`info` and `check` print the lines that docs/command.md shows, in that order, up to digits of rounding."""
    for command in ("info", "check"):
        shown = re.search(rf"`urdf-ik {command} zyyzyz_6r`[^`]*```text\n(.*?)```", COMMAND, re.DOTALL)
        assert shown is not None
        arguments = [sys.executable, "-m", "urdf_ik.cli", command, "zyyzyz_6r"]
        printed = subprocess.run(arguments, capture_output=True, text=True, check=True).stdout
        rounding = re.compile(r"\d\.\de-1[3-9]")
        lines = iter([rounding.sub("E", line) for line in printed.splitlines()])
        for line in shown[1].splitlines():
            assert rounding.sub("E", line) in lines, line
