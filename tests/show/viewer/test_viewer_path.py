"""The viewer with a plan and a world: what it shows at each waypoint, without a browser."""

from pathlib import Path

import numpy as np
import pytest
from chains import joint, robot
from command import ARM
from seams import blocked_plan, seam
from wire import PATIENCE, WirePage, wait

import urdf_ik
from urdf_ik import Arm, Box, Capsule, Cylinder, HalfSpace, Mesh, Plan, Points, Sphere, World
from urdf_ik.errors import ArgumentError
from urdf_ik.model import link_shapes
from urdf_ik.show.viewer import playback
from urdf_ik.show.viewer import state as states

pytest.importorskip("viser", reason="pip install viser")

from urdf_ik.show.shapes import triangles  # noqa: E402
from urdf_ik.show.viewer import Viewer  # noqa: E402


@pytest.fixture(scope="module")
def arm() -> Arm:
    """The arm of all plans here."""
    return urdf_ik.load(ARM)


@pytest.fixture(scope="module")
def plan(arm: Arm) -> Plan:
    """One that was found."""
    return arm.follow(seam())


@pytest.fixture(scope="module")
def blocked(arm: Arm) -> Plan:
    """One that was not, for a box on the way."""
    return blocked_plan(arm)


def test_the_arm_stands_where_the_plan_puts_it(arm: Arm, plan: Plan) -> None:
    """At a waypoint the plan's joint vector, and half way to the next one the middle of the motion between them."""
    state = states.start(arm)
    for place in (0, 7, 29):
        assert np.allclose(playback.at(plan, state, place).q, plan.q[place], rtol=0.0, atol=1e-12)
    assert len(plan.motion) == len(plan.q)  # nothing was put between
    half = playback.at(plan, state, 7.5)
    assert np.allclose(half.q, 0.5 * (plan.q[7] + plan.q[8]), rtol=0.0, atol=1e-12)
    assert np.allclose(arm.fk(half.q), half.target) and half.ghosts
    assert np.array_equal(playback.at(plan, state, 99.0).q, playback.at(plan, state, 29.0).q)


def test_without_a_plan_the_target_goes_along_the_path(arm: Arm, blocked: Plan) -> None:
    """The target is the waypoint."""
    assert not blocked.found
    state = states.start(arm, blocked.obstacles.model.world)
    assert np.array_equal(playback.at(blocked, state, 4.2).target, blocked.poses[4])


def test_a_world_marks_the_solutions_that_touch_it(arm: Arm, blocked: Plan) -> None:
    """At the box every solution inside the limits collides; without the world it does not."""
    world = blocked.obstacles.model.world
    inside = [
        [ghost.colliding for ghost in states.with_target(states.start(arm, each), blocked.poses[15]).ghosts]
        for each in (world, None)
    ]
    assert all(inside[0]) and not all(inside[1])


def test_a_player_passes_the_path_and_ends() -> None:
    """Places rise from where it begins to the last waypoint; from the end it begins anew."""
    places: list[float] = []
    ended: list[bool] = []
    player = playback.Player(places.append, lambda: ended.append(True))
    player.start(10, 8.0)
    wait(lambda: bool(ended))
    assert not player.playing and places[-1] == 10.0 and places[0] > 8.0 and places == sorted(places)
    player.start(10, 10.0)
    wait(lambda: places[-1] < 9.0)
    player.stop()
    assert not player.playing and len(ended) == 1


