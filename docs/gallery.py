"""Draws the pictures of `gallery.md`: its blocks of Python run one after the other, as a reader would type them.

Run by hand, `python docs/gallery.py FOLDER` writes them there.
"""

import contextlib
import re
import sys
from pathlib import Path

PAGE = Path(__file__).with_name("gallery.md")


def write(folder: Path) -> None:
    """Run the page's blocks in `folder`, where they save their pictures; what they print is dropped."""
    folder.mkdir(parents=True, exist_ok=True)
    names: dict[str, object] = {}
    with contextlib.chdir(folder), contextlib.redirect_stdout(None):
        for code in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL):
            exec(compile(code, str(PAGE), "exec"), names)


if __name__ == "__main__":
    write(Path(sys.argv[1]))
