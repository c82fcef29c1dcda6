"""Self-collision and distances against known geometry, and against Pinocchio asked in the plainest way."""

import math
import re
import warnings
from functools import lru_cache
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from chains import LIMIT, collision, joint, robot

import urdf_ik
from urdf_ik.cell import CollisionModel, Nearest
from urdf_ik.errors import ArgumentError, PoseError, UrdfError
from urdf_ik.model import catalogue, urdf

SPHERE = 'sphere radius="{}"'
BOX = 'box size="{}"'
REACH = LIMIT.replace("3", "2")


def slide(name: str, parent: str, child: str, axis: str = "1 0 0") -> str:
    """A prismatic joint of +-2."""
    return joint(name, "prismatic", parent, child, axis=axis, more=REACH)


def table(first: str, second: str) -> str:
    """A shape at the origin, and one that two sliders move over x and y: q is its place."""
    sliders = (slide("x", "base", "rail"), slide("y", "rail", "tool", "0 1 0"))
    return robot(*sliders, base=collision(first), tool=collision(second))


SPHERES = table(SPHERE.format(0.1), SPHERE.format(0.2))


def model(text: str) -> CollisionModel:
    """Collision of a URDF given as text."""
    return CollisionModel(urdf.read(text))


@lru_cache
def from_catalogue(name: str) -> CollisionModel:
    """Collision of an arm that has a name."""
    entry = catalogue.resolve(name)
    return CollisionModel(urdf.read(entry.path, mesh_roots=entry.package_dirs), entry.base, entry.tip)


# ---------------------------------------------------------------- known geometry


@pytest.mark.parametrize(("x", "y"), [(1.0, 0.0), (-0.6, 0.8), (0.3 + 1e-5, 0.0)])
def test_distance_of_two_spheres(x: float, y: float) -> None:
    """Two spheres are as far apart as their centres less their radii."""
    body = model(SPHERES)
    expected = math.hypot(x, y) - 0.3
    assert body.distance([x, y]) == pytest.approx(expected, abs=1e-9)
    assert body.in_collision([x, y]) is False
    assert body.colliding_pairs([x, y]) == ()
    assert body.nearest_pair([x, y]) == Nearest(("base", "tool"), body.distance([x, y]))


def test_two_spheres_that_overlap() -> None:
    """In collision the distance is 0, and the pair is named."""
    body = model(SPHERES)
    assert body.in_collision([0.1, 0.2]) is True
    assert body.distance([0.1, 0.2]) == 0.0
    assert body.colliding_pairs([0.1, 0.2]) == (("base", "tool"),)
    assert body.nearest_pair([0.1, 0.2]) == Nearest(("base", "tool"), 0.0)


@pytest.mark.parametrize(
    ("x", "y", "expected"), [(0.5, 0.1, 0.15), (0.1, -0.9, 0.4), (0.65, 1.0, math.hypot(0.3, 0.5)), (0.3, 0.4, 0.0)]
)
def test_distance_of_two_boxes(x: float, y: float, expected: float) -> None:
    """Boxes, 0.2 x 0.4 and 0.5 x 0.6 across: face to face, edge to edge, and overlapping at a corner."""
    body = model(table(BOX.format("0.2 0.4 1"), BOX.format("0.5 0.6 1")))
    assert body.distance([x, y]) == pytest.approx(expected, abs=2e-6)
    assert body.in_collision([x, y]) == (expected == 0.0)


def test_batches_and_rows_that_are_not_finite() -> None:
    """Arrays come in the batch's shape; a distance at NaN is NaN, and what touches there is refused an answer."""
    body = model(SPHERES)
    q = np.array([[[1.0, 0.0], [0.1, 0.1]], [[np.nan, 0.1], [np.inf, 0.0]]])
    hits, distances = body.in_collision(q[:1]), body.distance(q)
    assert isinstance(hits, np.ndarray)
    assert hits.dtype == np.bool_
    np.testing.assert_array_equal(hits, [[False, True]])
    np.testing.assert_allclose(distances, [[0.7, 0.0], [np.nan, np.nan]], atol=1e-9)
    with pytest.raises(ArgumentError, match=r"vector\[1, 0\] is not finite"):
        body.in_collision(q)
    for question in (body.in_collision, body.colliding_pairs, body.nearest_pair):
        for bad in ([np.nan, 0.0], [np.inf, 0.0], [None, None]):
            with pytest.raises(ArgumentError, match="finite|array of numbers"):
                question(bad)
    assert np.shape(body.in_collision(np.empty((0, 2)))) == (0,)


