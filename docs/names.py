"""The pages of the reference: a directive for every public name.

Run by hand, `python docs/names.py FOLDER` writes them there.
"""

import importlib
import inspect
import re
import sys
from pathlib import Path
from types import ModuleType

import urdf_ik

# Names of `urdf_ik` itself by page. Errors have a page of their own; names without a page go to "Other names".
PAGES = {
    "arm": ("Loading, and the arm", ("load", "Arm", "Chain", "Structure")),
    "solutions": ("Solutions", ("IKSolutions", "Solution", "Singular")),
    "poses": ("Poses", ("pose",)),
    "worlds": (
        "Worlds and shapes",
        ("World", "Box", "Sphere", "Cylinder", "Capsule", "HalfSpace", "Mesh", "Points"),
    ),
    "paths": ("Paths", ("line", "arc", "polyline", "read_waypoints", "Plan")),
    "redundancy": ("Redundancy", ("Interval", "Intervals", "Region")),
    "tables": (
        "Tables and comparisons",
        ("DHTable", "compare", "compare_many", "Comparison", "freeze", "Lock", "compile"),
    ),
    "calibrations": ("Calibration", ("calibrate", "Calibration")),
}
ROOMS = {
    "calibration": "Measurements and vendors' calibrations",
    "kinematics.derivatives": "A chain by the numbers of its URDF",
    "show.plot": "Pictures",
    "show.viewer": "The viewer",
    "interop": "Other programs",
    "maps.workspaces": "Workspaces",
    "maps.placements": "Base positions",
    "export": "Outside Python",
    "verify.baselines": "Lock files",
    "verify.comparison": "Arms compared",
    "verify.judging": "Other solvers judged",
    "maps.cluster": "Workers",
    "maps.store": "Stores",
    "verify.crosscheck": "The cross-check against Pinocchio",
    "verify.completeness": "The second solver",
    "verify.proof": "Proofs checked",
    "verify.testing": "Tests of your own",
    "model.catalogue": "Names of arms",
    "model.urdf": "Reading a URDF",
    "arm.loading": "Compiled arms, positioners",
    "cell.cell": "The cell of an arm",
    "cell.collision_model": "Collision models",
    "cell.pinocchio_reference": "Pinocchio's own model of the file",
    "paths.planning": "Settings of a path",
    "paths.target_tracker": "The tracker",
    "ik.solver": "The solver of an arm",
    "ik.nearest": "The nearest solution",
    "ik.redundancy.interval_search": "Search of intervals",
    "ik.redundancy.values": "Values of redundancy parameters",
    "kinematics.velocity": "Velocities",
    "ik.tasks": "Tasks",
    "model.poses": "Notations of poses",
    "ik.redundancy": "Redundancy parameters",
}
INDEX = """# Reference

Every public name, from its docstring. Joint vectors are rad or m, base to tip; poses are 4x4 matrices of the tip link
in the base link [m]; `(...)` stands for any number of leading dimensions. The names of the first pages are those of
`urdf_ik` itself.

```{toctree}
:maxdepth: 1

"""


def write(folder: Path) -> None:
    """Write all pages into `folder`, which they replace."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.md"):
        old.unlink()
    pages = dict(PAGES)
    named = {name for _, names in pages.values() for name in names}
    own = [name for name in urdf_ik.__all__ if name not in named]
    errors = [name for name in own if _is_error(getattr(urdf_ik, name))]
    if others := [name for name in own if name not in errors]:
        pages["others"] = ("Other names", tuple(others))
    pages["errors"] = ("Errors", tuple(errors))
    for page, (title, names) in pages.items():
        there = [name for name in names if name in urdf_ik.__all__]
        (folder / f"{page}.md").write_text(_page(title, [_directive("urdf_ik", urdf_ik, name) for name in there]))
    for room, title in ROOMS.items():
        module = importlib.import_module(f"urdf_ik.{room}")
        names = getattr(module, "__all__", None)
        lines = [f".. automodule:: urdf_ik.{room}" + ("" if names else "\n   :members:")]
        lines += [_directive(f"urdf_ik.{room}", module, name) for name in names or ()]
        (folder / f"{_file(room)}.md").write_text(_page(title, lines))
    (folder / "index.md").write_text(INDEX + "\n".join([*pages, *map(_file, ROOMS)]) + "\n```\n")


def _file(room: str) -> str:
    return room.replace(".", "-")


def _is_error(value: object) -> bool:
    return inspect.isclass(value) and issubclass(value, urdf_ik.UrdfIkError)


def _page(title: str, directives: list[str]) -> str:
    return "\n".join([f"# {title}", "", "```{eval-rst}", *("\n\n".join(directives)).split("\n"), "```", ""])


def _directive(path: str, module: ModuleType, name: str) -> str:
    value = getattr(module, name)
    if inspect.isclass(value):
        inherited = "\n   :inherited-members:" if path == "urdf_ik" and name in ("Arm", "IKSolutions", "Plan") else ""
        bases = "\n   :show-inheritance:" if _is_error(value) else ""
        again = "\n   :no-index:" if path != "urdf_ik" and getattr(urdf_ik, name, None) is value else ""
        return f".. autoclass:: {path}.{name}\n   :members:{inherited}{bases}{again}"
    if callable(value):
        return f".. autofunction:: {path}.{name}"
    return f".. autodata:: {_home(module, name)}.{name}\n   :no-value:"


def _home(module: ModuleType, name: str) -> str:
    """The module in which a constant stands, with its docstring below it."""
    assert module.__file__ is not None
    file = Path(module.__file__)
    for each in sorted(file.parent.glob("*.py")) if file.stem == "__init__" else [file]:
        if re.search(rf"^{name}(:.*)? = ", each.read_text(), re.MULTILINE):
            return module.__name__ if each.stem in ("__init__", file.stem) else f"{module.__name__}.{each.stem}"
    return module.__name__


if __name__ == "__main__":
    write(Path(sys.argv[1]))
