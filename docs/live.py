"""The picture of the first page: an arm to drag where `make wasm page` built its parts, else a drawing.

Run by hand, `python docs/live.py FOLDER` writes it there.
"""

import sys
from pathlib import Path

import urdf_ik
from urdf_ik.errors import MissingPackage
from urdf_ik.export import html

ARM = "zyyzyz_6r"
LIVE = """```{raw} html
<iframe src="arm.html" title="An arm to drag" width="100%" height="520" style="border:0"></iframe>
```

Drag the target: each solution is a ghost with a name. `urdf-ik export zyyzyz_6r --html arm.html` writes this
[page](how-to/cpp.md#a-page-that-needs-no-server), which needs no server.
"""
DRAWN = """![All branches of an arm in one pose](_generated/branches.png)

`urdf_ik.show.plot.branches(solutions, shapes=True)` draws the picture each time these pages are built.
"""


def write(folder: Path) -> None:
    """Write `first.md`, which the first page includes, and the page with the arm into `live/` beside it."""
    place = folder / "live"
    place.mkdir(parents=True, exist_ok=True)
    try:
        (place / "arm.html").write_text(html(urdf_ik.load(ARM)), encoding="utf-8")
        text = LIVE
    except MissingPackage:
        text = DRAWN
    (folder / "first.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
