"""Denavit-Hartenberg tables, standard or modified, to URDF and back from any chain."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import PoseError, UrdfError
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.dh import files
from urdf_ik.kinematics.dh.files import COLUMNS, check_convention, table_error
from urdf_ik.kinematics.dh.frames import fields_of, frames_of, rotation_z, slide_z, step_x
from urdf_ik.model.poses import check_poses
from urdf_ik.support import inputs
from urdf_ik.support.files import name_of
from urdf_ik.support.read_only import Frozen, frozen
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

JOINT_TYPES = ("revolute", "continuous", "prismatic")
LETTERS = {"R": "revolute", "C": "continuous", "P": "prismatic"}
_SAMPLES = 12


@dataclass(frozen=True, eq=False)
class DHTable(Frozen):
    """A serial arm as a Denavit-Hartenberg table between a base and a tool transform.

    The joint's variable is added to ``theta`` (revolute, continuous) or to ``d`` (prismatic): what stands there is
    the joint's offset.

    Attributes:
        convention: 'standard' or 'modified' (Craig).
        alpha: (n,) rad, twist about x.
        a: (n,) m, along x.
        d: (n,) m, along z.
        theta: (n,) rad, about z.
        joint_types: (n,) of 'revolute', 'continuous' or 'prismatic'.
        joint_names: (n,) names.
        limits: (n, 2) rad or m; a continuous joint has (-inf, inf).
        base: (4, 4) where the table begins, in the base link.
        tool: (4, 4) tip in the table's last frame.
        name: of the robot.

    Example:
        >>> import urdf_ik
        >>> table = urdf_ik.DHTable.from_array([[0.0, 0.3, 0.0, 0.0], [0.0, 0.2, 0.0, 0.0]], "standard")
        >>> arm = urdf_ik.load(table.to_urdf())
        >>> arm.dof, (arm.fk([0.0, 0.0])[:3, 3].round(6) + 0.0).tolist()
        (2, [0.5, 0.0, 0.0])
    """

    convention: str
    alpha: Array
    a: Array
    d: Array
    theta: Array
    joint_types: tuple[str, ...]
    joint_names: tuple[str, ...]
    limits: Array
    base: Array
    tool: Array
    name: str = "arm"

    def __post_init__(self) -> None:
        for field in (*COLUMNS, "limits", "base", "tool"):
            object.__setattr__(self, field, frozen(np.array(getattr(self, field), dtype=np.float64)))
        check_convention(self.convention)
        if self.n == 0:
            raise table_error("the table has no rows; one row a joint is needed")
        if len(set(self.joint_names)) != self.n or not all(str(name).strip() for name in self.joint_names):
            shown = ", ".join(map(repr, self.joint_names))
            raise table_error(f"joint names {shown}; {self.n} different ones are needed")
        for row, (kind, (lower, upper)) in enumerate(zip(self.joint_types, self.limits, strict=True), start=1):
            if kind != "continuous" and not (np.isfinite([lower, upper]).all() and lower <= upper):
                needed = f"two finite limits of a {kind} joint are needed, the lower one first"
                raise table_error(f"{needed}, not {lower} and {upper}", row=row, column="lower")

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.alpha)

    @property
    def prismatic(self) -> NDArray[np.bool_]:
        """(n,) true for prismatic joints."""
        return np.array([kind == "prismatic" for kind in self.joint_types], dtype=np.bool_)

    def origins(self) -> Array:
        """(n + 1, 4, 4) joint frames at q = 0, each in the one before, then the tip; every axis is z of its frame."""
        about_x = [step_x(a, alpha) for a, alpha in zip(self.a, self.alpha, strict=True)]
        about_z = [rotation_z(theta) @ slide_z(d) for theta, d in zip(self.theta, self.d, strict=True)]
        if self.convention == "modified":
            steps = [x @ z for x, z in zip(about_x, about_z, strict=True)]
            return np.array([self.base @ steps[0], *steps[1:], self.tool])
        steps = [z @ x for z, x in zip(about_z, about_x, strict=True)]
        return np.array([self.base, *steps[:-1], steps[-1] @ self.tool])

    @classmethod
    def from_array(
        cls,
        rows: ArrayLike,
        convention: str,
        *,
        joint_types: str | Sequence[str] = "",
        joint_names: Sequence[str] | None = None,
        limits: ArrayLike | None = None,
        base: ArrayLike | None = None,
        tool: ArrayLike | None = None,
        name: str = "arm",
        degrees: bool = False,
    ) -> "DHTable":
        """Make a table from numbers.

        Args:
            rows: (n, 4) alpha [rad], a [m], d [m], theta [rad], in this order in either convention.
            convention: 'standard' or 'modified'.
            joint_types: letters such as 'RRP', or 'revolute', 'continuous', 'prismatic' for each joint; all
                revolute where left out.
            joint_names: ``joint_1`` ... where left out.
            limits: (n, 2) rad or m. A revolute joint without them is continuous; a prismatic one needs them.
            base: (4, 4), the identity where left out.
            tool: (4, 4), the identity where left out.
            name: of the robot.
            degrees: alpha, theta and the limits of revolute joints are given in degrees.

        Raises:
            UrdfError: it is no table; the error names row, column and value.

        Example:
            >>> import urdf_ik
            >>> rows = [[0, 0.325, 0.38, 0], [180, 0.275, 0, 0], [0, 0, 0, 0]]  # alpha, a, d, theta
            >>> table = urdf_ik.DHTable.from_array(rows, "standard", joint_types="RRR", degrees=True)
            >>> table.joint_names, table.a.tolist()
            (('joint_1', 'joint_2', 'joint_3'), [0.325, 0.275, 0.0])
        """
        table = inputs.array(rows, "rows", (None, 4), UrdfError).copy()
        n, words = len(table), _joint_types(joint_types, len(table))
        turning = np.array([kind != "prismatic" for kind in words], dtype=np.bool_)
        bounds = np.tile([-np.inf, np.inf], (n, 1)) if limits is None else np.array(limits, dtype=np.float64)
        if bounds.shape != (n, 2):
            raise table_error(f"limits of shape {bounds.shape} given; ({n}, 2) is needed, lower and upper")
        if degrees:
            table[:, [0, 3]] = np.deg2rad(table[:, [0, 3]])
            bounds = np.where(turning[:, None], np.deg2rad(bounds), bounds)
        endless = np.isinf(bounds).all(axis=1) & turning
        kinds = tuple("continuous" if e else kind for e, kind in zip(endless, words, strict=True))
        round_for_ever = np.array([kind == "continuous" for kind in kinds], dtype=np.bool_)
        return cls(
            convention=convention,
            **dict(zip(COLUMNS, table.T, strict=True)),
            joint_types=kinds,
            joint_names=tuple(f"joint_{i + 1}" for i in range(n)) if joint_names is None else tuple(joint_names),
            limits=np.where(round_for_ever[:, None], [-np.inf, np.inf], bounds),
            base=_transform(base, "base"),
            tool=_transform(tool, "tool"),
            name=name,
        )

    @classmethod
    def read(cls, path: str | os.PathLike[str], convention: str | None = None, *, degrees: bool = False) -> "DHTable":
        """Read a table from a CSV file, in the form that :meth:`to_csv` writes.

        Args:
            path: the file.
            convention: of a file that does not say its own.
            degrees: whether the angles of a file that does not say its unit are in degrees instead of rad.

        Raises:
            UrdfError: the file cannot be read or holds no table; the error names file, row, column and value.

        Example:
            >>> from pathlib import Path
            >>> import urdf_ik
            >>> table = urdf_ik.DHTable.from_chain(urdf_ik.load("puma_560").chain)
            >>> _ = Path("puma.csv").write_text(table.to_csv(degrees=True))
            >>> (urdf_ik.DHTable.read("puma.csv").a.round(4) + 0.0).tolist()
            [0.0, 0.4318, 0.0203, 0.0, 0.0, 0.0]
        """
        try:
            return cls.from_array(**files.read(path, convention, degrees))
        except UrdfError as error:
            raise UrdfError(error.problem, source=name_of(path), element=error.element) from None

    @classmethod
    def from_chain(
        cls, chain: Chain, convention: str = "standard", *, snap: float | None = None, name: str = "arm"
    ) -> "DHTable":
        """The table of a chain: base and tool are left over only where the convention has no room for them.

        Args:
            chain: any chain of at least one movable joint.
            convention: 'standard' or 'modified'.
            snap: angle [rad] and distance [share of the chain's size] below which neighbouring axes are taken for
                parallel or meeting, as in a URDF with rounded decimals; at most 0.5. Left out: the chain as written.
            name: of the robot.

        Raises:
            UrdfError: the chain has no joints, ``snap`` is out of range, or, without it, two axes are so near parallel
                that no table in double precision holds them to 1e-9.

        Example:
            >>> import urdf_ik
            >>> table = urdf_ik.DHTable.from_chain(urdf_ik.load("puma_560").chain)
            >>> (table.a.round(4) + 0.0).tolist(), (table.d.round(4) + 0.0).tolist()
            ([0.0, 0.4318, 0.0203, 0.0, 0.0, 0.0], [0.672, 0.0, 0.15, 0.4318, 0.0, 0.0])
        """
        check_convention(convention)
        between = f"between {chain.base!r} and {chain.tip!r}"
        if chain.n == 0:
            raise table_error(f"no movable joint {between}, so there is no table")
        if chain.axes is not chain:
            raise table_error(f"joints {between} mimic others, which a table cannot say")
        table = cls(
            convention=convention,
            joint_types=chain.joint_types,
            joint_names=chain.joint_names,
            limits=chain.limits,
            name=name,
            **fields_of(frames_of(chain, snap), chain, convention == "modified"),
        )
        if snap is None and (off := table.deviation(chain)) > DEFAULT.contract:
            angles = np.linalg.norm(np.cross(chain.H[:-1], chain.H[1:]), axis=1)
            i = int(np.argmin(np.where(angles > DEFAULT.exact_structure, angles, np.inf)))
            raise table_error(
                f"axes {i + 1} and {i + 2} are {angles[i]:.1e} rad off parallel, and their table's poses would be "
                f"{off:.0e} of the arm's size off; give snap={2.0 * angles[i]:.0e} to take them for parallel"
            )
        return table

    def chain(self) -> Chain:
        """The table as screw axes from ``base_link`` to ``tool0``."""
        frames = np.array([*accumulate(self.origins(), np.matmul)])
        return Chain(
            base="base_link",
            tip="tool0",
            joint_names=self.joint_names,
            joint_types=self.joint_types,
            H=frames[:-1, :3, 2].copy(),
            P=np.diff(np.vstack([np.zeros(3), frames[:, :3, 3]]), axis=0),
            R_tip=frames[-1, :3, :3].copy(),
            limits=self.limits,
        )

    def fk(self, q: ArrayLike) -> Array:
        """Pose of the tip in the base link: (..., n) rad or m to (..., 4, 4); see :meth:`Chain.fk`."""
        return self.chain().fk(q)

    def deviation(self, chain: Chain) -> float:
        """Greatest difference from the chain's poses over sampled joint vectors, in rad and shares of its size."""
        Q = np.random.default_rng(0).uniform(-np.pi, np.pi, (_SAMPLES, chain.n))
        Q = np.where(chain.prismatic, Q * chain.size / np.pi, Q)
        apart = self.fk(Q) - chain.fk(Q)
        apart[:, :3, 3] /= chain.size
        return float(np.abs(apart).max())

    def to_urdf(self, base_link: str = "base_link", tip_link: str = "tool0") -> str:
        """URDF text with links of cylinders and boxes; frames and axes are those of :meth:`origins`.

        Example:
            >>> import urdf_ik
            >>> table = urdf_ik.DHTable.from_array([[0.0, 0.3, 0.0, 0.0], [0.0, 0.2, 0.0, 0.0]], "standard")
            >>> urdf_ik.load(table.to_urdf()).joint_names
            ('joint_1', 'joint_2')
        """
        from urdf_ik.kinematics.dh import urdf_text

        return urdf_text.write(self, base_link, tip_link)

    def to_csv(self, *, degrees: bool = False) -> str:
        """CSV text that :meth:`read` takes, with every digit.

        Example:
            >>> import urdf_ik
            >>> table = urdf_ik.DHTable.from_array([[0.0, 0.3, 0.0, 0.0], [0.0, 0.2, 0.0, 0.0]], "standard")
            >>> print(table.to_csv(), end="")
            # name: arm
            # convention: standard
            # angles: rad
            name,type,alpha,a,d,theta,lower,upper
            joint_1,continuous,0.0,0.3,0.0,0.0,,
            joint_2,continuous,0.0,0.2,0.0,0.0,,
        """
        return files.as_csv(self, degrees)

    def __str__(self) -> str:
        return files.as_text(self)


def _joint_types(kinds: str | Sequence[str], n: int) -> tuple[str, ...]:
    """Types of ``n`` joints from words, letters such as 'RRP', or nothing (all revolute)."""
    if len(kinds) == 0:
        return ("revolute",) * n
    words = []
    for row, kind in enumerate(kinds, start=1):
        word = LETTERS.get(kind, kind) if isinstance(kind, str) else ""
        if word not in JOINT_TYPES:
            raise table_error(
                f"unknown joint type {kind!r}; there are {', '.join(JOINT_TYPES)} ({', '.join(LETTERS)})",
                row=row,
                column="type",
            )
        words.append(word)
    if len(words) != n:
        raise table_error(f"{len(words)} joint types for {n} rows; one a row is needed")
    return tuple(words)


def _transform(value: ArrayLike | None, name: str) -> Array:
    """One pose (4, 4) of its own; the identity for None."""
    try:
        T = np.eye(4) if value is None else check_poses(value).copy()
    except PoseError as error:
        raise table_error(f"{name} transform: {error}") from None
    if T.shape != (4, 4):
        raise table_error(f"{name} transform of shape {T.shape} given; one pose (4, 4) is needed")
    return T
