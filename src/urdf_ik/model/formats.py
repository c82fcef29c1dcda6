"""The conversion of xacro and MJCF to URDF, by the packages xacro and mujoco."""

import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from urdf_ik.errors import UrdfError
from urdf_ik.model import meshes
from urdf_ik.model.poses import pose
from urdf_ik.model.xml import Source, numbers_text, origin_attributes, prolog_end
from urdf_ik.support import extras, forks

_XACRO_NAME = re.compile(r"\.xacro$", re.IGNORECASE)
_MUJOCO = re.compile(r"<mujoco[\s/>]")


def as_urdf(
    source: Source, roots: Sequence[Path], xacro_args: Mapping[str, object] | None
) -> tuple[Source, tuple[UrdfError, ...]]:
    """The source as URDF text.

    Args:
        source: the opened file or text.
        roots: folders that are searched first for ROS packages.
        xacro_args: values of a xacro's arguments; not None makes any source a xacro.

    Returns:
        The URDF, and an error for each shape that a URDF cannot hold.
    """
    if xacro_args is not None or _XACRO_NAME.search(source.name):
        return expanded(source, roots, xacro_args or {}), ()
    if _MUJOCO.match(source.text, prolog_end(source.text)):
        return _mujoco_as_urdf(source)
    return source, ()


# The package xacro keeps its arguments, its file stack and its package search in module globals.
_ONE_AT_A_TIME = forks.lock()


class _NoPackage(Exception):
    """A ROS package was not found."""


class _Arguments(dict[str, str]):
    """Arguments, with a record of the names that the xacro has looked up."""

    def __init__(self, given: Mapping[str, object]) -> None:
        super().__init__({name: str(value) for name, value in given.items()})
        self.known: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.known.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.known.add(name)
        return super().__getitem__(name)


def expanded(source: Source, roots: Sequence[Path], given: Mapping[str, object]) -> Source:
    """Expand a xacro to a URDF.

    Args:
        source: the xacro; the search for included files starts in its folder.
        roots: folders that ``$(find package)`` searches first; the xacro's own ROS package, AMENT_PREFIX_PATH and
            ROS_PACKAGE_PATH follow.
        given: values of its arguments by name.
    """
    try:
        import xacro
        from xacro import substitution_args
    except ImportError:
        raise extras.missing(f"{source.name}: xacro is not installed", "xacro") from None
    own = None if source.path is None else meshes.own_package(source.path)
    searched = [*roots, *([] if own is None else [own])]

    def folder(package: str) -> str:
        found = meshes.find_package(package, searched)
        if found is None:
            raise _NoPackage(f"there is no ROS package {package!r}")
        return str(found.absolute())

    arguments = _Arguments(given)
    with _ONE_AT_A_TIME, _finding(substitution_args, folder):
        try:
            xacro.init_stacks(None if source.path is None else str(source.path))
            document = xacro.parse(source.text)
            xacro.process_doc(document, mappings=arguments)
        except Exception as error:  # its errors have no root of their own: those of Python expressions come as they are
            raise _refused(source, error, arguments) from None
    if unknown := sorted(set(arguments) & set(given) - arguments.known):
        problem, hint = f"it has no argument {unknown[0]!r}", _has(arguments)
        raise UrdfError(problem, source=source.name, element="<xacro:arg>", hint=hint)
    return Source(document.toprettyxml(indent="  "), f"{source.name} (expanded)", source.path)


@contextmanager
def _finding(module: Any, folder: Callable[[str], str]) -> Iterator[None]:
    """Let ``$(find package)`` ask ``folder`` instead of an installation of ROS 2."""
    before = module._eval_find, module._eval_dict["find"]
    module._eval_find = module._eval_dict["find"] = folder
    try:
        yield
    finally:
        module._eval_find, module._eval_dict["find"] = before


def _refused(source: Source, error: Exception, arguments: _Arguments) -> UrdfError:
    from xacro import substitution_args

    cause = getattr(error, "exc", None) or error
    text = " ".join(str(error).split()) or type(error).__name__
    hint = "the command `xacro` says where"
    if isinstance(cause, _NoPackage):
        text = str(cause)
        hint = "give the folder that holds it in mesh_roots (--mesh-root), AMENT_PREFIX_PATH or ROS_PACKAGE_PATH"
    elif isinstance(cause, substitution_args.ArgException) or "Undefined substitution argument" in text:
        hint = f"give it with xacro_args (--xacro-arg NAME:=VALUE); {_has(arguments)}"
    return UrdfError(f"xacro cannot expand it: {text}", source=source.name, hint=hint)


def _has(arguments: _Arguments) -> str:
    known = sorted(arguments.known)
    return f"its arguments: {', '.join(known)}" if known else "it has no arguments"


WORLD = "world"
NO_RANGE = 1000.0
"""Bounds [m] of a slide without a range in the model: a URDF needs bounds."""


