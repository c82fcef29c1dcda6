"""Configurations as controllers name them, and the OPW parameters of industrial arms.

They exist for six turning joints with a spherical wrist whose axes 2 and 3 are parallel and square to axis 1, and whose
axes 3 to 6 are square to their neighbours. Three flags tell the eight solutions of such an arm apart:

- *behind*: the wrist centre is behind axis 1, seen in the plane that turns with joint 1;
- *below*: the wrist centre is behind the line through axes 2 and 3, the lower arm; it is in front where an upright arm
  bends forward;
- *flipped*: the wrist bends up (axis 5 is negative) where joint 4 is at zero, not down.

Turn numbers come from joint values, which are the URDF's: those of the vendors' own URDFs are the controller's. Rules:

- ABB (RAPID Instructions, ``confdata``; RobotComponents issues 182, 184, 185): cf1, cf4, cf6 are quarter revolutions of
  axes 1, 4 and 6, the first positive one 0 and the first negative one -1; cfx = 4 behind + 2 below + flipped.
- FANUC (R-30iB, "Configuration"; C. Strybis, "The perils of six-axis robots", 2013; ros-industrial/fanuc issue 186):
  F flipped or N, D below or U, B behind or T; turn numbers of J1, J4, J6: 0 for -179 to 179 degrees, 1 for 180 to 539.
- KUKA (KSS, "Status and Turn"): Status bit 0 behind, bit 1 not below (A3 beyond the angle of the stretched arm), bit 2
  not flipped (A5 > 0); bit i of Turn: axis i + 1 is negative.
- Staubli (VAL 3, ``config``): lefty behind or righty, enegative below or epositive, wnegative flipped or wpositive.
- Motoman (relative jobs, ``RCONF``): flip flipped (B not negative: the wrist bends up) or noflip, lower arm below or
  upper, rear behind or front; R, T and S at 180 degrees or more.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from typing import Any, NamedTuple

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.ik.families.parts.ideal import LITTLE, forward
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.dh import DHTable
from urdf_ik.kinematics.structure import analyse
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, wrapped
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

_SQUARE = 1e-2
"""Greatest cosine of axes that count as square to each other: a calibrated arm's flags are those of its nominal one."""
_DIGITS = 13
"""Decimals of parameters that are kept [m, rad]; what follows is rounding."""

Codes = NDArray[np.int64]


