"""URDFs of chains and trees, and Pinocchio as the reference of every link in them."""

import math
from collections.abc import Mapping

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]
LIMIT = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'


class ReferenceModel:
    """Pinocchio's model of a tree, asked by joint names; a joint that is not named stays at zero."""

    def __init__(self, xml: str, *, mimic: bool = True) -> None:
        """Read URDF text; joints that mimic follow their drivers."""
        self.model = pin.buildModelFromXML(xml, mimic=mimic)
        self.data = self.model.createData()

    def place(self, values: Mapping[str, float]) -> None:
        """Move the joints."""
        full = pin.neutral(self.model)
        for name, value in values.items():
            entry = self.model.joints[self.model.getJointId(name)]
            # A continuous joint is a cosine and a sine.
            numbers = (math.cos(value), math.sin(value)) if entry.nq == 2 else (value,)
            full[entry.idx_q : entry.idx_q + entry.nq] = numbers
        pin.computeJointJacobians(self.model, self.data, full)
        pin.updateFramePlacements(self.model, self.data)

    def _frame(self, link: str) -> int:
        index = self.model.getFrameId(link, pin.FrameType.BODY)
        assert index < self.model.nframes, link
        return int(index)

    def pose(self, base: str, link: str) -> Array:
        """Pose (4, 4) of a link in another one."""
        frames = self.data.oMf
        return frames[self._frame(base)].actInv(frames[self._frame(link)]).homogeneous

    def jacobian(self, base: str, tip: str, names: tuple[str, ...]) -> Array:
        """Jacobian (6, n) of the tip against the base, which moves too where joints lead up from it."""
        b, t = self._frame(base), self._frame(tip)
        of_base, of_tip = (
            # A model of one joint gets a flat array from Pinocchio.
            np.reshape(pin.getFrameJacobian(self.model, self.data, i, pin.LOCAL_WORLD_ALIGNED), (6, -1))
            for i in (b, t)
        )
        arm = self.data.oMf[t].translation - self.data.oMf[b].translation
        linear = of_tip[:3] - of_base[:3] - np.cross(of_base[3:], arm, axis=0)
        to_base = self.data.oMf[b].rotation.T
        relative = np.concatenate([to_base @ linear, to_base @ (of_tip[3:] - of_base[3:])])
        columns = [self.model.joints[self.model.getJointId(name)].idx_v for name in names]
        return relative[:, columns]


def joint(
    name: str,
    kind: str,
    parent: str,
    child: str,
    xyz: str = "0 0 0",
    rpy: str = "0 0 0",
    axis: str = "",
    more: str = "",
) -> str:
    """A joint element; limits come with every type that needs them."""
    axis = f'<axis xyz="{axis}"/>' if axis else ""
    limit = LIMIT if kind in ("revolute", "prismatic") and "<limit" not in more else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/>{axis}{limit}{more}</joint>'
    )


def collision(shape: str, xyz: str = "0 0 0", rpy: str = "0 0 0") -> str:
    """A collision element of a link."""
    return f'<collision><origin xyz="{xyz}" rpy="{rpy}"/><geometry><{shape}/></geometry></collision>'


def robot(*joints: str, **parts: str) -> str:
    """URDF text with the links that the joints name, and what is in them."""
    text = "".join(joints)
    names = dict.fromkeys(part.split('"')[0] for part in text.split(' link="')[1:])
    links = (f'<link name="{x}">{parts[x]}</link>' if x in parts else f'<link name="{x}"/>' for x in names)
    return f'<robot name="r">{"".join(links)}{text}</robot>'


def random_tree(seed: int, joints: int = 12) -> str:
    """A tree with every type of joint, axes of any length and direction, and fixed joints anywhere."""
    rng = np.random.default_rng(seed)

    def numbers(low: float, high: float) -> str:
        return " ".join(repr(float(x)) for x in rng.uniform(low, high, 3))

    parts = []
    for i in range(joints):
        kind = str(rng.choice(["revolute", "continuous", "prismatic", "fixed"], p=[0.35, 0.2, 0.25, 0.2]))
        # Mostly deep, with side branches.
        parent = max(0, i - int(rng.choice([0, 0, 0, 1, 3])))
        axis = "" if kind == "fixed" else numbers(-4.0, 4.0)
        parts.append(joint(f"j{i}", kind, f"l{parent}", f"l{i + 1}", numbers(-1, 1), numbers(-3, 3), axis))
    # The file's order is not the tree's.
    return robot(*[parts[i] for i in rng.permutation(joints)])


def serial(kinds: str, seed: int = 0) -> str:
    """A chain of joints, R, C (continuous), P or F (fixed), from link l0 on, in random frames."""
    rng = np.random.default_rng([seed, *kinds.encode()])

    def numbers() -> str:
        return " ".join(repr(float(x)) for x in rng.uniform(-1.5, 1.5, 3))

    names = {"R": "revolute", "C": "continuous", "P": "prismatic", "F": "fixed"}
    return robot(
        *(
            joint(f"j{i}", names[k], f"l{i}", f"l{i + 1}", numbers(), numbers(), "" if k == "F" else numbers())
            for i, k in enumerate(kinds)
        )
    )


HAND = robot(
    joint("a", "revolute", "base", "arm", "0 0 0.3", axis="0 1 0"),
    joint("b", "continuous", "arm", "wrist", "0 0 0.5", "0.2 0 0", axis="1 0 0"),
    joint("f", "fixed", "wrist", "tool", "0 0 0.1"),
    # Fingers that follow the arm, each in its own way.
    joint("left", "prismatic", "wrist", "left", "0 0.1 0.1", axis="0 2 0", more='<mimic joint="a" multiplier="0.1"/>'),
    joint("right", "revolute", "wrist", "right", "0 -0.1 0.1", axis="0 0 1", more=f"{LIMIT}{{}}"),
    # Nobody moves these.
    joint("free", "revolute", "wrist", "camera", "0.1 0 0", axis="0 0 1"),
    joint("lid", "revolute", "camera", "shutter", "0.1 0 0", axis="0 1 0", more='<mimic joint="free" offset="0.7"/>'),
    joint("door", "prismatic", "base", "drawer", "-1 0 0", axis="1 0 0"),
    joint("loose", "floating", "base", "cart", "2 0 0", "0 0 1"),
    joint("flat", "planar", "base", "rug", "0 3 0", axis="0 0 1"),
)
RIGHT = '<mimic joint="a" multiplier="-0.5" offset="0.25"/>'
