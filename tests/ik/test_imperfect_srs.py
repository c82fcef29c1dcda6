"""Seven joints that are a little off S-R-S, next to a fold at their redundancy parameter."""

import numpy as np
from lxml import etree

import urdf_ik
from urdf_ik.model import catalogue


def off_by_microns() -> urdf_ik.Arm:
    """The bundled S-R-S arm with origins some 30 um and 20 urad off, as rounded numbers of a URDF leave them."""
    robot = etree.fromstring(catalogue.resolve("srs_7r").path.read_bytes())
    for k, origin in enumerate(robot.iterfind("joint/origin")):
        xyz, rpy = ([float(each) for each in origin.get(name, "0 0 0").split()] for name in ("xyz", "rpy"))
        xyz[0] += 3e-5 * (-1) ** k
        xyz[1] += 2e-5
        rpy[0] += 2e-5 * (-1) ** (k // 2)
        origin.set("xyz", " ".join(map(repr, xyz)))
        origin.set("rpy", " ".join(map(repr, rpy)))
    return urdf_ik.load(etree.tostring(robot).decode())


def test_srs_off_by_microns_with_its_elbow_stretched_is_found_to_rounding() -> None:
    """At 1.3e-4 rad from the stretched elbow an error of 5e-11 is a joint 1e-6 rad off: solutions are converged."""
    arm = off_by_microns()
    q = np.array(
        [0.008108485723217207, 2.6359487799176167, -2.864916163393957, 0.00013238129142860607, 0.5637046004657775,
         2.152053680999405, 1.8425788317198197]
    )  # fmt: skip
    found = arm.ik(arm.fk(q), redundancy=arm.redundancy_of(q)).to_array()
    assert np.abs(np.angle(np.exp(1j * (found - q)))).max(axis=1).min() < 2e-7