@dataclass(frozen=True)
class OPW:
    """Ortho-parallel arm with a spherical wrist: seven lengths, and zeros and signs of its six joints.

    M. Brandstötter, A. Angerer, M. Hofbaur, "An analytical solution of the inverse kinematics problem of industrial
    serial manipulators with an ortho-parallel basis and a spherical wrist", 2014. With t = signs * q - offsets, the arm
    at t = 0 stands upright, its wrist straight; x is to the front, y to the left.

    What lies before axis 1 counts only by its height.

    Attributes:
        a1: m, from axis 1 to axis 2, along x.
        a2: m, from axis 3 to axis 4, along x.
        b: m, of the wrist centre from axis 1, along y.
        c1: m, height of axis 2.
        c2: m, from axis 2 to axis 3.
        c3: m, from axis 3 to the wrist centre, along axis 4.
        c4: m, from the wrist centre to the tip, along axis 6.
        offsets: (6,) rad.
        signs: (6,) of 1 and -1.

    Example:
        >>> import urdf_ik
        >>> opw = urdf_ik.OPW.from_chain(urdf_ik.load("puma_560").chain)
        >>> opw.c2, opw.b, opw.signs
        (0.4318, -0.15005, (1, -1, -1, 1, -1, 1))
    """

    a1: float
    a2: float
    b: float
    c1: float
    c2: float
    c3: float
    c4: float
    offsets: tuple[float, ...]
    signs: tuple[int, ...]

    @classmethod
    def from_chain(cls, chain: Chain) -> "OPW":
        """The parameters of a chain, of any six joints of this structure.

        Raises:
            UnsupportedArm: the chain has another structure.
        """
        structure = analyse(chain) if chain.n == 6 else None
        H, P = chain.H, chain.points
        if (
            structure is None
            or not structure.is_6r
            or not structure.is_parallel(2)
            or (wrist := structure.triple(4, "meet")) is None
            or wrist.point is None
            or any(abs(H[i] @ H[i + 1]) > _SQUARE for i in (0, 2, 3, 4))
        ):
            raise UnsupportedArm(
                f"{chain.base} to {chain.tip} has no controller's configurations: only six turning joints have them, "
                "axes 2 and 3 parallel and square to axis 1, axes 4, 5 and 6 square and through one point; "
                "branches have names of their own"
            )
        W, size = wrist.point, chain.size
        z, x = forward(chain, W)
        y, a1 = np.cross(z, x), (P[1] - P[0]) @ x
        link = P[2] - P[1]
        upper = link - (link @ y) * y
        fore = H[3] if (W - P[2]) @ H[3] > 0.0 else -H[3]
        over = np.cross(y, fore)
        side = H[4] if H[4] @ y >= -1e-9 else -H[4]
        reach = chain.P.sum(axis=0) - W
        past = (P[5] - W) @ H[5]
        out = H[5] if (past if abs(past) > LITTLE * size else fore @ H[5]) > 0.0 else -H[5]

        def lean_of(v: Array) -> float:
            return math.atan2(v @ x, v @ z)

        first = math.atan2(x[1], x[0]) if abs(z[2]) > 0.5 else 0.0
        second, third = lean_of(upper), lean_of(fore)
        fourth = math.atan2(-(side @ over), side @ y)
        fifth = math.atan2(np.cross(fore, out) @ side, fore @ out)
        frame = np.stack([np.cross(side, out), side, out], axis=1)
        rest = frame.T @ chain.R_tip
        sixth = math.atan2(rest[1, 0], rest[0, 0]) if rest[2, 2] > 1.0 - 1e-6 else 0.0
        axes = (z, y, y, fore, side, out)
        zeros = wrapped(np.array([first, second, third - second, fourth, fifth, sixth]))
        elbow, length = W - P[2], float(np.linalg.norm(upper))
        lengths = [a1, elbow @ over, (W - P[0]) @ y, P[1] @ z, length, elbow @ fore, reach @ out]
        a1, a2, b, c1, c2, c3, c4 = (round(float(each), _DIGITS) + 0.0 for each in lengths)
        return cls(
            a1, a2, b, c1, c2, c3, c4,
            offsets=tuple(round(-each, _DIGITS) + 0.0 for each in zeros.tolist()),
            signs=tuple(1 if H[i] @ axis > 0.0 else -1 for i, axis in enumerate(axes)),
        )  # fmt: skip

    def to_urdf(self) -> str:
        """URDF text of such an arm from ``base_link`` to ``tool0``, its joints without limits."""
        rows = [
            [0.0, 0.0, self.c1, 0.0],
            [-math.pi / 2, self.a1, 0.0, -math.pi / 2],
            [0.0, self.c2, self.b, math.pi / 2],
            [math.pi / 2, self.a2, self.c3, 0.0],
            [-math.pi / 2, 0.0, 0.0, 0.0],
            [math.pi / 2, 0.0, self.c4, 0.0],
        ]
        rows = [[*row[:3], row[3] - offset] for row, offset in zip(rows, self.offsets, strict=True)]
        tree = etree.fromstring(DHTable.from_array(rows, "modified", name="opw").to_urdf().encode())
        for axis, sign in zip(tree.iterfind("joint/axis"), self.signs, strict=False):
            axis.set("xyz", f"0 0 {sign}")
        return str(etree.tostring(tree, encoding="unicode"))

    def flags(self, q: Array) -> NDArray[np.bool_]:
        """(..., 3) behind, below and flipped, of joint vectors (..., 6) [rad]."""
        t = np.array(self.signs) * q - np.array(self.offsets)
        bend = self.c3 * np.sin(t[..., 2]) + self.a2 * np.cos(t[..., 2])
        whole = t[..., 1] + t[..., 2]
        ahead = self.a1 + self.c2 * np.sin(t[..., 1]) + self.c3 * np.sin(whole) + self.a2 * np.cos(whole)
        return np.asarray(np.stack([ahead, bend, np.sin(t[..., 4])], axis=-1) < 0.0)

    def __str__(self) -> str:
        lengths = ", ".join(f"{name} {value:.6g}" for name, value in zip(_LENGTHS, astuple(self)[:7], strict=True))
        offsets = ", ".join(f"{value:.6g}" for value in self.offsets)
        return f"{lengths} m; offsets {offsets} rad; signs {', '.join(map(str, self.signs))}"


_LENGTHS = ("a1", "a2", "b", "c1", "c2", "c3", "c4")


class _Vendor(NamedTuple):
    """How one controller writes configurations.

    Attributes:
        codes: flags (..., 3) and joint vectors (..., 6) to numbers (..., m).
        words: for the first numbers, the words for 0 and 1.
        form: of the text.
        pattern: of text that is read, a group a number; words are read in any order, too.
        turning: which of the m numbers depend on whole turns of the joints.
        example: of the text.
    """

    codes: Callable[[NDArray[np.bool_], Array], list[Array]]
    words: tuple[tuple[str, str], ...]
    form: str
    pattern: str
    turning: tuple[int, ...]
    example: str


def _vendor(name: Any) -> _Vendor:
    return VENDORS[inputs.choice(name, "vendor", tuple(VENDORS))]


def codes(chain: Chain, q: Array, vendor: str) -> Codes:
    """(..., m) numbers of the configuration of joint vectors (..., 6) [rad]; rows of NaN have those of zeros.

    Raises:
        ArgumentError: an unknown vendor.
        UnsupportedArm: the arm has no configurations.
    """
    known = _vendor(vendor)
    q = np.nan_to_num(q)
    columns = known.codes(OPW.from_chain(chain).flags(q), q)
    return np.stack(columns, axis=-1).astype(np.int64)


def text(numbers: Sequence[int], vendor: str) -> str:
    """The numbers of a configuration as the controller writes them."""
    known = _vendor(vendor)
    words = [pair[k] for pair, k in zip(known.words, numbers, strict=False)]
    return known.form.format(*words, *numbers[len(words) :])


