"""Pictures: what is drawn and how it is called, valid files; never how it looks."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
import trimesh
from chains import joint, robot
from command import call, succeed
from pictures import is_png, stick_lines

import urdf_ik
from urdf_ik.maps import workspaces
from urdf_ik.model import link_shapes
from urdf_ik.show import plot, shapes
from urdf_ik.show.plot import axes as draw

Q = (0.3, -0.5, 0.8, 0.4, 0.7, -0.2)


def test_the_stick_runs_through_the_links_frames(arm: urdf_ik.Arm) -> None:
    """From the base's origin to the tip's position, one point a link; the shapes are those of the URDF."""
    figure = plot.arm(arm, Q)
    (axes,) = figure.axes
    (line,) = stick_lines(axes)
    points = np.array(line.get_data_3d()).T
    links = arm.chain.links
    assert (links[0], links[-1]) == (arm.base, arm.tip) and len(points) == len(links)
    np.testing.assert_allclose(points, [arm.link_poses(Q)[link][:3, 3] for link in links])
    count = arm.model.xml.count(b"<visual>")
    assert len(axes.collections) == count > 5
    assert len(plot.arm(arm, Q, shapes=False).axes[0].collections) == 0
    assert axes.get_title() == arm.name


def test_triangles_lie_on_the_shapes() -> None:
    """Box corners at half the edges, cylinder and sphere points at the radius, wherever the link is."""

    def visual(inside: str) -> str:
        return f'<visual><origin xyz="0.1 0 0" rpy="0 0 1"/><geometry><{inside}/></geometry></visual>'

    arm = urdf_ik.load(
        robot(
            joint("a", "revolute", "base", "mid", "0 0 1", axis="0 1 0"),
            joint("b", "fixed", "mid", "tip", "0 0 0.5"),
            base=visual('box size="1 2 3"'),
            mid=visual('cylinder radius="0.2" length="0.6"'),
            tip=visual('sphere radius="0.3"'),
        )
    )
    q = np.array([0.7])
    poses = arm.link_poses(q)
    found = {}
    bodies, _ = shapes.bodies(arm)
    for (link, _), triangles in zip(bodies, shapes.placed(arm, bodies, q), strict=True):
        T = poses[link] @ urdf_ik.pose([0.1, 0.0, 0.0], rpy=[0.0, 0.0, 1.0])
        found[link] = (triangles.reshape(-1, 3) - T[:3, 3]) @ T[:3, :3]
    np.testing.assert_allclose(np.abs(found["base"]), np.broadcast_to([0.5, 1.0, 1.5], found["base"].shape))
    np.testing.assert_allclose(np.linalg.norm(found["tip"], axis=1), 0.3)
    radii = np.hypot(*found["mid"][:, :2].T)
    assert np.all(np.isclose(radii, 0.2) | np.isclose(radii, 0.0)) and np.isclose(radii, 0.2).any()
    np.testing.assert_allclose(np.abs(found["mid"][:, 2]), 0.3)


def test_meshes_are_drawn_with_few_faces_and_missing_ones_named(tmp_path: Path) -> None:
    """A ball of 20480 faces is drawn with a few hundred, all near its surface; a mesh that is not there is reported."""
    trimesh.creation.icosphere(subdivisions=5, radius=0.2).export(tmp_path / "ball.stl")
    drawn = '<visual><geometry><mesh filename="{}.stl" scale="2 2 2"/></geometry></visual>'
    turning = joint("a", "revolute", "base", "tip", "0 0 1", axis="0 1 0")
    (tmp_path / "meshes.urdf").write_text(robot(turning, base=drawn.format("ball") + drawn.format("nowhere")))
    arm = urdf_ik.load(tmp_path / "meshes.urdf")
    ((_, ball),), missing = shapes.bodies(arm)
    assert 100 < len(ball) <= link_shapes.COARSE
    radii = np.linalg.norm(ball.reshape(-1, 3), axis=1)
    assert np.abs(radii - 0.4).max() < 0.05
    assert len(missing) == 1 and "nowhere.stl" in missing[0]
    figure = plot.arm(arm)
    assert len(figure.axes[0].collections) == 1
    assert figure.get_supxlabel().startswith("1 shape not drawn; ") and "nowhere.stl" in figure.get_supxlabel()


def test_a_mesh_is_simplified_whatever_it_is_like() -> None:
    """A point, a flat one, loose triangles: never more faces than asked for, none outside; a small one stays."""
    rng = np.random.default_rng(0)
    loose = rng.normal(size=(3000, 3))
    flat = loose * [1.0, 1.0, 0.0]
    for vertices in (loose, flat, 0.0 * loose, loose + 1e6):
        mesh = trimesh.Trimesh(vertices, np.arange(3000).reshape(-1, 3), process=False)
        small = link_shapes.simplified(mesh, 100)
        assert len(small.faces) <= 100
        if len(small.faces):
            assert (small.bounds[0] >= mesh.bounds[0] - 1e-6).all() and (small.bounds[1] <= mesh.bounds[1] + 1e-6).all()
    cube = trimesh.creation.box([1, 1, 1])
    assert link_shapes.simplified(cube, 12) is cube


def test_every_branch_is_drawn_in_its_colour_with_its_name(arm: urdf_ik.Arm) -> None:
    """One picture a solution, titled, in the colour of its branch."""
    solutions = arm.ik(arm.fk(Q))
    colours = draw.colours(arm.structure.branches)
    assert len(set(colours.values())) == 8
    apart = plot.branches(solutions)
    assert [axes.get_title().replace("\n", ", ") for axes in apart.axes] == [one.branch for one in solutions]
    for axes, one in zip(apart.axes, solutions, strict=True):
        (single,) = stick_lines(axes)
        assert single.get_color() == colours[one.branch]
        np.testing.assert_allclose(np.array(single.get_data_3d())[:, -1], solutions.poses[:3, 3], atol=1e-9)
    # The same branch has the same colour when others are missing.
    few = solutions.within_limits(tol=-1.0)
    for axes, one in zip(plot.branches(few).axes, few, strict=True):
        assert stick_lines(axes)[0].get_color() == colours[one.branch]


def test_branches_that_collide_are_marked_beside_their_obstacles() -> None:
    """Exactly the colliding solutions are dashed and named so; the obstacles stand where the world has them."""
    arm, world = urdf_ik.load("puma_560"), urdf_ik.World()
    solutions = arm.ik(arm.fk(Q))
    elbow = arm.link_poses(next(iter(solutions)).q)["link_3"]
    world.add("ball", urdf_ik.Sphere(0.1), urdf_ik.pose(elbow[:3, 3]))
    world.add("cloud", urdf_ik.Points(np.eye(3), 0.01))
    hits = arm.cell.collisions.in_world(world).in_collision(np.stack([one.q for one in solutions]))
    assert hits.any() and not hits.all()
    for axes, hit in zip(plot.branches(solutions, world=world).axes, hits, strict=True):
        (line,) = stick_lines(axes)
        assert ("collision" in axes.get_title()) == hit == (line.get_linestyle() == "--")
        assert len(axes.collections) == len(world)
    plain = plot.branches(solutions.collision_free()).axes
    assert not any("collision" in axes.get_title() or axes.collections for axes in plain)


def test_solutions_of_a_position_are_drawn_with_their_own_frames() -> None:
    """Of an arm that controls a position: every stick ends there, and the frame at its tip is that of the solution."""
    arm, point = urdf_ik.load("positioning_3r"), np.array([0.3, 0.2, 0.4])
    solutions = arm.ik(point, task="position")
    apart = plot.branches(solutions)
    assert "4 solutions of one position" in apart.get_suptitle()
    for axes, one in zip(apart.axes, solutions, strict=True):
        (stick,) = stick_lines(axes)
        np.testing.assert_allclose(np.array(stick.get_data_3d())[:, -1], point, atol=1e-9)
        frame = [np.array(line.get_data_3d()).T for line in axes.lines if line is not stick]
        directions = np.array([(end - start) / np.linalg.norm(end - start) for start, end in frame])
        np.testing.assert_allclose(directions.T, arm.fk(one.q)[:3, :3], atol=1e-9)


def test_out_of_reach_there_is_nothing_to_draw(arm: urdf_ik.Arm) -> None:
    """The error tells why."""
    nothing = arm.ik(urdf_ik.pose([0.0, 0.0, 9.0]))
    for picture in (plot.branches, plot.limits):
        with pytest.raises(urdf_ik.ArgumentError, match="wrist centre"):
            picture(nothing)


def test_all_turns_of_all_solutions_are_marked() -> None:
    """Marks of a joint = its different values among the solutions with all their turns; bars = the limits."""
    arm = urdf_ik.load("dh_6r")
    solutions = arm.ik(urdf_ik.pose([0.5, 0.11, 0.26], quat_xyzw=[0, 0, 0.8, 0.6]))
    (axes,) = plot.limits(solutions, degrees=False).axes
    marked = np.concatenate([np.stack(line.get_data(), axis=-1) for line in axes.lines if line.get_marker() == "o"])
    turned = solutions.turns().to_array()
    for i in range(arm.dof):
        mine = np.unique(marked[np.rint(marked[:, 1]) == i, 0].round(9))
        np.testing.assert_allclose(mine, np.unique(turned[:, i].round(9)), atol=1e-8)
    bars = [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in axes.patches]
    np.testing.assert_allclose(bars, arm.limits)
    assert [text.get_text() for text in axes.get_yticklabels()] == list(arm.joint_names)


def test_values_without_a_turn_inside_are_crossed(arm: urdf_ik.Arm) -> None:
    """A solution out of limits has a cross at each joint that has no image inside."""
    T = arm.fk([0.1, 0.2, 0.3, 0.4, 2.15, 0.3])
    solutions = arm.ik(T)
    out = sum(int((np.abs(one.q) > arm.limits[:, 1] + 1e-9).sum()) for one in solutions)
    assert out > 0
    (axes,) = plot.limits(solutions).axes
    assert sum(len(line.get_xdata()) for line in axes.lines if line.get_marker() == "x") == out


def test_joints_that_slide_have_a_scale_of_their_own() -> None:
    """Turning joints in degrees above, sliding ones in m below; each mark is a solution, each bar the limits."""
    arm = urdf_ik.load("stanford_rrprrr")
    solutions = arm.ik(arm.fk([0.3, 0.8, 0.4, 0.5, 0.6, 0.7]))
    turning, sliding = plot.limits(solutions).axes
    assert (turning.get_xlabel(), sliding.get_xlabel()) == ("joint value [deg]", "joint value [m]")
    (k,) = np.flatnonzero(arm.chain.prismatic)
    assert [text.get_text() for text in sliding.get_yticklabels()] == [arm.joint_names[k]]
    (bar,) = sliding.patches
    np.testing.assert_allclose([bar.get_x(), bar.get_x() + bar.get_width()], arm.limits[k])
    marks = np.sort(np.concatenate([line.get_xdata() for line in sliding.lines]))
    np.testing.assert_allclose(marks, np.sort(solutions.to_array()[:, k]))
    assert len(turning.patches) == arm.dof - 1


def test_the_planar_workspace_has_both_regions_and_their_overlap() -> None:
    """Four labelled patches whose outlines are the regions' arcs, and the arm from axis to tip."""
    region = workspaces.planar(urdf_ik.load("planar_2r"))
    q = [0.5, -1.0]
    (axes,) = plot.planar_workspace(region, q).axes
    assert [patch.get_label() for patch in axes.patches] == ["elbow left", "elbow right", "both elbows", "boundary"]
    corners = axes.patches[-1].get_path().vertices
    for arc in region.boundary.arcs:
        gaps = np.linalg.norm(corners - arc.points(2)[:1], axis=1)
        assert gaps.min() < 1e-12
    (line,) = axes.lines
    np.testing.assert_allclose(np.array(line.get_data()).T[-1], region.tip(q))
    assert axes.get_xlabel() == "x [m]"


