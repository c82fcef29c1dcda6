"""Waypoint files: every documented form is read as the same poses, and what is wrong is named with its place."""

import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import urdf_ik
from urdf_ik import ArgumentError

pin.seed(4)
SE3 = [pin.SE3.Random() for _ in range(5)]
T = np.array([each.homogeneous for each in SE3])
XYZ = T[:, :3, 3]
QUAT = np.array([pin.SE3ToXYZQUAT(each)[[6, 3, 4, 5]] for each in SE3])
RPY = np.array([pin.rpy.matrixToRpy(each.rotation) for each in SE3])
ROTVEC = np.array([pin.log3(each.rotation) for each in SE3])


def table(header: str, *columns: np.ndarray, mark: str = ",") -> bytes:
    """A CSV."""
    rows = [mark.join(map(repr, row)) for row in np.hstack(columns).tolist()]
    return "\n".join([header, *rows, ""]).encode()


def numpy_file(**arrays: np.ndarray) -> bytes:
    """An .npz, or an .npy of the array ``alone``."""
    out = io.BytesIO()
    if "alone" in arrays:
        np.save(out, arrays["alone"])
    else:
        np.savez(out, **arrays)
    return out.getvalue()


FORMS: dict[str, Callable[[], bytes]] = {
    "scalar first": lambda: table("x,y,z,qw,qx,qy,qz", XYZ, QUAT),
    "scalar last": lambda: table("x,y,z,qx,qy,qz,qw", XYZ, QUAT[:, [1, 2, 3, 0]]),
    "other order, capitals, more columns": lambda: table("i,QW,QX,QY,QZ,X,Y,Z", XYZ[:, :1], QUAT, XYZ),
    "roll, pitch, yaw": lambda: table("x,y,z,roll,pitch,yaw", XYZ, RPY),
    "axis times angle": lambda: table("x;y;z;rx;ry;rz", XYZ, ROTVEC, mark=";"),
    "tabs, byte order mark": lambda: b"\xef\xbb\xbf" + table("x\ty\tz\tqw\tqx\tqy\tqz", XYZ, QUAT, mark="\t"),
    "comments, blank lines": lambda: b"# a seam\n\n" + table("x y z roll pitch yaw", XYZ, RPY, mark=" ") + b"\n# end\n",
    "matrices row by row": lambda: table("", T.reshape(-1, 16)),
    "json list": lambda: json.dumps(T.tolist()).encode(),
    "json object": lambda: json.dumps({"name": "seam", "waypoints": T.tolist()}).encode(),
    "json objects": lambda: json.dumps({"poses": [{"q": [1], "pose": each.tolist()} for each in T]}).encode(),
    "npy": lambda: numpy_file(alone=T),
    "npz": lambda: numpy_file(poses=T, q=XYZ),
    "npz, the only array": lambda: numpy_file(seam=T),
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_is_read_as_the_same_poses(form: str, tmp_path: Path) -> None:
    """Pinocchio's poses come back from a path and from an open file, whatever the file is called."""
    file = tmp_path / "seam.data"
    file.write_bytes(FORMS[form]())
    with file.open("rb") as opened:
        for source in (file, str(file), opened):
            np.testing.assert_allclose(urdf_ik.read_waypoints(source), T, rtol=0.0, atol=1e-12)


def test_angles_of_a_csv_may_be_degrees() -> None:
    """Roll, pitch and yaw are rad unless degrees are asked for; quaternions have no unit."""
    data = table("x,y,z,roll,pitch,yaw", XYZ, np.rad2deg(RPY))
    np.testing.assert_allclose(urdf_ik.read_waypoints(io.BytesIO(data), degrees=True), T, rtol=0.0, atol=1e-12)
    data = table("x,y,z,qw,qx,qy,qz", XYZ, QUAT)
    np.testing.assert_allclose(urdf_ik.read_waypoints(io.BytesIO(data), degrees=True), T, rtol=0.0, atol=1e-12)


GOOD = "0,0,0,1,0,0,0\n"
HEADER = "x,y,z,qw,qx,qy,qz\n"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", ("is empty", "accepted: CSV")),
        (HEADER, ("line 1", "no waypoint after it")),
        (GOOD, ("line 1", "7 numbers and no header", "x,y,z,qw,qx,qy,qz")),
        ("x,y,qw,qx,qy,qz\n" + GOOD, ("line 1", "no column z")),
        ("x,y,z\n1,2,3\n", ("line 1", "no orientation", "roll,pitch,yaw")),
        ("x,y,z,x,roll,pitch,yaw\n" + GOOD, ("line 1", "names x twice")),
        ("x,y,z,qw,qx,qy,qz,rx,ry,rz\n" + GOOD, ("line 1", "more than one orientation")),
        ("# seam\n" + HEADER + GOOD + "0,0,0,1,0,east,0\n", ("line 4", "column qy", "'east'")),
        (HEADER + GOOD + "0,nan,0,1,0,0,0\n", ("line 3", "column y", "'nan'")),
        (HEADER + GOOD + "0,0,0,1,0,0\n", ("line 3", "6 values", "7 are needed")),
        (HEADER + GOOD + "0,0,0,0,0,0,0\n", ("line 3", "the length 0")),
        (HEADER + GOOD + "0.5,0.4,0.3,10,0,0,0\n", ("line 3", "qw,qx,qy,qz = 10,0,0,0", "the length 10")),
        (",".join(["1"] * 16), ("line 1", "last row")),
        ('{"targets": []}', ("targets", "poses or waypoints")),
        (json.dumps([np.eye(4).tolist(), "up"]), ("waypoint 1", '"up"', "4x4")),
        (json.dumps([np.eye(4).tolist(), np.diag([1, 1, -1, 1]).tolist()]), ("[1]", "reflection")),
        (numpy_file(a=T, b=T), ("a, b", "poses or waypoints or T")),
        (numpy_file(alone=XYZ), ("shape (5, 3)", "matrices (m, 4, 4)")),
        (json.dumps([np.eye(4).tolist(), [["0"] * 4] * 4]), ("waypoint 1", '"0" is no number')),
    ],
)
def test_errors_name_the_place_in_the_file(content: str | bytes, words: tuple[str, ...], tmp_path: Path) -> None:
    """Every message begins with the file, and names the line, the column, the value, or what would be valid."""
    file = tmp_path / "seam.csv"
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(ArgumentError) as caught:
        urdf_ik.read_waypoints(file)
    message = str(caught.value)
    assert message.startswith(str(file))
    assert all(word in message for word in words), message


def test_a_file_that_is_not_there() -> None:
    """The system's own words, and the name."""
    with pytest.raises(ArgumentError, match=r"cannot read no/seam\.csv: No such file"):
        urdf_ik.read_waypoints("no/seam.csv")