# ---------------------------------------------------------------- which pairs may touch

# base - slider - plate = cup (fixed) - slider - carriage - slider - tool
ROW = robot(
    slide("one", "base", "plate"),
    joint("cup", "fixed", "plate", "cup", "0 0 0.15"),
    slide("two", "cup", "carriage"),
    slide("three", "carriage", "tool"),
    **dict.fromkeys(("base", "plate", "cup", "carriage", "tool"), collision(SPHERE.format(0.1))),
)


def test_rigid_and_adjacent_links_may_touch() -> None:
    """No joint or one joint between two links, counted through fixed joints, excuses them; two do not."""
    body = model(ROW)
    assert dict(body.table().allowed) == {
        ("base", "plate"): "adjacent",
        ("base", "cup"): "adjacent",
        ("plate", "cup"): "rigid",
        ("plate", "carriage"): "adjacent",
        ("cup", "carriage"): "adjacent",
        ("carriage", "tool"): "adjacent",
    }
    assert body.checked_pairs == (("base", "carriage"), ("base", "tool"), ("plate", "tool"), ("cup", "tool"))
    assert body.colliding_pairs([0.0, 0.0, 0.0]) == body.checked_pairs
    assert body.colliding_pairs([1.0, 0.0, 0.0]) == (("plate", "tool"), ("cup", "tool"))


def test_pairs_that_always_collide_may_touch() -> None:
    """A pair in contact all over the joints' ranges says nothing and is dropped; one that parts now and then stays."""
    always = model(table(SPHERE.format(1.5), SPHERE.format(1.5)))
    assert dict(always.table().allowed) == {("base", "tool"): "always"}
    assert always.checked_pairs == ()
    assert always.in_collision([0.0, 0.0]) is False
    assert always.distance([0.0, 0.0]) == np.inf
    assert always.nearest_pair([0.0, 0.0]) is None
    # Centres up to 2 * sqrt(2) apart, contact up to 2: free in 21 percent of the square.
    assert model(table(SPHERE.format(1.0), SPHERE.format(1.0))).checked_pairs == (("base", "tool"),)
    assert always.check("base", "tool").in_collision([0.0, 0.0]) is True


@pytest.mark.parametrize("as_file", [False, True])
def test_an_srdf_excuses_pairs(as_file: bool, tmp_path: Path) -> None:
    """Pairs of the SRDF may touch, in either order of names, and the geometry's own reasons stay."""
    text = (
        '<robot name="row"><disable_collisions link1="tool" link2="base" reason="Never"/>'
        '<disable_collisions link1="plate" link2="cup" reason="Adjacent"/></robot>'
    )
    path = tmp_path / "row.srdf"
    path.write_text(text)
    body = urdf_ik.load(ROW, srdf=path if as_file else text).cell.collisions
    assert body.table().allowed["base", "tool"] == "srdf"
    assert body.table().allowed["plate", "cup"] == "rigid"
    assert body.colliding_pairs([0.0, 0.0, 0.0]) == (("base", "carriage"), ("plate", "tool"), ("cup", "tool"))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            '<robot name="r">\n<disable_collisions link1="tool" link2="bas"/></robot>',
            r":2: .*no link bas; did you mean 'base'",
        ),
        ('<robot name="r"><disable_collisions', "<text>"),
        ('<!DOCTYPE r><robot name="r"/>', "DOCTYPE"),
        (ROW, "not an SRDF"),
    ],
)
def test_a_broken_srdf_is_refused(text: str, says: str) -> None:
    """An unknown link, broken XML, a DOCTYPE or a URDF is an error with its place and hint."""
    with pytest.raises(UrdfError, match=says):
        urdf_ik.load(ROW, srdf=text, strict=True)