def test_the_page_plays_a_plan(arm: Arm, plan: Plan, blocked: Plan) -> None:
    """Slider, arm and path belong to the plan; another plan takes its place; another arm takes it away."""
    with Viewer(arm, port=0, plan=plan) as viewer, WirePage(viewer) as page:
        panel, line = viewer.path, viewer.path_line
        assert np.allclose(viewer.state.q, plan.q[0]) and panel.slider.max == 29.0
        assert np.allclose(line.points[:, 0], plan.poses[:-1, :3, 3], atol=1e-6)
        page.change("Waypoint", 12.0)
        wait(lambda: viewer.place == 12.0)
        assert viewer.settle(PATIENCE) and np.allclose(viewer.state.q, plan.q[12])
        viewer.go_to(28.5)
        assert viewer.settle(PATIENCE) and panel.slider.value == 28.5
        viewer.play()
        wait(lambda: viewer.place == 29.0 and panel.button.label == "Play")
        assert viewer.settle(PATIENCE) and np.allclose(viewer.state.q, plan.q[-1]) and panel.slider.value == 29.0
        viewer.play()
        assert panel.button.label == "Pause"
        viewer.play()
        assert panel.button.label == "Play"
        viewer.show_plan(blocked)
        assert viewer.settle(PATIENCE)
        assert all(str(stop.waypoint) in viewer.path.status.content for stop in blocked.stops)
        viewer.open("srs_7r")
        assert viewer.settle(PATIENCE) and viewer.plan is None
        viewer.play()  # nothing to play
        with pytest.raises(ArgumentError, match="one of zyyzyz_6r"):
            viewer.show_plan(plan)


def test_obstacles_stand_where_the_world_puts_them(arm: Arm, blocked: Plan, tmp_path: Path) -> None:
    """Every kind of shape is in the scene; what is moved or removed in the world is so there with the next view."""
    world = World()
    box = tmp_path / "box.stl"
    triangles(Box((0.1, 0.2, 0.3)), 1.0).export(box)
    shapes = [Box(0.1), Sphere(0.1), Cylinder(0.1, 0.4), Capsule(0.1, 0.4), HalfSpace((0, 0, 1)), Mesh(box, 2.0),
              Points(np.eye(3), 0.05)]  # fmt: skip
    for k, shape in enumerate(shapes):
        world.add(type(shape).__name__, shape, urdf_ik.pose([0.0, 5.0, float(k)]))
    with Viewer(arm, port=0, world=world) as viewer:
        handles = viewer.obstacles.handles
        assert list(handles) == list(world.names) and not viewer.obstacles.missing
        for each in world:
            assert np.allclose(handles[each.name].position, each.pose[:3, 3])
        assert np.allclose(np.ptp(handles["Mesh"].vertices, axis=0), (0.2, 0.4, 0.6), atol=1e-6)
        world.move("Sphere", urdf_ik.pose([1.0, 2.0, 3.0]))
        world.remove("Box")
        viewer.move_joint(0, 0.1)
        assert viewer.settle(PATIENCE)
        assert np.allclose(handles["Sphere"].position, (1.0, 2.0, 3.0)) and "Box" not in handles
    with Viewer(arm, port=0, plan=blocked) as viewer:  # the world of a plan comes with it
        assert list(viewer.obstacles.handles) == ["box"]


@pytest.mark.parametrize(
    ("shape", "size", "middle"),
    [
        (Box((1, 2, 3)), (1, 2, 3), (0, 0, 0)),
        (Sphere(0.5), (1, 1, 1), (0, 0, 0)),
        (Cylinder(0.5, 3), (1, 1, 3), (0, 0, 0)),
        (Capsule(0.5, 3), (1, 1, 4), (0, 0, 0)),
        (HalfSpace((0, 2, 0), 0.7), (8, 0.01, 8), (0, 0.695, 0)),
    ],
)
def test_shapes_are_drawn_in_their_size(shape: object, size: tuple[float, ...], middle: tuple[float, ...]) -> None:
    """Centred as coal has them; a half-space is a plate whose top is the plane."""
    low, high = triangles(shape, 2.0).bounds
    assert np.allclose(high - low, size, atol=0.01) and np.allclose(0.5 * (low + high), middle, atol=0.01)


def test_a_links_capsule_is_centred_too() -> None:
    """As a URDF's capsule is, whatever trimesh takes for its origin."""
    shape = '<visual><geometry><capsule radius="0.5" length="3"/></geometry></visual>'
    model = urdf_ik.load(robot(joint("j", "continuous", "a", "b", axis="0 0 1"), b=shape)).model
    for coarse in (True, False):
        (((_, mesh),), _) = link_shapes.read(model, coarse=coarse)
        assert np.allclose(mesh.bounds[:, 2], (-2.0, 2.0), atol=0.01)
