"""An arm as one HTML page that needs no server: its solvers as WebAssembly, its shapes, and a target to drag."""

import gzip
import json
from base64 import b64encode
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.arm import Arm
from urdf_ik.arm.example import example
from urdf_ik.errors import ArgumentError, MissingPackage
from urdf_ik.export.compilation import compile
from urdf_ik.support import inputs
from urdf_ik.support.palette import colours

WEB = Path(__file__).resolve().parent / "web"
"""The folder of the npm module, whose parts the page holds."""
FACES = 12_000
"""Triangles of all shapes of a page together, at most, unless it is asked for others."""
_FEWEST, _MOST = 200, 1_000_000
_GREY = (180, 180, 185)  # of a shape with a texture
_BUILT = "`make wasm page` in a checkout builds it; wheels of releases hold it"


def html(arm: Arm, *, faces: int = FACES, q: ArrayLike | None = None) -> str:
    """An HTML page on which the arm is solved and shown without a server, offline too.

    A target is dragged, a pose typed, joints and redundancy parameters moved by sliders; every solution is a ghost with
    the name of its branch. The page is one file: a browser opens it from disk, and a notebook's frame shows it.

    Args:
        arm: as :func:`urdf_ik.load` returns it.
        faces: triangles of all shapes together at most, but for 12 that a shape may keep; they are simplified.
        q: (n,) rad or m, where the arm stands first. Default: where a pose has many solutions.

    Raises:
        UnsupportedArm: the arm cannot be compiled; see :func:`urdf_ik.compile`.
        MissingPackage: this installation was built without WebAssembly or without the page's script.
        ArgumentError: faces is no integer from 200 to 1,000,000, or q is no joint vector.

    Example:
        >>> from pathlib import Path
        >>> import urdf_ik
        >>> from urdf_ik.export import html
        >>> _ = Path("arm.html").write_text(html(urdf_ik.load("zyyzyz_6r")))  # doctest: +SKIP
    """
    inputs.whole(faces, "faces", low=_FEWEST, high=_MOST)
    text = compile(arm)
    start = example(arm) if q is None else arm.chain.check(q)
    if start.ndim != 1:
        raise ArgumentError(f"q has the shape {start.shape}; one joint vector ({arm.dof},) is needed")
    parts = {
        "title": escape(f"{arm.name}: {arm.base} to {arm.tip}"),
        "style": (WEB / "page" / "page.css").read_text(),
        # In a script element "<" could end it; a JSON text holds it in words alone.
        "arm": json.dumps(json.loads(text), separators=(",", ":")).replace("<", "\\u003c"),
        "scene": _packed(json.dumps(_scene(arm, start, faces), separators=(",", ":")).encode()),
        "wasm": _packed(_built("urdf_ik.wasm")),
        "script": _built("page.bundle.js").decode(),
    }
    pieces = (WEB / "page" / "page.html").read_text().split("@@")
    return "".join(parts[piece] if k % 2 else piece for k, piece in enumerate(pieces))


def _built(name: str) -> bytes:
    try:
        return (WEB / name).read_bytes()
    except OSError:
        raise MissingPackage(f"{name} is missing in this installation of urdf-ik: {_BUILT}") from None


def _packed(data: bytes) -> str:
    return b64encode(gzip.compress(data, 9, mtime=0)).decode()


def _scene(arm: Arm, q: Any, faces: int) -> dict[str, Any]:
    """What the page draws: the tree of joints, shapes, colours of the branches, and where the arm stands."""
    chain = arm.chain
    tree = [
        {name: getattr(joint, name) for name in ("parent", "child", "prismatic", "column", "multiplier", "offset")}
        | {"origin": joint.origin.ravel().tolist(), "axis": joint.axis.tolist()}
        for joint in chain.tree
    ]
    moving: set[str] = set()
    for joint in chain.tree:
        if joint.column is not None or joint.parent in moving:
            moving.add(joint.child)
    shades = ["#" + "".join(f"{round(255 * part):02x}" for part in each) for each in colours(len(arm.solver.branches))]
    return {
        "root": chain.root,
        "base": chain.base,
        "tree": tree,
        "moving": sorted(moving),
        "bodies": bodies(arm, faces),
        "colours": shades,
        "size": chain.size,
        "start": np.asarray(q).tolist(),
    }


def bodies(arm: Arm, faces: int) -> list[dict[str, Any]]:
    """A mesh for each link and colour."""
    from urdf_ik.model import link_shapes

    parts: dict[tuple[str, tuple[int, ...]], list[Any]] = {}
    for link, shape in link_shapes.read(arm.model)[0]:
        rgba = getattr(shape.visual, "main_color", _GREY)
        parts.setdefault((link, tuple(int(each) for each in rgba[:3])), []).append(shape)
    meshes = {key: link_shapes.joined(held) for key, held in parts.items()}
    total = sum(len(mesh.faces) for mesh in meshes.values())
    found = []
    for (link, colour), mesh in meshes.items():
        # Each has its share; a small one keeps what a box needs.
        share = len(mesh.faces) if total <= faces else max(faces * len(mesh.faces) // total, 12)
        small = link_shapes.simplified(mesh, share)
        found.append(
            {
                "link": link,
                "colour": [part / 255.0 for part in colour],
                "vertices": b64encode(np.asarray(small.vertices, "<f4").tobytes()).decode(),
                "faces": b64encode(np.asarray(small.faces, "<u4").tobytes()).decode(),
            }
        )
    return found