def test_the_srdf_of_an_arm_excuses_its_pairs_wherever_the_arm_goes() -> None:
    """Of a loaded arm, with a tool, with a joint held; pairs of unknown links allow nothing."""
    pair, other = ("link_4", "link_6"), ("link_3", "link_5")
    disable = '<disable_collisions link1="{}" link2="{}"/>'
    srdf = f'<robot name="r">{disable.format(*pair)}{disable.format("link_1", "hand")}</robot>'
    arm = urdf_ik.load("zyyzyz_6r", srdf=srdf)
    plain = urdf_ik.load("zyyzyz_6r")
    assert (arm.base, arm.tip) == (plain.base, plain.tip)  # an SRDF without groups chooses no chain
    for each in (arm, arm.with_tool(np.eye(4)), arm.with_locked({"joint_1": 0.0})):
        pairs = each.cell.collisions.table()
        assert pairs.allowed[pair] == "srdf" and other in pairs.checked
    assert pair in plain.cell.collisions.checked_pairs
    q = np.array([0.0] * 6)
    assert plain.cell.nearest_pair(q).links == pair and arm.cell.nearest_pair(q).links == other
    with pytest.raises(UrdfError, match="the URDF has no link hand"):
        urdf_ik.load("zyyzyz_6r", srdf=srdf, strict=True)


# ---------------------------------------------------------------- shapes that are not there

SHEET = "solid s\n" + "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n" * 2 + "endsolid s\n"
MESH = SHEET.format(
    *(
        "".join(f"vertex {x} {y} 0\n" for x, y in corners)
        for corners in ([(0, 0), (1, 0), (0, 1)], [(0, 1), (1, 0), (1, 1)])
    )
)


def with_mesh(folder: Path, filename: str) -> CollisionModel:
    """A table whose second shape is a mesh, read from a file in ``folder``."""
    path = folder / "arm.urdf"
    path.write_text(table(SPHERE.format(0.1), f'mesh filename="{filename}"'))
    return CollisionModel(urdf.read(path))


@pytest.mark.parametrize("filename", ["a b/é%20.stl", "package://pack/é%20.stl"])
def test_a_mesh_beside_the_urdf(filename: str, tmp_path: Path) -> None:
    """A mesh, a unit square from its corner on, is found by a relative path and by its package."""
    folder = tmp_path / ("pack" if "://" in filename else "a b")
    folder.mkdir()
    (folder / "é%20.stl").write_text(MESH)
    body = with_mesh(tmp_path, filename)
    assert body.missing == ""
    assert body.distance([0.5, -0.5]) == pytest.approx(0.4, abs=2e-6)
    assert body.distance([0.5, 0.4]) == pytest.approx(math.hypot(0.5, 0.4) - 0.1, abs=2e-6)


@pytest.mark.parametrize(
    ("shapes", "says"),
    [
        (("", ""), "no link has a collision shape"),
        ((SPHERE.format(0.1), 'mesh filename="gone.stl"'), "gone.stl.*not found"),
        ((SPHERE.format(0.1), 'mesh filename="bad.stl"'), "cannot be read: .*bad.stl"),
        ((SPHERE.format(0.1), 'box size="1 1"'), "2 values instead of 3"),
    ],
)
def test_incomplete_geometry_is_said_and_never_called_free(shapes: tuple[str, str], says: str, tmp_path: Path) -> None:
    """Without shapes, or with one that cannot be read, there is a word on what is missing, and every check raises."""
    (tmp_path / "bad.stl").write_text("no mesh")
    (tmp_path / "arm.urdf").write_text(table(*shapes).replace(collision(""), ""))
    body = CollisionModel(urdf.read(tmp_path / "arm.urdf"))
    assert not body.has_geometry
    assert re.search(says, body.missing)
    q = [1.0, 0.0]
    for ask in (body.in_collision, body.distance, body.colliding_pairs, body.nearest_pair):
        with pytest.raises(UrdfError, match=says):
            ask(q)
    with pytest.raises(UrdfError, match=says):
        body.distance_with({name: np.eye(4) for name in ("base", "rail", "tool")})