def read(written: str, vendor: str) -> list[int | None]:
    """The numbers of a written configuration, None for each that it leaves out.

    Raises:
        ArgumentError: an unknown vendor, or text that is no configuration of its.
    """
    known, words = _vendor(vendor), [tuple(map(str.upper, pair)) for pair in _vendor(vendor).words]
    plain = re.sub(r"\s*(<|>=)\s*", r"\1", written.strip().upper()).replace("NO FLIP", "NOFLIP").replace(" ARM", "")
    if found := re.fullmatch(known.pattern, plain):
        groups = found.groups()
        return [None if each is None else _number(each, words[k : k + 1]) for k, each in enumerate(groups)]
    parts = plain.replace(",", " ").split()
    there = [[pair.index(part) for part in parts if part in pair] for pair in words]
    if not parts or sum(map(len, there)) < len(parts) or max(map(len, there)) > 1:
        example = f"{known.example!r}; turn numbers may be left out"
        raise ArgumentError(f"{quoted(written)} is no configuration of {vendor}, such as {example}")
    return [each[0] if each else None for each in there]


def _number(part: str, words: Sequence[tuple[str, ...]]) -> int:
    """A number that is written as such, in KUKA's binary form, or by one of two words."""
    if part.isalpha():
        return words[0].index(part)
    return int(part[2:-1], 2) if part.startswith("'") else int(part)


def depends_on_turns(numbers: Sequence[int | None], vendor: str) -> bool:
    """Whether whole turns of the joints decide about these numbers."""
    return any(numbers[k] is not None for k in _vendor(vendor).turning)


def _abb(flags: NDArray[np.bool_], q: Array) -> list[Array]:
    quarters = np.floor(q[..., (0, 3, 5)] * (4.0 / TURN))
    return [*np.moveaxis(quarters, -1, 0), flags @ np.array([4, 2, 1])]


def _fanuc(flags: NDArray[np.bool_], q: Array) -> list[Array]:
    turning = q[..., (0, 3, 5)]
    turns = np.sign(turning) * np.floor((np.abs(turning) + 0.5 * TURN) / TURN)
    return [*np.moveaxis(flags[..., ::-1], -1, 0), *np.moveaxis(turns, -1, 0)]


def _kuka(flags: NDArray[np.bool_], q: Array) -> list[Array]:
    behind, below, flipped = np.moveaxis(flags, -1, 0)
    bent = np.sin(q[..., 4]) != 0.0
    return [behind + 2 * ~below + 4 * (~flipped & bent), (q < 0.0) @ (1 << np.arange(6))]


def _motoman(flags: NDArray[np.bool_], q: Array) -> list[Array]:
    behind, below, flipped = np.moveaxis(flags, -1, 0)
    far = [(q[..., i] > math.pi) | (q[..., i] <= -math.pi) for i in (3, 5, 0)]
    return [~flipped, below, behind, *far]


VENDORS: dict[str, _Vendor] = {
    "abb": _Vendor(
        codes=_abb,
        words=(),
        form="{} {} {} {}",
        pattern=r"\[?(?:(-?\d+)[\s,;]+(-?\d+)[\s,;]+(-?\d+)[\s,;]+)?([0-7])\]?",
        turning=(0, 1, 2),
        example="0 -1 0 1",
    ),
    "fanuc": _Vendor(
        codes=_fanuc,
        words=(("N", "F"), ("U", "D"), ("T", "B")),
        form="{}{}{} {} {} {}",
        pattern=r"([NF])[\s,]*([UD])[\s,]*([TB])(?:[\s,]*(-?\d)[\s,]*(-?\d)[\s,]*(-?\d))?",
        turning=(3, 4, 5),
        example="NUT 0 0 0",
    ),
    "kuka": _Vendor(
        codes=_kuka,
        words=(),
        form="S {} T {}",
        pattern=r"S\s*('B[01]{1,3}'|[0-7])(?:[\s,]*T\s*('B[01]{1,6}'|[1-5]?\d|6[0-3]))?",
        turning=(1,),
        example="S 2 T 35",
    ),
    "staubli": _Vendor(
        codes=lambda flags, q: list(np.moveaxis(flags, -1, 0)),
        words=(("righty", "lefty"), ("epositive", "enegative"), ("wpositive", "wnegative")),
        form="{} {} {}",
        pattern=r"([01])([01])([01])",
        turning=(),
        example="righty epositive wpositive",
    ),
    "motoman": _Vendor(  # ///RCONF writes the numbers
        codes=_motoman,
        words=(
            ("FLIP", "NOFLIP"), ("UPPER", "LOWER"), ("FRONT", "REAR"), ("R<180", "R>=180"), ("T<180", "T>=180"),
            ("S<180", "S>=180"),
        ),
        form="{}, {}, {}, {}, {}, {}",
        pattern=r"[\s,]*".join([r"([01])"] * 6) + r"[\s,]*",
        turning=(3, 4, 5),
        example="NOFLIP, UPPER, FRONT, S<180",
    ),
}  # fmt: skip
"""Each controller by the name of its maker."""
