"""The commands ``robots`` and ``doctor``: what is here, and whether it works."""

from __future__ import annotations

import platform
import re
import sys
import time
from dataclasses import asdict, dataclass
from importlib import import_module, metadata
from typing import Annotated, Any

import numpy as np
import typer
from typer import Argument, Option

from urdf_ik.cell import missing_pinocchio
from urdf_ik.cli import console, options, tables
from urdf_ik.cli.console import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.errors import ChainError, UrdfIkError
from urdf_ik.model import catalogue, downloads
from urdf_ik.support import extras
from urdf_ik.version import __version__

_WIDTH, _LEAST_WORDS = 79, 12
_SHORT = {"example-robot-data": "robot-data", "robot_descriptions": "descriptions"}
NEEDED = ("numpy", "pin", "coal", "yourdfpy", "lxml", "trimesh", "scipy")
_CHECKING = ("pin", "coal")
"""What only checks need; solving and drawing do without."""
_ARMS = ("zyyzyz_6r", "scara_rrpr", "stanford_rrprrr", "srs_7r")
_POSES = 50
_EXACT = 1e-9


@dataclass(frozen=True)
class Robot:
    """An arm that has a name.

    Attributes:
        name: argument of ``load``.
        source: 'bundled', 'example-robot-data' or 'robot_descriptions'.
        here: whether it can be loaded without a download or an installation.
        joints: number of its joints; its package's number where it is not here; None if unknown.
        family: how it is solved, '' where it is not here or no solver takes it.
        note: its description, or why it is not solved.
    """

    name: str
    source: str
    here: bool
    joints: int | None
    family: str
    note: str


