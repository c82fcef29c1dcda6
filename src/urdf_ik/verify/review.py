"""Verified files for a pull request: annotations of GitHub, SARIF 2.1.0 and Markdown, each finding at its line."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from urdf_ik.errors import UrdfIkError
from urdf_ik.support.text import json_text
from urdf_ik.verify.baselines import Verification
from urdf_ik.version import __version__

_SARIF = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
_NAMED = re.compile(r"<(joint|link|body)\b[^<>]*?\sname\s*=\s*[\"'](.*?)[\"']", re.DOTALL)


@dataclass(frozen=True)
class VerifiedFile:
    """A file and the result of its verification.

    Attributes:
        file: as it was typed, relative to the repository.
        result: the verification, or the error that prevented it.
    """

    file: str
    result: Verification | UrdfIkError

    def findings(self) -> list[tuple[int, str, str]]:
        """What a reviewer has to look at: the line of a joint or link, the kind of the difference, and its words."""
        if isinstance(self.result, UrdfIkError):
            return [(getattr(self.result, "line", None) or 1, "unreadable", str(self.result))]
        places, line, found = _places(self.file), 1, []
        for each in self.result.differences:
            line = _line(places, each.name, line)  # solutions: where their cause is
            found.append((line, each.kind, str(each)))
        return [*found, *([(1, "unfinished", self.result.unlooked)] if self.result.unlooked else [])]

    @property
    def passed(self) -> bool:
        """Whether it was verified, without a difference that counts."""
        return isinstance(self.result, Verification) and self.result.passed

    def verdict(self) -> str:
        """The file and its verdict in a line."""
        failed = "FAILED: it cannot be verified"
        return f"{self.file}: {self.result.verdict() if isinstance(self.result, Verification) else failed}"

    def to_dict(self) -> dict[str, Any]:
        """The verification's dictionary, or the error."""
        if isinstance(self.result, Verification):
            return self.result.to_dict()
        return {"passed": False, "error": str(self.result)}

    def __str__(self) -> str:
        return str(self.result) if isinstance(self.result, Verification) else f"FAILED: {self.result}"


def github(files: Sequence[VerifiedFile]) -> str:
    """Workflow commands that annotate a pull request, and the verdict of each file."""
    lines = []
    for file in files:
        path = _command(file.file).replace(":", "%3A").replace(",", "%2C")
        lines.append(_command(file.verdict()))
        for line, kind, words in file.findings():
            lines.append(f"::error file={path},line={line},title=urdf-ik {kind}::{_command(words)}")
    return "\n".join(lines) + "\n"


def sarif(files: Sequence[VerifiedFile]) -> str:
    """A SARIF log for code scanning: a result a finding."""
    results = []
    for file in files:
        artifact = {"uri": file.file.replace("\\", "/")}
        for line, kind, words in file.findings():
            place = {"physicalLocation": {"artifactLocation": artifact, "region": {"startLine": line}}}
            results.append({"ruleId": kind, "level": "error", "message": {"text": words}, "locations": [place]})
    rules = [{"id": kind} for kind in dict.fromkeys(each["ruleId"] for each in results)]
    driver = {"name": "urdf-ik", "version": __version__, "rules": rules}
    runs = [{"tool": {"driver": driver}, "results": results}]
    return json_text({"$schema": _SARIF, "version": "2.1.0", "runs": runs})


def markdown(files: Sequence[VerifiedFile]) -> str:
    """A summary: the verdict of each file, and a table of its findings."""
    parts = []
    for file in files:
        parts.append(f"#### {_cell(file.verdict())}")
        rows = [f"| {_cell(file.file)}:{line} | {kind} | {_cell(words)} |" for line, kind, words in file.findings()]
        if rows:
            parts.append("\n".join(["| line | kind | difference |", "|---|---|---|", *rows]))
        if isinstance(file.result, Verification) and file.result.notes:
            parts.append("\n".join(f"- {_cell(note)}" for note in file.result.notes))
    return "\n\n".join(parts) + "\n"


def _places(file: str) -> list[tuple[re.Pattern[str], int]]:
    """Names of joints and links in a URDF, xacro or MJCF as patterns, with their lines; joints first."""
    try:
        text = Path(file).read_text("utf-8", "replace")
    except OSError:  # a name of the catalogue
        return []
    text = re.sub("<!--.*?-->", lambda comment: "\n" * comment[0].count("\n"), text, flags=re.DOTALL)
    found = sorted(_NAMED.finditer(text), key=lambda each: each[1] != "joint")
    # An expression of a xacro may become any text.
    names = (".+".join(map(re.escape, re.split(r"\$\{.*?\}", each[2]))) for each in found)
    return [(re.compile(name), text.count("\n", 0, each.start()) + 1) for name, each in zip(names, found, strict=True)]


def _line(places: list[tuple[re.Pattern[str], int]], names: str, default: int) -> int:
    """The line of the first joint or link of a list with commas; the default where the file has none of them."""
    lines = (line for name in names.split(", ") for pattern, line in places if pattern.fullmatch(name))
    return next(lines, default)


def _command(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _cell(text: str) -> str:
    return escape(text, quote=False).replace("|", "\\|").replace("\n", " ")