def test_a_layer_shows_the_maps_numbers(arm: urdf_ik.Arm) -> None:
    """The image holds the slice, at its place, with the value's name beside the colours."""
    found = workspaces.workspace(arm, 0.5, 8)
    figure = plot.workspace_slice(found, "y", 0.0, "solutions")
    axes, bar = figure.axes
    (image,) = axes.images
    layer = found.slice("y", 0.0, "solutions")
    np.testing.assert_array_equal(np.ma.filled(image.get_array(), np.nan), layer.values.T)
    assert tuple(image.get_extent()) == layer.extent
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "z [m]")
    assert bar.get_ylabel() == "mean number of solutions"


def test_pictures_are_written_as_their_names_say(tmp_path: Path, arm: urdf_ik.Arm) -> None:
    """PNG, SVG and PDF are what they claim to be; another ending, or a folder that is not there, is an error."""
    figure = plot.arm(arm, shapes=False)
    for suffix, check in (
        (".png", is_png),
        (".svg", is_svg),
        (".pdf", lambda data: data.startswith(b"%PDF-") and b"%%EOF" in data[-20:]),
    ):
        path = tmp_path / f"picture{suffix}"
        plot.save(figure, path)
        assert check(path.read_bytes())
    svg = ElementTree.parse(tmp_path / "picture.svg").getroot()
    assert svg.get("viewBox") and svg.findtext("{http://www.w3.org/2000/svg}title") == arm.name
    with pytest.raises(urdf_ik.ArgumentError, match=r"picture\.bmp.*\.png, \.svg, \.pdf"):
        plot.save(figure, tmp_path / "picture.bmp")
    with pytest.raises(urdf_ik.ArgumentError, match="cannot write"):
        plot.save(figure, tmp_path / "nowhere" / "picture.png")