def robots(
    *,
    word: Annotated[str, Argument(metavar="[WORD]", help="Only names that contain this.")] = "",
    everything: Annotated[
        bool, Option("--all", help="Also the arms of robot_descriptions that are not downloaded.")
    ] = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """List the arms that have names, with the family and the joints of those that are here.

    There are bundled arms, those of example-robot-data, and those of robot_descriptions, which downloads a model at its
    first use.

    Examples:
        urdf-ik robots
        urdf-ik robots ur --all
    """
    more = [name for name in downloads.names() if everything or downloads.is_here(name)]
    found = [_robot(name) for name in (*catalogue.names(), *more) if word in name]
    console.emit({"robots": [asdict(robot) for robot in found]}, lambda: _table(found), printed_as)


def _table(robots: list[Robot]) -> str:
    """A table, and how to get more."""
    header = ["name", "joints", "family", "here", "from"]
    sources = [_SHORT.get(robot.source, robot.source) for robot in robots]
    taken = sum(max(map(len, column)) for column in ([*(robot.name for robot in robots), ""], [*sources, ""])) + 18
    words = max(_WIDTH - taken, _LEAST_WORDS)
    rows = []
    for robot, source in zip(robots, sources, strict=True):
        what = robot.family or robot.note
        short = what if len(what) <= words else f"{what[: words - 3]}..."
        joints = "-" if robot.joints is None else robot.joints
        rows.append([robot.name, joints, short, "yes" if robot.here else "no", source])
    table = tables.grid(header, rows, left=["name", "family", "from"])
    more = len(downloads.names())
    rest = f"robot_descriptions has {more} arms: --all lists them" if more else f"more: {extras.command('robots')}"
    return tables.render(*([table] if rows else ["no robot has such a name"]), "", rest)


def _robot(name: str) -> Robot:
    here = catalogue.is_here(name)
    source = "bundled" if name in catalogue.BUNDLED else "example-robot-data"
    if name not in catalogue.names():
        source = "robot_descriptions"
    note = catalogue.BUNDLED.get(name, "") or (downloads.describe(name) if source == "robot_descriptions" else "")
    if not here:
        joints = downloads.joints_of(name) if source == "robot_descriptions" else None
        return Robot(name, source, False, joints, "", note)
    from urdf_ik.arm import load

    try:
        arm = load(name)
    except ChainError:
        return Robot(name, source, True, None, "", "several chains: urdf-ik info --chains")
    except UrdfIkError as error:
        return Robot(name, source, True, None, "", str(error))
    return Robot(name, source, True, arm.dof, arm.structure.family, note)


def doctor(*, printed_as: options.TextFormat = ReportFormat.TABLE) -> None:
    """Say what is installed and whether it works.

    It prints versions, the processor's instruction set and optional packages, and tests the solvers against
    Pinocchio. The status is 1 when the test fails.

    Examples:
        urdf-ik doctor
        urdf-ik doctor --format json
    """
    found = examine()
    console.emit(found, lambda: _findings(found), printed_as)
    if not found["passed"]:
        raise typer.Exit(Status.FAILED)


def examine() -> dict[str, Any]:
    """Look at the installation, and test the solvers.

    ``versions`` are of this package, Python and the required packages, ``extras`` of each extra's packages, '' for a
    missing one. ``loading`` are the seconds that imports took, which the first command of all waits for, ``seconds``
    those of the tests after that.
    """
    from urdf_ik import _core

    versions = {"urdf-ik": __version__, "python": platform.python_version()}
    versions |= {name: _version(name) for name in NEEDED}
    begun = time.perf_counter()
    checks = ("urdf_ik.cell.pinocchio_reference",) if missing_pinocchio.installed() else ()
    for package in (*checks, "urdf_ik.arm", "yourdfpy"):
        import_module(package)
    loaded = time.perf_counter()
    tests = [_test(name) for name in _ARMS]
    needed = all(version for name, version in versions.items() if name not in _CHECKING)
    return {
        "versions": versions,
        "machine": f"{platform.system()} {platform.machine()}",
        "instruction_sets": {"used": _core.isa(), "built": tuple(_core.levels())},
        "extras": {extra: {name: _version(name) for name in _packages(extra)} for extra in extras.for_users()},
        "tests": tests,
        "loading": loaded - begun,
        "seconds": time.perf_counter() - loaded,
        "passed": needed and all(_passed(test) for test in tests),
        "executable": sys.executable,
    }


def _passed(test: dict[str, Any]) -> bool:
    """Whether nothing was missed and nothing is off."""
    return not test["missed"] and (test["error"] is None or test["error"] <= _EXACT)


def _findings(found: dict[str, Any]) -> str:
    """Lines and a table."""
    sets = found["instruction_sets"]
    facts = [(name, version or "missing") for name, version in found["versions"].items()]
    facts.append(("machine", f"{found['machine']}, instruction set {sets['used']} of {', '.join(sets['built'])}"))
    optional = []
    for extra, packages in found["extras"].items():
        here = ", ".join(f"{name} {version}" for name, version in packages.items() if version)
        missing = ", ".join(name for name, version in packages.items() if not version)
        words = [here] if here else []
        words += [f"without {missing}: {extras.command(extra)}"] if missing else []
        optional.append((extra, "; ".join(words)))
    rows = []
    for test in found["tests"]:
        error = "-" if test["error"] is None else f"{test['error']:.1e}"
        counts = [test[name] for name in ("arm", "poses", "solutions", "missed")]
        rows.append([*counts, error, "yes" if _passed(test) else "FAIL"])
    table = tables.grid(["arm", "poses", "solutions", "missed", "error [m, rad]", "passed"], rows, left=["arm"])
    verdict = "all is well" if found["passed"] else "something is wrong: see above"
    if found["passed"] and not missing_pinocchio.installed():
        verdict = f"solving works; errors and contacts were not checked: {missing_pinocchio.UNCHECKED}"
    times = f"loading the packages took {found['loading']:.1f} s, the test {found['seconds']:.1f} s"
    return tables.render(
        *tables.facts(facts, 14), "", *tables.facts(optional, 14), "", table, "", f"{verdict}; {times}"
    )


def _test(name: str) -> dict[str, Any]:
    """Solve poses of random joint vectors, look for these among the answers, and have Pinocchio measure all.

    ``missed`` counts the poses whose own joint vector was not among them, up to whole turns; ``error`` is the largest
    one as Pinocchio measures it [m or rad], None where it is not installed.
    """
    from urdf_ik.arm import load
    from urdf_ik.ik.solutions import limits
    from urdf_ik.support import angles

    arm = load(name)
    turning = ~np.asarray(arm.chain.prismatic)
    pinocchio = arm.cell.reference if missing_pinocchio.installed() else None
    low, high = limits.drawn(arm.limits, turning).T
    Q = np.random.default_rng(0).uniform(low, high, (_POSES, arm.dof))
    T = arm.fk(Q) if pinocchio is None else pinocchio.pose(Q)
    answer = arm.ik(T, redundancy=None if arm.redundancy is None else arm.redundancy_of(Q))
    off = answer.q - Q[:, None]
    off = np.where(turning, angles.wrapped(off), off)
    near = np.abs(np.where(answer.valid[..., None], off, np.inf)).max(axis=-1).min(axis=-1)
    error = None
    if pinocchio is not None:
        position, rotation = pinocchio.errors(answer.q, T[:, None])
        error = float(np.where(answer.valid, np.maximum(position, rotation), 0.0).max())
    counts = {"poses": _POSES, "solutions": int(answer.valid.sum()), "missed": int((near > 1e-6).sum())}
    return {"arm": name, **counts, "error": error}


def _packages(extra: str) -> list[str]:
    return [re.split(r"[\[<>=~!]", requirement)[0] for requirement in extras.requirements(extra)]


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""
