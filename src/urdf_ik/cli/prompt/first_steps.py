"""The first steps, which ``urdf-ik`` prints without a command."""

from __future__ import annotations

from pathlib import Path

from urdf_ik.version import __version__

_WIDTH = 30
_STEPS = (
    ("ik zyyzyz_6r", "all solutions of a bundled arm, verified"),
    ("robots", "arms that have names"),
    ("info {file}", "how your arm is built and solved"),
    ("ik {file}", "all solutions of an example pose of it"),
    ("ik {file} --xyz 0.4,0,0.3 --rpy 0,1.57,0", "of a pose of yours"),
    ("check {file}", "the arm against Pinocchio"),
    ("view {file}", "the arm in the browser, with a target to drag"),
    ("doctor", "what is installed, and whether it works"),
)


def steps() -> str:
    """A few commands to begin with, about a URDF of this folder where there is one.

    Example:
        >>> "urdf-ik info my_arm.urdf" in steps()
        True
    """
    here = sorted(path.name for path in Path().glob("*.urdf"))
    file = next((name for name in here if " " not in name), "my_arm.urdf")
    commands = [(f"urdf-ik {command.format(file=file)}", what) for command, what in _STEPS]
    width = min(max(len(command) for command, _ in commands), _WIDTH)
    lines = [f"  {command:<{width}}  {what}" for command, what in commands]
    head = f"urdf-ik {__version__}: every inverse-kinematics solution of a robot arm, from its URDF"
    return "\n".join([head, "", *lines, "", "urdf-ik --help lists every command, urdf-ik COMMAND --help its options."])
