"""The urdf-ik command as the tests run it, and the pose that they ask for."""

import json
import subprocess
import sys
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from oracle import Oracle
from typer.testing import CliRunner, Result

from urdf_ik.cli import app
from urdf_ik.model import catalogue

Array = NDArray[np.float64]
ARM = "zyyzyz_6r"
Q = (0.3, -0.5, 0.8, 0.4, 0.7, -0.2)
TYPED = ",".join(map(str, Q))
# Two joints about one axis: redundant everywhere, so no solver takes the arm.
TWO_JOINTS = """<robot name="planar"><link name="a"/><link name="b"/><link name="c"/>
<joint name="one" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
<joint name="two" type="continuous"><parent link="b"/><child link="c"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint>
</robot>"""


def call(*args: str, given: str | bytes | None = None, **env: str) -> Result:
    """Run the command in this process; any exception other than SystemExit is passed on."""
    result = CliRunner().invoke(app, list(args), input=given, env={"COLUMNS": "100", **env}, catch_exceptions=False)
    assert "Traceback" not in result.output
    return result


def succeed(*args: str, given: str | bytes | None = None, **env: str) -> str:
    """Standard output of a run that must end with status 0; standard error may only hold progress."""
    result = call(*args, given=given, **env)
    assert result.exit_code == 0, result.output
    assert "rror" not in result.stderr
    return result.stdout


def start(*args: str, first: str = "", **options: Any) -> subprocess.Popen[bytes]:
    """Start the command as a program of its own, which runs ``first`` before."""
    program = f"{first}\nfrom urdf_ik.cli import main; main()"
    command = [sys.executable, "-X", "faulthandler", "-c", program, *args]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)


def strict_json(text: str) -> Any:
    """Parse JSON, and refuse the NaN and Infinity that Python would take."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


@lru_cache
def oracle(name: str = ARM) -> Oracle:
    """Pinocchio's model of a bundled arm."""
    return Oracle(catalogue.resolve(name).path, "base_link", "tool0")


def target() -> Array:
    """The pose (4, 4) of ``Q`` by Pinocchio."""
    return oracle().pose(np.array(Q))


def vectors(text: str) -> Array:
    """Joint vectors (k, n) of the solutions of the first pose in JSON."""
    return np.array([one["q"] for one in strict_json(text)["poses"][0]["solutions"]])


def comma(values: Sequence[float] | Array) -> str:
    """Numbers as they are typed."""
    return ",".join(repr(float(x)) for x in values)


def cell(file: Path, shape: str, at: Sequence[float] | Array = (0.0, 0.0, 0.0)) -> str:
    """Write the URDF of a cell whose one link, the post, is a shape; its name as it is typed."""
    place = " ".join(map(str, at))
    collision = f'<collision><origin xyz="{place}"/><geometry><{shape}/></geometry></collision>'
    file.write_text(f'<robot name="cell"><link name="post">{collision}</link></robot>')
    return str(file)
