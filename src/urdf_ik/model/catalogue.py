"""The catalogue of robot names: URDFs of this package, of example-robot-data and of robot_descriptions."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from urdf_ik.errors import ArgumentError
from urdf_ik.model import downloads
from urdf_ik.support import extras
from urdf_ik.support.text import nearest
from urdf_ik.version import __version__

BUNDLED: Mapping[str, str] = {
    "zyyzyz_6r": "six axes z y y z y z with a spherical wrist, upright at zero",
    "dh_6r": "six axes with a spherical wrist, from a modified Denavit-Hartenberg table",
    "planar_2r": "two-link planar arm, 66 and 130 mm, with narrow limits",
    "planar_2r_unit": "two-link planar arm, both links 1 m, every angle allowed",
    "positioning_3r": "waist, shoulder and elbow of an articulated robot",
    "scara_rrpr": "SCARA: two links, a quill that slides and turns",
    "stanford_rrprrr": "Stanford arm: waist, shoulder, sliding boom, spherical wrist",
    "srs_7r": "seven axes, spherical shoulder and wrist, with the lengths of a KUKA LBR iiwa 14",
    "puma_560": "Unimation PUMA 560, by Corke and Armstrong-Helouvry's table",
    "rail_6r": "the PUMA 560 on a rail: seven joints, of which the rail is what a pose leaves free",
    "positioner_6r": "the PUMA 560 with a torch, and a two-axis positioner that carries the link 'workpiece'",
    "dual_6r": "two PUMA 560 on one pedestal, to left_tool0 and to right_tool0",
}
"""Arms that come with this package: what they are."""

_TIPS = {"dual_6r": "left_tool0"}
"""Tips of those that are not from base_link to tool0."""

_UR = ("world", "tool0")

EXAMPLE_ROBOT_DATA: Mapping[str, tuple[str, str, str]] = {
    # The package's own ur3.urdf is a robot without links; ur3_robot.urdf is the arm.
    "ur3": ("ur_description/urdf/ur3_robot.urdf", *_UR),
    "ur3_gripper": ("ur_description/urdf/ur3_gripper.urdf", *_UR),
    "ur3_limited": ("ur_description/urdf/ur3_joint_limited_robot.urdf", *_UR),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", *_UR),
    "ur5_gripper": ("ur_description/urdf/ur5_gripper.urdf", *_UR),
    "ur5_limited": ("ur_description/urdf/ur5_joint_limited_robot.urdf", *_UR),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", *_UR),
    "ur10_limited": ("ur_description/urdf/ur10_joint_limited_robot.urdf", *_UR),
    "kinova": ("kinova_description/robots/kinova.urdf", "base", "j2s6s200_end_effector"),
    "panda": ("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand_tcp"),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "world", "link_eef"),
    "z1": ("z1_description/urdf/z1.urdf", "world", "gripperStator"),
    "so100": ("so_arm_description/urdf/so100.urdf", "base", "gripper"),
    "so101": ("so_arm_description/urdf/so101.urdf", "base_link", "gripper_frame_link"),
    "twodof": ("asr_twodof_description/urdf/TwoDofs.urdf", "world", "Tip"),
    "baxter_left": ("baxter_description/urdf/baxter.urdf", "torso", "left_gripper"),
    "baxter_right": ("baxter_description/urdf/baxter.urdf", "torso", "right_gripper"),
    "pr2_left": ("pr2_description/urdf/pr2.urdf", "torso_lift_link", "l_gripper_tool_frame"),
    "pr2_right": ("pr2_description/urdf/pr2.urdf", "torso_lift_link", "r_gripper_tool_frame"),
    "talos_left": ("talos_data/robots/talos_reduced.urdf", "torso_2_link", "gripper_left_base_link"),
    "talos_right": ("talos_data/robots/talos_reduced.urdf", "torso_2_link", "gripper_right_base_link"),
    "tiago": ("tiago_description/robots/tiago_no_hand.urdf", "torso_lift_link", "arm_tool_link"),
    "tiago_pro_left": ("tiago_pro_description/robots/tiago_pro.urdf", "torso_lift_link", "arm_left_tool_link"),
    "tiago_pro_right": ("tiago_pro_description/robots/tiago_pro.urdf", "torso_lift_link", "arm_right_tool_link"),
}
"""Arms of example-robot-data: file below its ``robots`` folder, base link and tip link.

