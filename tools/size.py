"""The project's size beside its budgets: `python tools/size.py`; exit status 1 where one is exceeded.

Code lines hold more than a docstring, a comment or a space. Only files that git tracks are counted.
"""

from __future__ import annotations

import ast
import io
import re
import subprocess
import sys
import tokenize
from pathlib import Path

ROOT = Path(__file__).parents[1]
BUDGETS = {
    "code lines of src": 26_000, "lines of src": 42_000, "files of src": 230, "public classes": 200,
    "checks of arguments": 200, "TYPE_CHECKING blocks": 80, "lines of tests": 26_000, "pages": 36,
    "words of the pages": 26_000, "lines of benchmarks and tools": 3_600,
}  # fmt: skip
SPACE = {getattr(tokenize, name) for name in ("COMMENT", "NL", "NEWLINE", "INDENT", "DEDENT", "ENDMARKER")}


def code_lines(text: str) -> int:
    """The lines of Python source that hold code."""
    tokens = [token for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type not in SPACE]
    lines = {line for token in tokens for line in range(token.start[0], token.end[0] + 1)}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines -= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(lines)


def sizes() -> dict[str, int]:
    """Each figure by its name."""
    names = subprocess.run(["git", "-C", ROOT, "ls-files"], capture_output=True, text=True, check=True).stdout
    named = [name for name in names.splitlines() if re.search(r"\.(py|md)$", name) and (ROOT / name).is_file()]
    texts = {name: (ROOT / name).read_text() for name in named}

    def under(folders: str, suffix: str = ".py") -> list[str]:
        return [text for name, text in texts.items() if re.match(folders, name) and name.endswith(suffix)]

    def count(pattern: str, folders: str = "src/", suffix: str = ".py") -> int:
        return sum(len(re.findall(pattern, text, re.MULTILINE)) for text in under(folders, suffix))

    figures = (
        sum(map(code_lines, under("src/"))), count("\n"), len(under("src/")), count("^class [A-Z]"),
        count(r"\binputs\.|\bquoted\(|\bprintable\("), count("^ *if TYPE_CHECKING:"), count("\n", "tests/"),
        len(under("docs/", ".md")), count(r"\S+", "docs/", ".md"), count("\n", "benchmarks/|tools/"),
    )  # fmt: skip
    return dict(zip(BUDGETS, figures, strict=True))


if __name__ == "__main__":
    for name, figure in sizes().items():
        print(f"{figure:>7,} of {BUDGETS[name]:>7,}  {name}{'  OVER' if figure > BUDGETS[name] else ''}")
    sys.exit(any(figure > BUDGETS[name] for name, figure in sizes().items()))
