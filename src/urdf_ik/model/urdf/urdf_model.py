"""UrdfModel: a URDF that was read and checked, its kinematic tree and its clean XML."""

import io
import os
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from lxml import etree

from urdf_ik.errors import ChainError
from urdf_ik.model import meshes
from urdf_ik.model.urdf.chains import Candidate, Chains, Limb, doubt
from urdf_ik.model.urdf.checks import MOVABLE, TAKEN_FOR_FIXED, Joint, UrdfWarning, together
from urdf_ik.support import files
from urdf_ik.support.text import meant, nearest


@dataclass(frozen=True, eq=False)
class UrdfModel:
    """A URDF that was read and checked: its links and joints form one tree.

    Attributes:
        name: the robot's name; may be empty.
        source: its name in messages: the path, or ``<text>``.
        path: absolute path of the file that it was read from, or None.
        xml: the clean URDF (UTF-8), links and joints and nothing else, which yourdfpy and Pinocchio read alike.
        links: names of the links, in the file's order.
        joints: in the file's order.
        root: the link without a parent.
        mesh_roots: folders that meshes may come from, besides the URDF's own.
        warnings: defects in parts that a chain need not use, and how they were read. ``xml`` is without these
            defects, so Pinocchio and yourdfpy read what is read here.
        sha256: SHA-256 of the text that was read, tools apart; of a xacro or MJCF, of the URDF made from it.
        robot: yourdfpy's model of ``xml``, without meshes and without a scene.

    Example:
        >>> import urdf_ik
        >>> model = urdf_ik.load("planar_2r").model
        >>> model.name, model.links
        ('planar_2r', ('base_link', 'link_1', 'link_2', 'tool0'))
    """

    name: str
    source: str
    path: Path | None
    xml: bytes = field(repr=False)
    links: tuple[str, ...] = field(repr=False)
    joints: tuple[Joint, ...] = field(repr=False)
    root: str
    mesh_roots: tuple[Path, ...] = ()
    warnings: tuple[UrdfWarning, ...] = field(repr=False, default=())
    sha256: str = field(repr=False, default="")

    @cached_property
    def robot(self) -> Any:
        """The yourdfpy.URDF of ``xml``, without meshes, scene and capsules, which yourdfpy refuses."""
        import yourdfpy  # brings trimesh, SciPy and NetworkX: 0.5 s that loading an arm need not pay

        tree = etree.fromstring(self.xml)
        for body in [shape.getparent().getparent() for shape in tree.iter("capsule")]:
            body.getparent().remove(body)
        return yourdfpy.URDF.load(io.BytesIO(etree.tostring(tree)), build_scene_graph=False, load_meshes=False)

    @property
    def package_dirs(self) -> tuple[str, ...]:
        """Folders that meshes may come from: the URDF's own, that of its ROS package, and the mesh roots."""
        own = [] if self.path is None else [self.path.parent, meshes.own_package(self.path)]
        return tuple(dict.fromkeys(str(folder) for folder in (*own, *self.mesh_roots) if folder is not None))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the clean URDF (``model.xml``), tools included.

        Meshes keep the filenames of the file that was read. ``urdf_ik.load(path, arm.base, arm.tip,
        locked=dict(arm.chain.locked), mesh_roots=arm.model.package_dirs)`` gives the same arm again.

        Args:
            path: the file, which is replaced if it exists.

        Raises:
            ArgumentError: it cannot be written.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr").with_tool(urdf_ik.pose([0.0, 0.0, 0.1]), name="gripper")
            >>> arm.model.write("scara_with_gripper.urdf")
            >>> urdf_ik.load("scara_with_gripper.urdf", tip=arm.tip).tip
            'gripper'
        """
        files.write(path, self.xml)

    def parent_joint(self, link: str) -> Joint | None:
        """The joint that carries ``link``, or None for the root.

        Raises:
            ChainError: there is no such link.
        """
        self._require(link)
        return self._carrier.get(link)

    def children(self, link: str) -> tuple[Joint, ...]:
        """The joints that ``link`` carries, in the file's order.

        Raises:
            ChainError: there is no such link.
        """
        self._require(link)
        return self._carried.get(link, ())

    def path_between(self, base: str, tip: str) -> tuple[Joint, ...]:
        """The joints from ``base`` up to the lowest common ancestor of both links, and down to ``tip``.

        Raises:
            ChainError: there is no such link.
        """
        up = self._up_from(self._require(base, "base"))
        down = self._up_from(self._require(tip, "tip"))
        while up and down and up[-1] is down[-1]:
            up.pop()
            down.pop()
        return (*up, *reversed(down))

    def chains(self, base: str | None = None) -> tuple[Candidate, ...]:
        """Candidate chains below a link, the longest first, without the fingers of hands.

        One is chosen if the URDF leaves no doubt: it has at least twice the joints of every other chain, and its tip
        is unique. The tip is unique if the chain ends in one link, or if a single end link has the name of a tool
        frame or is the only leaf.

        Args:
            base: first link of the chains; default: the root.

        Raises:
            ChainError: there is no such link.

        Example:
            >>> import urdf_ik
            >>> print(urdf_ik.load("planar_2r").model.chains()[0])
            base_link to tool0, 2 joints
        """
        return self._chains_below(base).candidates()

    def limbs(self, base: str | None = None) -> tuple[Limb, ...]:
        """The limbs below a link, named after their joints and links: arms, legs, a head.

        Args:
            base: the search goes downwards from this link; default: the root.

        Raises:
            ChainError: there is no such link.

        Example:
            >>> import urdf_ik
            >>> [(limb.name, len(limb.joints)) for limb in urdf_ik.load("dual_6r").model.limbs()]
            [('left_arm', 6), ('right_arm', 6)]
        """
        return self._chains_below(base).limbs()

    def _chains_below(self, base: str | None) -> Chains:
        # A joint that was read as fixed because of a defect may still belong to the chain that the caller means.
        still = {name for each in self.warnings if each.assumed == TAKEN_FOR_FIXED for name in each.joints}
        joints = tuple(replace(each, type="continuous") if each.name in still else each for each in self.joints)
        return Chains(self._require(self.root if base is None else base, "base"), joints)

    def resolve_chain(
        self, base: str | None = None, tip: str | None = None, chain: str | None = None
    ) -> tuple[str, str]:
        """Base and tip, with defaults: the root, and the tip of the chosen or named chain.

        If both are given they may be any links of the tree: the tip need not lie below the base.

        Args:
            base: base link.
            tip: tip link.
            chain: name of one of ``chains`` or of ``limbs``; used only without a tip.

        Raises:
            ChainError: there is no such link, or the chain is ambiguous; ``candidates`` lists the valid names.
        """
        if tip is not None:
            return self.root if base is None else self._require(base, "base"), self._require(tip, "tip")
        if base is None and any(each.rule == "parts" and each.joints for each in self.warnings):
            # The wanted arm may be in a part that is not connected to the rest: report why the tree fell apart.
            raise next(each.error for each in self.warnings if each.rule in ("undeclared", "ends", "parts"))
        candidates = self.chains(base)
        if not candidates:
            if base is None and (defects := [each for each in self.warnings if each.joints or each.links]):
                raise together([each.error for each in defects])  # without them there might be a chain
            # A base on a side branch, such as the frame 'base' of a UR: the tip is that of the whole tree.
            whole = () if base is None or base == self.root else self.chains()
            tips = [each.tip for each in whole if (each.chosen if chain is None else each.name == chain)]
            between = self.path_between(base, tips[0]) if base is not None and len(tips) == 1 else ()
            if base is not None and any(joint.type in MOVABLE for joint in between):
                return base, tips[0]
            start = self.root if base is None else base
            joints = f"no {', '.join(MOVABLE)} joint"
            way_out = "; name the tip with tip=... (--tip)" if whole else ": there is no movable chain"
            raise ChainError(f"{self.source}: {joints} below base {start!r}{way_out}")
        meant = [each for each in candidates if (each.chosen if chain is None else each.name == chain)]
        if len(meant) == 1:
            return meant[0].base if base is None else base, meant[0].tip
        limbs = self.limbs(base)
        if named := [limb for limb in limbs if limb.name == chain]:
            return named[0].base if base is None else base, named[0].tip
        raise doubt(self.source, candidates, limbs, chain)

    def require_sound(self, base: str, tip: str) -> None:
        """Raise an error if the chain between two links uses a defective part of the URDF.

        Raises:
            UrdfError: a joint or link of the chain, or a joint that one of its joints mimics, has a defect.
            ChainError: there is no such link.
        """
        if not self.warnings:
            return
        path = self.path_between(base, tip)
        links = {base, tip}.union(*((joint.parent, joint.child) for joint in path))
        joints = {each.name for joint in path for each in self._row(joint)}
        if used := [each.error for each in self.warnings if joints & {*each.joints} or links & {*each.links}]:
            raise together(used)

    def _row(self, joint: Joint) -> list[Joint]:
        """The joint, the joint that it mimics, and so on."""
        row = [joint]
        while (mimic := row[-1].mimic) is not None:
            row.append(self._by_name[mimic[0]])
        return row

    def driver(self, joint: Joint) -> tuple[Joint, float, float]:
        """The joint that drives ``joint`` through its mimics, with multiplier and offset; itself without a mimic."""
        if joint.mimic is None:
            return joint, 1.0, 0.0
        multiplier, offset = 1.0, 0.0
        row = self._row(joint)
        for each in row[:-1]:
            _, factor, shift = each.mimic or ("", 1.0, 0.0)
            offset += multiplier * shift
            multiplier *= factor
        return row[-1], multiplier, offset

    @cached_property
    def _by_name(self) -> dict[str, Joint]:
        return {joint.name: joint for joint in self.joints}

    @cached_property
    def _carrier(self) -> dict[str, Joint]:
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def _carried(self) -> dict[str, tuple[Joint, ...]]:
        carried: dict[str, tuple[Joint, ...]] = {}
        for joint in self.joints:
            carried[joint.parent] = (*carried.get(joint.parent, ()), joint)
        return carried

    def _require(self, link: str, role: str = "link") -> str:
        if isinstance(link, str) and (link == self.root or link in self._carrier):
            return link
        if apart := next((each for each in self.warnings if link in each.links), None):
            raise apart.error  # the file has this link, but not in the tree
        close = nearest(link, self.links)
        what = "link" if role == "link" else f"{role} link"
        raise ChainError(
            f"{self.source}: there is no {what} {link!r}{meant(link, self.links)}", dict.fromkeys([*close, *self.links])
        )

    def _up_from(self, link: str) -> list[Joint]:
        """The joints from ``link`` to the root."""
        joints = []
        while (joint := self._carrier.get(link)) is not None:
            joints.append(joint)
            link = joint.parent
        return joints


def resolve_mesh(model: UrdfModel, filename: str) -> Path:
    """Find the file of a mesh in the URDF's own folder, its ROS package, the mesh roots and other ROS packages.

    Args:
        model: the URDF that names the mesh.
        filename: as written: ``package://package/path``, ``file://path`` or a path.

    Returns:
        The file's path, absolute, with symbolic links followed.

    Raises:
        UrdfError: the path leads outside these folders, or no such file exists there; the message lists them.
    """
    return meshes.resolve(filename, [Path(folder) for folder in model.package_dirs], model.source)