They are the default chain of the file, except for a name of one of several arms or tool frames.
"""

_DISTRIBUTION = "example-robot-data"
_MARKER = "share/example-robot-data/package.xml"


@dataclass(frozen=True)
class Entry:
    """An arm of the catalogue.

    Attributes:
        path: its URDF or xacro.
        base: base link of the arm; None: that of the default chain.
        tip: tip link of the arm; None: that of the default chain.
        package_dirs: folders for the ``package://`` addresses of its meshes.
        xacro_args: arguments of the xacro, None for a URDF.
    """

    path: Path
    base: str | None
    tip: str | None
    package_dirs: tuple[Path, ...] = ()
    xacro_args: Mapping[str, str] | None = None


@dataclass(frozen=True)
class Origin:
    """The source of a robot that has a name.

    Attributes:
        package: the Python package that resolves the name.
        version: its version.
        file: path of the URDF, xacro or MJCF in the package's data or in the repository.
        sha256: of the URDF's text; of a xacro or MJCF, of the URDF made from it.
        repository: address of the repository that robot_descriptions downloaded, else ''.
        commit: its commit.
    """

    package: str
    version: str
    file: str
    sha256: str
    repository: str = ""
    commit: str = ""

    def __str__(self) -> str:
        at = f" at commit {self.commit[:12]}" if self.commit else ""
        source = f"{self.repository}{at}, by " if self.repository else ""
        return f"{self.file} of {source}{self.package} {self.version} (SHA-256 {self.sha256[:12]})"


def origin_of(path: Path | None, sha256: str) -> Origin | None:
    """The origin of a file that a name means; None for other files."""
    from importlib import metadata

    if path is None:
        return None
    if path.is_relative_to(_bundled_folder()):
        return Origin("urdf-ik", __version__, path.name, sha256)
    share = _example_robot_data_share()
    if share is not None and path.is_relative_to(share):
        return Origin(_DISTRIBUTION, metadata.version(_DISTRIBUTION), path.relative_to(share).as_posix(), sha256)
    if not path.is_relative_to(downloads.cache_folder()):
        return None
    folder = next((each for each in path.parents if (each / ".git").exists()), downloads.cache_folder())
    version = metadata.version("robot_descriptions")
    asked = (("remote", "get-url", "origin"), ("rev-parse", "HEAD"))
    return Origin("robot_descriptions", version, path.relative_to(folder).as_posix(), sha256,
                  *(_git(folder, *each) for each in asked))  # fmt: skip


def _git(folder: Path, *arguments: str) -> str:
    """What git prints; '' where it fails."""
    import subprocess

    try:
        return subprocess.check_output(["git", "-C", folder, *arguments], text=True, stderr=subprocess.DEVNULL).strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def names() -> tuple[str, ...]:
    """Every name of the catalogue, bundled arms first, whether or not example-robot-data is installed.

    ``resolve`` also takes the names of robot_descriptions: :func:`urdf_ik.model.downloads.names`.
    """
    return (*BUNDLED, *EXAMPLE_ROBOT_DATA)


def is_here(name: str) -> bool:
    """Whether the arm of that name can be loaded without a download or an installation."""
    if name in BUNDLED:
        return True
    if name in EXAMPLE_ROBOT_DATA:
        share = _example_robot_data_share()
        return share is not None and _robot_file(share, name).is_file()
    return _of_example_robot_data(name) is not None or downloads.is_here(name)


def resolve(name: str) -> Entry:
    """Find the arm of that name; a model of robot_descriptions is downloaded at first use.

    Args:
        name: a bundled arm, one of example-robot-data, or a model of robot_descriptions, with or without its
            ``_description``; ``panda_description`` and the like, which robot_descriptions takes from
            example-robot-data, are the arms of that package where it is installed.

    Raises:
        ArgumentError: there is no such name (the message lists the nearest), or the name belongs to a package that
            is not installed (the message says how to install it), or to a model that cannot be downloaded.

    Example:
        >>> resolve("zyyzyz_6r").tip
        'tool0'
    """
    if name in BUNDLED:
        return Entry(_bundled_folder() / f"{name}.urdf", "base_link", _TIPS.get(name, "tool0"))
    if name in EXAMPLE_ROBOT_DATA:
        return _from_example_robot_data(name)
    if stem := _of_example_robot_data(name):
        return _from_example_robot_data(stem)
    if model := downloads.model_of(name):
        path, folders, arguments = downloads.fetch(model, _near_and_here(name))
        return Entry(path, None, None, folders, arguments)
    raise ArgumentError(f"no arm is called {name!r}; {_alternatives(name)}")


def _of_example_robot_data(name: str) -> str | None:
    """The installed arm that ``NAME_description`` means: what robot_descriptions would download is the same."""
    stem = name.removesuffix("_description")
    if stem == name or stem not in EXAMPLE_ROBOT_DATA or not is_here(stem):
        return None
    return stem if downloads.repository_of(name) in (None, _DISTRIBUTION) else None


def _from_example_robot_data(name: str) -> Entry:
    share = _example_robot_data_share()
    if share is None:
        raise ArgumentError(
            f"{name!r} is an arm of {_DISTRIBUTION}, which is not installed: {extras.command('robots')}"
        )
    path = _robot_file(share, name)
    if not path.is_file():
        missing = f"{name!r} is not in the installed {_DISTRIBUTION}, {path} is missing"
        raise ArgumentError(f"{missing}: {extras.command('robots')} --upgrade")
    return Entry(path, *EXAMPLE_ROBOT_DATA[name][1:], (share,))


def _robot_file(share: Path, name: str) -> Path:
    return share / "example-robot-data" / "robots" / EXAMPLE_ROBOT_DATA[name][0]


def _bundled_folder() -> Path:
    """The folder of the bundled URDFs: inside an installed package, at the repository's root in a checkout."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "bundled" / "urdf"
    return inside if inside.is_dir() else package.parents[1] / "urdf"


