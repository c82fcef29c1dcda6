"""URDF text of arms without a closed form, and of arms near a family, for tests."""

import math
from collections.abc import Sequence

import numpy as np
from arms import DescribedArm, X, Y, Z, from_screws, random_arm, rotation, serial_urdf
from numpy.typing import NDArray

Array = NDArray[np.float64]


def unstructured(seed: int) -> DescribedArm:
    """Six random lines: no two neighbours parallel or meeting."""
    rng = np.random.default_rng([seed, 66])
    axes = rng.normal(size=(6, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    points = np.cumsum(rng.uniform(-0.6, 0.6, (6, 3)), axis=0)
    return from_screws(f"random-{seed}", "no structure", axes, points, points[-1] + rng.uniform(-0.3, 0.3, 3))


def standard_dh(
    name: str, alpha: Sequence[float], a: Sequence[float], d: Sequence[float], kind: str = "standard DH"
) -> DescribedArm:
    """An arm from a standard Denavit-Hartenberg table (alpha [rad], a [m], d [m]), with frame 6 as its tip."""
    steps = (((x, 0.0, z), (twist, 0.0, 0.0)) for twist, x, z in zip(alpha, a, d, strict=True))
    origins = [((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), *steps]
    return DescribedArm(name, kind, serial_urdf(name, origins, [*[Z] * len(alpha), None]))


def manseur_doty() -> DescribedArm:
    """The arm of Manseur and Doty that reaches one pose with sixteen joint vectors."""
    quarter, one = math.radians(90.0), math.radians(1.0)
    return standard_dh("manseur_doty", [quarter, one] * 3, (0.3, 1, 0, 1.5, 0, 0), (0, 0, 0.2, 0, 0, 0))


def crx_like() -> DescribedArm:
    """Like Fanuc's CRX-10: 1 x 2, 2 || 3, 3 x 4, 4 x 5, 5 x 6, and axis 6 passes axis 4 at 0.15 m."""
    points = [(0, 0, 0.245), (0, 0, 0.245), (0, 0, 0.955), (0.3, 0, 0.955), (0.54, 0, 0.955), (0.54, -0.15, 0.955)]
    return from_screws("crx", "1x2, 2||3, 3x4, 4x5, 5x6", [Z, Y, -Y, -X, -Y, -X], points, (0.7, -0.15, 0.955))


def hc10_like() -> DescribedArm:
    """Like Yaskawa's HC10: the relations of a CRX, folded at q = 0, with other lengths and signs."""
    points = [(0, 0, 0.275), (0, 0, 0.275), (0, 0, 0.975), (0, 0, 0.475), (0, 0.162, 0.475), (0, 0.162, 0.475)]
    return from_screws("hc10", "1x2, 2||3, 3x4, 4x5, 5x6", [Z, Y, -Y, Z, -Y, Z], points, (0, 0.162, 0.345))


def jaco_like() -> DescribedArm:
    """Like Kinova's JACO: 1 x 2, 2 || 3, 4 x 5 and 5 x 6 under 60 degrees, the wrist's points 0.148 m apart."""
    sixty = math.radians(60.0)
    u4, u5 = Z, rotation(Y, sixty) @ Z
    # At q = 0 the wrist is twisted out of its plane.
    u6 = rotation(u5, 0.7) @ rotation(Y, sixty) @ u5
    p5 = np.array([0.0, -0.0098, 0.9669])
    p6 = p5 + 0.148 * u5
    points = [(0, 0, 0.2), (0, 0, 0.2755), (0, 0, 0.6855), (0, -0.0098, 0.8928), p5, p6]
    return from_screws("jaco", "1x2, 2||3, 4x5, 5x6", [-Z, Y, -Y, u4, u5, u6], np.array(points), p6 + 0.16 * u6)


def irb140_like() -> DescribedArm:
    """Like ABB's IRB 140 without its wrist: 2 || 3, 3 x 4, 4 x 5, and axis 6 passes axis 5 at 20 mm."""
    points = [(0, 0, 0.1), (0.07, 0, 0.352), (0.07, 0, 0.712), (0.2, 0, 0.712), (0.45, 0, 0.712), (0.5, 0, 0.732)]
    return from_screws("irb140", "2||3, 3x4, 4x5", [Z, Y, Y, X, Y, X], points, (0.515, 0.0, 0.732))


def tilted(arm: DescribedArm, eps: float, seed: int) -> DescribedArm:
    """The arm with every axis turned by ``eps`` [rad] and every point moved by ``eps`` times the arm's length.

    Turns and moves go across the axis, in a random direction: along it they would change nothing.
    """
    rng = np.random.default_rng([seed, *arm.name.encode()])

    def across(axis: Array) -> Array:
        v = np.cross(axis, rng.normal(size=3))
        return v / np.linalg.norm(v)

    length = float(np.linalg.norm(np.diff(arm.points, axis=0), axis=1).sum())
    axes = np.array([rotation(across(h), eps) @ h for h in arm.axes])
    points = np.array([p + eps * length * across(h) for h, p in zip(arm.axes, arm.points, strict=True)])
    tip = points[-1] + rng.uniform(-0.2, 0.2, 3)
    return from_screws(f"{arm.name}-{eps:g}", f"{arm.kind}, off by {eps:g}", axes, points, tip)


def near_member(kind: str, eps: float, seed: int) -> DescribedArm:
    """A random member of a family of ``arms.KINDS``, ``eps`` [rad, share of length] off it."""
    return tilted(random_arm(kind, seed), eps, seed)


def rounded_industrial(decimals: int = 4) -> DescribedArm:
    """A six-axis industrial arm as a vendor writes it: axes along z, quarter turns as rounded decimals."""
    quarter, half = round(math.pi / 2, decimals), round(math.pi, decimals)
    origins = [
        ((0, 0, 0.45), (0, 0, 0)),
        ((0.15, 0, 0), (-quarter, 0, 0)),
        ((0, -0.6, 0), (half, 0, 0)),
        ((0.2, 0.12, 0), (0, quarter, 0)),
        # The wrist's frames sit apart along its axes, so that these meet but for the decimals.
        ((0, 0, 0.44), (0, -quarter, 0)),
        ((-0.09, 0, 0), (0, quarter, 0)),
        ((0.02, 0, 0.09), (0, 0.2, 0)),
    ]
    return _along_z("rounded_industrial", "wrist, 2||3", origins)


def rounded_straight_wrist() -> DescribedArm:
    """A small arm with a spherical wrist on axis 4 and quarter turns as 1.5708: the lengths are the PAROL6's."""
    quarter, half = 1.5708, 3.1416
    origins = [
        ((0, 0, 0), (0, 0, 0)),
        ((0.0234207, 0, 0.1105), (-math.pi / 2, 0, 0)),
        ((0, -0.18, 0), (half, 0, -quarter)),
        ((0.0435, 0, 0), (math.pi / 2, 0, math.pi)),
        ((0, 0, -0.17635), (-quarter, 0, 0)),
        ((0, 0, 0), (quarter, 0, 0)),
        ((0, 0, 0), (0, 0, 0)),
    ]
    return _along_z("rounded_straight_wrist", "wrist, 2||3", origins)


def rounded_over_base() -> DescribedArm:
    """Three parallel axes with a wrist whose centre reaches axis 1: the lengths and decimals are the YAM's (i2rt)."""
    along_x, along_y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    origins = [
        ((-2.49777947e-7, 0, 0.068), (0, 1.5708, 3.1415963267949)),
        ((-0.0455, -0.0339, -0.02), (0, 0, -3.14159)),
        ((4.08431e-7, -0.0688, 0.264), (0, 0, -3.14159)),
        ((-0.0600003, -0.0688, -0.244999), (0, 0, 0)),
        ((-0.0405003, 0.0338995, -0.0739989), (0, 0, 0)),
        ((0.0404996, 2.39858e-7, -0.0356), (0, 0, 0)),
    ]
    axes = [(-1.0, 0.0, 0.0), along_y, along_y, along_y, along_x, (0.0, 0.0, -1.0)]
    return DescribedArm("rounded_over_base", "2||3||4, 5x6", serial_urdf("rounded_over_base", origins, axes))


def six_of_a_shifted_iiwa() -> DescribedArm:
    """The first six joints of a KUKA iiwa 14 whose shoulder and elbow are 0.44 mm off, as a URDF has them."""
    along_y, along_z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    places = [(0, 0, 0), (-0.00043624, 0, 0.36), (0, 0, 0), (0.00043624, 0, 0.42), (0, 0, 0), (0, 0, 0.4)]
    axes = [along_z, along_y, along_z, (0.0, -1.0, 0.0), along_z, along_y]
    return DescribedArm("shifted", "3x4x5, 1x2", serial_urdf("shifted", [(each, (0, 0, 0)) for each in places], axes))


def rounded_ur(decimals: int = 4) -> DescribedArm:
    """A UR5 with quarter and half turns as rounded decimals."""
    quarter, half = round(math.pi / 2, decimals), round(math.pi, decimals)
    origins = [
        ((0, 0, 0.089159), (0, 0, 0)),
        ((0, 0, 0), (quarter, 0, 0)),
        ((-0.425, 0, 0), (0, 0, 0)),
        ((-0.39225, 0, 0.10915), (0, 0, 0)),
        ((0, -0.09465, 0), (quarter, 0, 0)),
        ((0, 0.0823, 0), (quarter, half, half)),
        ((0.01, 0, 0.05), (0, 0, 0.3)),
    ]
    return _along_z("rounded_ur", "2||3||4, 1x2, 5x6", origins)


def rounded_offset_wrist() -> DescribedArm:
    """Three parallel axes, an offset wrist and quarter turns as 1.5708: the lengths are those of a Dobot ME6."""
    quarter = 1.5708
    origins = [
        ((0, 0, 0.1268), (0, 0, 0)),
        ((-0.046, 0, 0.04), (quarter, 0, -quarter)),
        ((0, 0.18906, 0.003), (0, 0, 0)),
        ((0, 0.16, 0.005), (0, 0, 0)),
        ((0, 0.067, 0.032), (-quarter, quarter, 0)),
        ((-0.047, 0, 0.034), (quarter, 0, -quarter)),
        ((0, 0, 0), (0, 0, 0)),
    ]
    return _along_z("rounded_offset_wrist", "2||3||4, 1x2, 5x6", origins)


def ur_with_right_angles(quarter: float) -> DescribedArm:
    """An arm like a UR, exact, in which a right angle is written with some digits [rad]."""
    places = ((0, 0, 0.13), (0, 0, 0), (-0.11, 0, 0), (-0.096, 0, 0.0634), (0, -0.075, 0), (0, 0.0456, 0), (0, 0, 0))
    angles = (0.0, quarter, 0.0, 0.0, quarter, -quarter, 0.0)
    origins = [(place, (angle, 0, 0)) for place, angle in zip(places, angles, strict=True)]
    return _along_z("ur_with_right_angles", "2||3||4, 1x2, 5x6", origins)


def upright_ur() -> DescribedArm:
    """A UR5e with joints about z and y, of which two frames are a quarter turn off, as a rounded decimal."""
    quarter = 1.570796
    origins = [
        ((0, 0, 0.163), (0, 0, 0)),
        ((0, 0.138, 0), (0, quarter, 0)),
        ((0, -0.131, 0.425), (0, 0, 0)),
        ((0, 0, 0.392), (0, quarter, 0)),
        ((0, 0.127, 0), (0, 0, 0)),
        ((0, 0, 0.1), (0, 0, 0)),
        ((0, 0.24, 0), (-1.570793, -1.570793, 0)),
    ]
    axes = [Z, Y, Y, Y, Z, Y]
    return DescribedArm("upright_ur", "2||3||4, 1x2, 5x6", serial_urdf("upright_ur", origins, [*axes, None]))


def calibrated_ur() -> DescribedArm:
    """A UR10e with deviations of the size that a factory calibration writes: up to 1 mm and 15 mrad."""
    origins = [
        ((0, 0, 0.18052), (0, 0, 3.8e-7)),
        ((-1.8e-7, 0, 0), (1.5701348, 0, 2.4e-6)),
        ((-0.6121786, 0, 0), (3.1413467, 3.1411518, -3.1415879)),
        ((-0.5711198, 0.00231998, 0.1742485), (3.1282792, 3.1415117, 3.1415865)),
        ((6.03e-5, -0.1197387, 1.839e-4), (1.5692604, 0, 4.5e-7)),
        ((-6.25e-5, 0.1155158, -6.13e-5), (1.5702653, 3.1415927, 3.1415921)),
        ((0.02, -0.01, 0.1), (0, 0, 0)),
    ]
    return _along_z("calibrated_ur", "2||3||4", origins)


def _along_z(name: str, kind: str, origins: Sequence[tuple[Sequence[float], Sequence[float]]]) -> DescribedArm:
    """An arm of six joints about their own z, given by the origins (xyz, rpy) of the joints and of the tool."""
    return DescribedArm(name, kind, serial_urdf(name, origins, [*[Z] * 6, None]))