def is_svg(data: bytes) -> bool:
    """Whether it is XML with <svg> at its root."""
    return ElementTree.fromstring(data).tag == "{http://www.w3.org/2000/svg}svg"


@pytest.mark.parametrize(
    "arguments",
    [
        ("zyyzyz_6r",),
        ("zyyzyz_6r", "branches", "--shapes", "--q", ",".join(map(str, Q))),
        ("dh_6r", "limits", "--xyz", "0.5,0.11,0.26", "--quat-xyzw", "0,0,0.8,0.6"),
        ("planar_2r", "workspace", "--q", "30,-40", "--degrees"),
        ("srs_7r", "intervals", "--q", "0.3,0.5,-0.4,0.9,0.2,-0.6,0.1"),
    ],
)
def test_the_command_writes_every_picture(arguments: tuple[str, ...], tmp_path: Path) -> None:
    """A PNG file, and not a word."""
    path = tmp_path / "picture.png"
    assert succeed("plot", *arguments, "-o", str(path)) == ""
    assert is_png(path.read_bytes())


def test_the_command_cuts_a_saved_map(tmp_path: Path) -> None:
    """`workspace -o` and `plot --map` go together; a layer outside the map, or a map of another arm, is an error."""
    path, picture = str(tmp_path / "map.npz"), str(tmp_path / "picture.svg")
    succeed("workspace", "zyyzyz_6r", "--voxel", "0.6", "--orientations", "5", "-o", path)
    succeed("plot", "zyyzyz_6r", "workspace", "--map", path, "--at", "1", "-o", picture)
    assert is_svg(Path(picture).read_bytes())
    result = call("plot", "zyyzyz_6r", "workspace", "--map", path, "--at", "50", "-o", picture)
    assert result.exit_code == 2 and "outside the map" in result.stderr
    result = call("plot", "puma_560", "workspace", "--map", path, "-o", picture)
    assert result.exit_code == 2 and "zyyzyz_6r" in result.stderr