def _example_robot_data_share() -> Path | None:
    """The ``share`` folder of example-robot-data, or None where it is not installed."""
    try:
        return _found_share()
    except ImportError:
        return None


@cache  # what is found, not an error: the package may be installed later
def _found_share() -> Path:
    from importlib import metadata  # 10 ms that ``import urdf_ik`` need not pay

    for file in metadata.files(_DISTRIBUTION) or ():
        if file.as_posix().endswith(_MARKER):
            return Path(str(file.locate())).resolve().parents[1]
    raise ImportError(f"{_DISTRIBUTION} without {_MARKER}")


def _near_and_here(name: str) -> str:
    """The arms with names like that one which need no download, in words."""
    here = [each for each in names() if is_here(each)]
    found = nearest(name.lower().removesuffix("_description"), here, cutoff=0.5)
    return (
        f"near to that name and here: {', '.join(found)}" if found else "`urdf-ik robots` lists the arms that are here"
    )


def _alternatives(name: str) -> str:
    """The names nearest to one that the catalogue does not hold, or all of them where none is near."""
    known = (*names(), *downloads.names())
    more = "" if downloads.names() else f"; robot_descriptions has more: {extras.command('robots')}"
    asked = name.lower()
    wanted = (asked, asked.removesuffix("_description"))
    found = dict.fromkeys(each for one in wanted for each in nearest(one, known, n=4, cutoff=0.5))
    if found:
        return f"nearest: {', '.join(found)}{more}"
    return f"there are: {', '.join(names())}{more or ', and those that `urdf-ik robots --all` lists'}"
