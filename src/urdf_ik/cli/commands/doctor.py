"""Say what is installed and whether it works.

It prints versions, the processor's instruction set and optional packages, and tests the solvers against Pinocchio. The
status is 1 when the test fails.

Examples:
    urdf-ik doctor
    urdf-ik doctor --format json
"""

from __future__ import annotations

import platform
import sys
import textwrap
import time
from dataclasses import asdict, dataclass
from importlib import import_module, metadata

import numpy as np
import typer

from urdf_ik.cell import missing_pinocchio as without_pinocchio
from urdf_ik.cli import console, options, tables
from urdf_ik.cli.errors import Status
from urdf_ik.cli.options import ReportFormat
from urdf_ik.version import __version__

NEEDED = ("numpy", "pin", "coal", "yourdfpy", "lxml", "trimesh", "scipy")
OPTIONAL = {
    "plot": ("matplotlib",),
    "viewer": ("viser",),
    "robots": ("example-robot-data", "robot_descriptions", "xacro"),
    "xacro": ("xacro",),
    "mjcf": ("mujoco",),
    "tables": ("pandas", "xarray"),
    "interop": ("pin-pink", "daqp", "rerun-sdk"),
    "notebooks": ("ipykernel", "ipywidgets", "nbconvert"),
    "proof": ("python-flint",),
    "torch": ("torch",),
    "jax": ("jax",),
    "scale": ("dask", "distributed", "zarr", "xarray"),
    "timing": ("toppra",),
}
_CHECKING = ("pin", "coal")
"""What only checks need; solving and drawing do without."""
_ARMS = ("zyyzyz_6r", "scara_rrpr", "stanford_rrprrr", "srs_7r")
_POSES = 50
_EXACT = 1e-9


def command(*, printed_as: options.TextFormat = ReportFormat.TABLE) -> None:
    """Print the findings."""
    found = examine()
    write = as_json if printed_as is ReportFormat.JSON else as_text
    console.write(write(found), None)
    if not found.passed:
        raise typer.Exit(Status.FAILED)


@dataclass(frozen=True)
class Test:
    """One arm, solved and measured.

    Attributes:
        arm: its name.
        poses: number of poses, each the tip's at a random joint vector.
        solutions: number of solutions.
        missed: poses whose own joint vector was not among them, up to whole turns.
        error: largest error of a solution as Pinocchio measures it [m or rad]; None where it is not installed.
    """

    arm: str
    poses: int
    solutions: int
    missed: int
    error: float | None

    @property
    def passed(self) -> bool:
        """Whether nothing was missed and nothing is off."""
        return not self.missed and (self.error is None or self.error <= _EXACT)


@dataclass(frozen=True)
class Findings:
    """All that was found.

    Attributes:
        versions: of this package, Python and the required packages; '' for a missing one.
        machine: processor and system.
        instruction_sets: the one that is used, and those that this build has.
        extras: versions of each extra's packages; '' for a missing one.
        tests: the solvers against Pinocchio.
        loading: seconds that the packages took to be imported, which the first command of all waits for.
        seconds: time that the tests took after that [s].
    """

    versions: dict[str, str]
    machine: str
    instruction_sets: tuple[str, tuple[str, ...]]
    extras: dict[str, dict[str, str]]
    tests: tuple[Test, ...]
    loading: float
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether all that solving needs is here, and every test passed."""
        needed = (version for name, version in self.versions.items() if name not in _CHECKING)
        return all(needed) and all(test.passed for test in self.tests)


def examine() -> Findings:
    """Look at the installation, and test it."""
    from urdf_ik import _core

    versions = {"urdf-ik": __version__, "python": platform.python_version()}
    versions |= {name: _version(name) for name in NEEDED}
    begun = time.perf_counter()
    checks = ("urdf_ik.cell.pinocchio_reference",) if without_pinocchio.installed() else ()
    for package in (*checks, "urdf_ik.arm", "yourdfpy"):
        import_module(package)
    loaded = time.perf_counter()
    tests = tuple(_test(name) for name in _ARMS)
    return Findings(
        versions,
        f"{platform.system()} {platform.machine()}",
        (_core.isa(), tuple(_core.levels())),
        {extra: {name: _version(name) for name in names} for extra, names in OPTIONAL.items()},
        tests,
        loaded - begun,
        time.perf_counter() - loaded,
    )


def as_text(found: Findings) -> str:
    """Lines and a table."""
    used, built = found.instruction_sets
    lines = [f"{name:<14}{version or 'missing'}" for name, version in found.versions.items()]
    lines += [f"{'machine':<14}{found.machine}, instruction set {used} of {', '.join(built)}", ""]
    for extra, packages in found.extras.items():
        here = ", ".join(f"{name} {version}" for name, version in packages.items() if version)
        missing = [name for name, version in packages.items() if not version]
        words = [here] if here else []
        words += [f"without {', '.join(missing)}: pip install 'urdf-ik[{extra}]'"] if missing else []
        lines += textwrap.wrap(f"{extra:<14}{'; '.join(words)}", 80, subsequent_indent=" " * 14, break_on_hyphens=False)
    rows = []
    for test in found.tests:
        error = "-" if test.error is None else f"{test.error:.1e}"
        rows.append([test.arm, test.poses, test.solutions, test.missed, error, "yes" if test.passed else "FAIL"])
    table = tables.grid(["arm", "poses", "solutions", "missed", "error [m, rad]", "passed"], rows, left=["arm"])
    verdict = "all is well" if found.passed else "something is wrong: see above"
    if found.passed and not without_pinocchio.installed():
        verdict = f"solving works; errors and contacts were not checked: {without_pinocchio.UNCHECKED}"
    times = f"loading the packages took {found.loading:.1f} s, the test {found.seconds:.1f} s"
    return tables.render(*lines, "", table, "", f"{verdict}; {times}")


def as_json(found: Findings) -> str:
    """The same as data."""
    used, built = found.instruction_sets
    data = {**asdict(found), "instruction_sets": {"used": used, "built": built}, "passed": found.passed}
    return console.json_text({**data, "executable": sys.executable})


def _test(name: str) -> Test:
    """Solve poses of random joint vectors, look for these among the answers, and have Pinocchio measure all."""
    from urdf_ik.arm import load
    from urdf_ik.ik.solutions import limits
    from urdf_ik.support import angles

    arm = load(name)
    turning = ~np.asarray(arm.chain.prismatic)
    pinocchio = arm.cell.reference if without_pinocchio.installed() else None
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
    return Test(name, _POSES, int(answer.valid.sum()), int((near > 1e-6).sum()), error)


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""