@pytest.mark.parametrize("ending", ["stl", "obj"])
def test_hull_and_balls_from_the_cache_change_no_distance(
    ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mirrored, scaled body of 320 faces: distances are Pinocchio's, first and with a cache that knows the file."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    body = trimesh.creation.icosphere(subdivisions=2, radius=100.0)
    body.apply_transform(np.diag([1.0, 0.6, 0.3, 1.0]))
    body.apply_translation([30.0, 0.0, 0.0])
    body.export(tmp_path / f"body.{ending}")
    mesh = f'mesh filename="body.{ending}" scale="-0.001 0.001 0.001"'
    path = tmp_path / "arm.urdf"
    path.write_text(table(mesh, mesh))
    plain = pin.buildModelFromUrdf(str(path))
    shapes = pin.buildGeomFromUrdf(plain, str(path), pin.GeometryType.COLLISION, package_dirs=[str(tmp_path)])
    shapes.addCollisionPair(pin.CollisionPair(0, 1))
    places = np.random.default_rng(3).uniform(-0.4, 0.4, (30, 2))
    expected = []
    for q in places:
        data = shapes.createData()
        pin.computeDistances(plain, plain.createData(), shapes, data, q)
        expected.append(max(data.distanceResults[0].min_distance, 0.0))
    assert 0.0 < np.mean(np.array(expected) > 0.0) < 1.0
    for _ in range(2):
        checked = CollisionModel(urdf.read(path))
        np.testing.assert_allclose(checked.distance(places), expected, atol=2e-6)
        np.testing.assert_array_equal(checked.in_collision(places), np.array(expected) == 0.0)
    assert len(list((tmp_path / "cache").rglob("mesh*.npz"))) == 1


def test_a_mesh_in_mm_is_asked_about(tmp_path: Path) -> None:
    """A body of 100 mm that is read as 100 m is far larger than an arm with 0.4 m between its axes."""
    trimesh.creation.box([100.0, 80.0, 60.0]).export(tmp_path / "box.stl")
    joints = [joint("p", "revolute", "base", "arm", axis="0 0 1"),
              joint("q", "revolute", "arm", "hand", "0.4 0 0", axis="0 0 1")]  # fmt: skip
    for scale, asked in ((1.0, True), (0.001, False)):
        shape = collision(f'mesh filename="box.stl" scale="{scale} {scale} {scale}"')
        path = tmp_path / "arm.urdf"
        path.write_text(robot(*joints, base=shape, hand=shape))
        with warnings.catch_warnings(record=True) as seen:
            warnings.simplefilter("always")
            CollisionModel(urdf.read(path))
        assert [re.search("141 m wide.*in mm", str(each.message)) is not None for each in seen] == [True] * asked


# ---------------------------------------------------------------- against Pinocchio, asked plainly


@pytest.mark.parametrize(("name", "count"), [("zyyzyz_6r", 100), ("dh_6r", 100), ("ur5", 20)])
def test_same_as_pinocchio_without_shortcuts(name: str, count: int) -> None:
    """Verdict and distance equal those of all pairs, one by one, in Pinocchio's geometry of the file itself."""
    entry, body = catalogue.resolve(name), from_catalogue(name)
    plain = pin.buildModelFromUrdf(str(entry.path))
    geometry = pin.buildGeomFromUrdf(
        plain, str(entry.path), pin.GeometryType.COLLISION, package_dirs=[str(folder) for folder in entry.package_dirs]
    )
    owner = [plain.frames[shape.parentFrame].name for shape in geometry.geometryObjects]
    for i, a in enumerate(owner):
        for j, b in enumerate(owner[:i]):
            if (b, a) in body.checked_pairs or (a, b) in body.checked_pairs:
                geometry.addCollisionPair(pin.CollisionPair(j, i))
    data = plain.createData()
    rng = np.random.default_rng(6)
    verdicts = []
    for _ in range(count):
        q = rng.uniform(-3.0, 3.0, 6)
        asked = geometry.createData()
        hit = pin.computeCollisions(plain, data, geometry, asked, q, False)
        pin.computeDistances(plain, data, geometry, asked, q)
        distance = min(result.min_distance for result in asked.distanceResults)
        assert body.in_collision(q) == hit
        assert body.distance(q) == pytest.approx(max(distance, 0.0), abs=2e-6)
        verdicts.append(hit)
    assert 0 < sum(verdicts) < count


def test_a_link_out_of_place_is_seen() -> None:
    """A millimetre in one link's pose is a millimetre in the distance; a NaN pose is refused."""
    body = model(SPHERES)
    poses = {"base": np.eye(4), "rail": np.eye(4), "tool": np.eye(4)}
    poses["tool"][0, 3] = 1.0
    assert body.distance_with(poses) == pytest.approx(0.7, abs=1e-9)
    poses["tool"][0, 3] += 1e-3
    assert body.distance_with(poses) == pytest.approx(0.701, abs=1e-9)
    poses["tool"][0, 0] = np.nan
    with pytest.raises(PoseError, match="link 'tool' is not finite"):
        body.distance_with(poses)