def test_in_a_notebook_there_is_a_control_for_each_joint() -> None:
    """Where ipywidgets is installed: sliders over the limits, which start within them and move the arm."""
    ipywidgets = pytest.importorskip("ipywidgets")
    arm = urdf_ik.load("planar_2r")
    shown = plot.interact(arm, [0.2, -0.4])
    controls = [child for child in shown.children if isinstance(child, ipywidgets.FloatSlider)]
    assert [control.description for control in controls] == [f"{name} [°]" for name in arm.joint_names]
    np.testing.assert_allclose([(control.min, control.max) for control in controls], np.degrees(arm.limits))
    np.testing.assert_allclose([control.value for control in controls], np.degrees([0.2, -0.4]))
    with pytest.raises(urdf_ik.ArgumentError, match=r"'joint_1' is at .* outside its limits .*: sliders begin"):
        plot.interact(arm, [9.0, 0.0])
    controls[1].value = -90.0
    figure = shown.f(**{control.description.split(" ")[0]: control.value for control in controls})
    (line,) = stick_lines(figure.axes[0])
    tip = arm.solver.control.plane.coordinates(arm.fk([np.radians(controls[0].value), -0.5 * np.pi]))[:2]
    np.testing.assert_allclose(np.array(line.get_data())[:, -1], tip, atol=1e-12)


def test_a_notebook_shows_the_pictures(arm: urdf_ik.Arm) -> None:
    """Without pyplot: they give their own PNG."""
    assert is_png(plot.arm(arm, shapes=False)._repr_png_())