def _mujoco_as_urdf(source: Source) -> tuple[Source, tuple[UrdfError, ...]]:
    """A MuJoCo model as URDF: bodies and sites as links, hinges and slides as joints, geoms as shapes."""
    path = source.path
    if path is None:
        raise UrdfError("a MuJoCo model as text", source=source.name, hint="save it, and give the file's path")
    try:
        import mujoco
    except ImportError:
        raise extras.missing(f"{source.name}: a MuJoCo model, and mujoco is not installed", "mjcf") from None
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        lost = _without_missing_files(spec, source, path.parent / spec.meshdir)
        with warnings.catch_warnings():  # of masses and inertia, which a URDF's kinematics have no use for
            warnings.simplefilter("ignore")
            model = spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        text = " ".join(str(error).split())
        hint = "correct it until MuJoCo loads it"
        raise UrdfError(f"MuJoCo refuses the model: {text}", source=source.name, hint=hint) from None
    try:
        writer = _Writer(mujoco, model, spec, source)
    except ValueError as error:  # of the XML library, and of poses
        hint = "correct the name, or the number, that is no part of a URDF"
        raise UrdfError(f"it cannot be written as a URDF: {error}", source=source.name, hint=hint) from None
    text = etree.tostring(writer.robot, pretty_print=True).decode()
    return Source(text, f"{source.name} (as URDF)", source.path), (*lost, *writer.lost)


def _without_missing_files(spec: Any, source: Source, folder: Path) -> tuple[UrdfError, ...]:
    """Take meshes whose files are not there, and all that only colours need, out of a model that is not compiled."""
    absent = [mesh for mesh in spec.meshes if mesh.file and not (folder / mesh.file).is_file()]
    missing = {mesh.name or Path(mesh.file).stem for mesh in absent}
    lost = []
    for geom in list(spec.geoms):
        if geom.meshname and geom.meshname in missing:
            if geom.contype or geom.conaffinity:
                lost.append(_lost(source, geom.parent.name, f"mesh {geom.meshname!r}: its file is not there"))
            spec.delete(geom)
        else:
            geom.material = ""
    for each in (*spec.skins, *spec.materials, *spec.textures, *absent):
        spec.delete(each)
    spec.compiler.boundmass = max(spec.compiler.boundmass, 1e-9)  # a body may have lost all that it weighs
    spec.compiler.boundinertia = max(spec.compiler.boundinertia, 1e-12)
    return tuple(lost)


def _lost(source: Source, link: str, problem: str) -> UrdfError:
    element = f'<collision> of <link name="{link}">'
    return UrdfError(problem, source=source.name, element=element, hint="collision checks miss this shape")


