"""Links of the README, and what the page on the command shows is what it prints."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
COMMAND = (ROOT / "docs" / "command.md").read_text()


def test_links_of_the_readme_lead_to_files() -> None:
    """Those of the pages: see test_docs.py."""
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