def _free(name: str, taken: set[str]) -> str:
    """The name, lengthened until it is new; it is then taken."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name


class _Writer:
    """The URDF of a compiled model."""

    def __init__(self, mujoco: Any, model: Any, spec: Any, source: Source) -> None:
        self.mujoco, self.model, self.spec, self.source = mujoco, model, spec, source
        self.robot = etree.Element("robot", name=str(spec.modelname or "mujoco"))
        self.lost: list[UrdfError] = []
        kinds = mujoco.mjtObj
        self._names = {WORLD}
        self.bodies = [WORLD, *(self._unique(kinds.mjOBJ_BODY, i, "body") for i in range(1, model.nbody))]
        self._joint_names: set[str] = set()
        for body, link in enumerate(self.bodies):
            self._body(body, link)
        for site in range(model.nsite):
            link = self._unique(kinds.mjOBJ_SITE, site, "site")
            etree.SubElement(self.robot, "link", name=link)
            place = pose(model.site_pos[site], quat_wxyz=model.site_quat[site])
            self._join(f"{link}_fixed", "fixed", self.bodies[model.site_bodyid[site]], link, place)

    def _unique(self, kind: Any, index: int, word: str) -> str:
        """Name of a body or site that no link has yet."""
        name = str(self.mujoco.mj_id2name(self.model, kind, index) or f"{word}_{index}")
        return _free(name if name not in self._names else f"{name}_{word}", self._names)

    def _body(self, body: int, link: str) -> None:
        model = self.model
        element = etree.SubElement(self.robot, "link", name=link)
        for geom in range(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body]):
            self._shape(element, geom, link)
        if body == 0:
            return
        parent = self.bodies[model.body_parentid[body]]
        place = pose(model.body_pos[body], quat_wxyz=model.body_quat[body])
        joints = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
        for joint in joints:
            anchor = model.jnt_pos[joint]
            below = link if joint == joints[-1] and not anchor.any() else self._between(joint)
            place = self._movable(joint, parent, below, place @ pose(anchor))
            parent, place = below, place @ pose(-anchor)
        if parent != link:
            self._join(f"{link}_fixed", "fixed", parent, link, place)

    def _between(self, joint: int) -> str:
        """An additional link below a joint: for a body with several joints, or a joint away from its body's origin."""
        name = _free(f"{self._joint_name(joint)}_link", self._names)
        etree.SubElement(self.robot, "link", name=name)
        return name

    def _joint_name(self, joint: int) -> str:
        name = self.mujoco.mj_id2name(self.model, self.mujoco.mjtObj.mjOBJ_JOINT, joint)
        return str(name or f"joint_{joint}")

    def _movable(self, joint: int, parent: str, below: str, place: NDArray[np.float64]) -> NDArray[np.float64]:
        """Write one joint; returns the pose, in the link that it carries, of what comes next."""
        model, kinds = self.model, self.mujoco.mjtJoint
        kind, axis = kinds(int(model.jnt_type[joint])), model.jnt_axis[joint]
        name = self._joint_name(joint)
        if kind not in (kinds.mjJNT_HINGE, kinds.mjJNT_SLIDE):
            self._join(name, "floating", parent, below, place)
            return np.eye(4)
        slides, limited = kind == kinds.mjJNT_SLIDE, bool(model.jnt_limited[joint])
        reference = float(model.qpos0[model.jnt_qposadr[joint]])
        back = pose(-reference * axis) if slides else pose([0.0, 0.0, 0.0], rotvec=-reference * axis)
        urdf_type = "prismatic" if slides else "revolute" if limited else "continuous"
        element = self._join(name, urdf_type, parent, below, place @ back)
        etree.SubElement(element, "axis", xyz=numbers_text(axis))
        if urdf_type != "continuous":
            lower, upper = model.jnt_range[joint] if limited else (-NO_RANGE, NO_RANGE)
            limits = {"lower": repr(float(lower)), "upper": repr(float(upper))}
            etree.SubElement(element, "limit", **limits, effort="0", velocity="0")
        self._mimic(element, joint)
        return np.eye(4)

    def _mimic(self, element: Any, joint: int) -> None:
        """An equality of first order with another joint, as URDF says it."""
        model, kinds = self.model, self.mujoco.mjtEq
        for equality in range(model.neq):
            other = int(model.eq_obj2id[equality])
            is_mimic = kinds(int(model.eq_type[equality])) == kinds.mjEQ_JOINT and model.eq_obj1id[equality] == joint
            if is_mimic and model.eq_active0[equality] and other >= 0 and not model.eq_data[equality, 2:5].any():
                # Equalities are of differences from the references.
                shift, factor = (float(each) for each in model.eq_data[equality, :2])
                own, others = (float(model.qpos0[model.jnt_qposadr[each]]) for each in (joint, other))
                offset = shift + own - factor * others
                name = self._joint_name(other)
                etree.SubElement(element, "mimic", joint=name, multiplier=repr(factor), offset=repr(offset))
                return

    def _join(self, name: str, kind: str, parent: str, below: str, place: NDArray[np.float64]) -> Any:
        name = _free(name, self._joint_names)
        element = etree.SubElement(self.robot, "joint", name=name, type=kind)
        etree.SubElement(element, "parent", link=parent)
        etree.SubElement(element, "child", link=below)
        etree.SubElement(element, "origin", origin_attributes(place))
        return element

    def _shape(self, link: Any, geom: int, name: str) -> None:
        """Write a geom as a visual shape, and also as a collision shape if it collides."""
        model, kinds = self.model, self.mujoco.mjtGeom
        kind, size = kinds(int(model.geom_type[geom])), model.geom_size[geom]
        place = pose(model.geom_pos[geom], quat_wxyz=model.geom_quat[geom])
        collides = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
        shape: tuple[str, dict[str, str]] | None = None
        if kind == kinds.mjGEOM_SPHERE:
            shape = "sphere", {"radius": repr(float(size[0]))}
        elif kind == kinds.mjGEOM_BOX:
            shape = "box", {"size": numbers_text(2.0 * size)}
        elif kind in (kinds.mjGEOM_CYLINDER, kinds.mjGEOM_CAPSULE):
            measures = {"radius": repr(float(size[0])), "length": repr(2.0 * float(size[1]))}
            shape = "cylinder" if kind == kinds.mjGEOM_CYLINDER else "capsule", measures
        elif kind == kinds.mjGEOM_MESH:
            shape, place = self._mesh(int(model.geom_dataid[geom]), place)
        if shape is None:
            if collides:
                word = str(kind.name).removeprefix("mjGEOM_").lower()
                self.lost.append(_lost(self.source, name, f"a URDF has no shape for a {word}"))
            return
        for role in ("visual", "collision") if collides else ("visual",):
            part = etree.SubElement(link, role)
            etree.SubElement(part, "origin", origin_attributes(place))
            etree.SubElement(etree.SubElement(part, "geometry"), shape[0], shape[1])

    def _mesh(
        self, mesh: int, place: NDArray[np.float64]
    ) -> tuple[tuple[str, dict[str, str]] | None, NDArray[np.float64]]:
        """A mesh's file, and its pose: MuJoCo moves a mesh to its own centre of mass and principal axes."""
        model = self.model
        written = self.spec.meshes[mesh]
        if not written.file:
            return None, place
        inertial = pose(model.mesh_pos[mesh], quat_wxyz=model.mesh_quat[mesh])
        attributes = {"filename": str(Path(self.spec.meshdir) / written.file), "scale": numbers_text(written.scale)}
        return ("mesh", attributes), place @ np.linalg.inv(inertial)
