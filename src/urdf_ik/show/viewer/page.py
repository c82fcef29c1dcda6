"""The viewer: a page in the browser with an arm, every solution of a target to drag, and sliders for its joints."""

import io
import os
import threading
from collections.abc import Callable, Hashable, Sequence
from contextlib import suppress
from functools import partial
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik import export
from urdf_ik.arm import Arm, load
from urdf_ik.cell import World
from urdf_ik.errors import ArgumentError, MissingPackage, UnsupportedArm, UrdfIkError
from urdf_ik.ik.solutions.tables import stick_picture
from urdf_ik.model.poses import pose
from urdf_ik.paths.planned_motion import Plan
from urdf_ik.show.viewer import guard, playback
from urdf_ik.show.viewer import state as states
from urdf_ik.show.viewer.arm_and_gizmo import Drawing
from urdf_ik.show.viewer.panels import READING, STYLE, Panel, PathPanel, WorkPanel, add_sources, plain
from urdf_ik.show.viewer.playback import Latest
from urdf_ik.show.viewer.state import State
from urdf_ik.show.viewer.surroundings import Obstacles, add_path, points_beside
from urdf_ik.support import extras
from urdf_ik.support.palette import colours


class Viewer:
    """A running server, its page and what it shows.

    Attributes:
        state: the arm, its target and their solutions; replaced as a whole, never changed.
        server: the viser server.
        drawing: what stands in the scene.
        panel: the widgets of the arm.
        work: the widgets to paste and copy.
        path: the widgets of the plan that is shown, or None.
        path_line: the path in the scene, or None.
        plan: the plan that is shown, or None.
        place: where on it the arm is; 2.5 is half way from waypoint 2 to waypoint 3.
        obstacles: the world in the scene.
        message: what the last request for another arm came to.
    """

    def __init__(
        self,
        arm: Arm,
        *,
        port: int | None = None,
        mesh_roots: Sequence[str | os.PathLike[str]] = (),
        plan: Plan | None = None,
        world: World | None = None,
    ) -> None:
        """Start the server.

        Args:
            arm: what to show first.
            port: on this machine; None: 8080, or the first free one after it; 0: any free one.
            mesh_roots: folders that meshes of arms that the page asks for may be read from.
            plan: of ``arm.follow``, found or not, to be played along its waypoints.
            world: obstacles to show; a solution that touches one is marked. Default: those of the plan.

        Raises:
            MissingPackage: viser is not installed, or is one whose requests cannot be checked.
            ArgumentError: the port is in use, or the plan is another arm's.
        """
        try:
            import viser as _  # noqa: F401
        except ImportError:
            raise extras.missing("the viewer needs viser, which is not installed", "viewer") from None
        guard.require_free(port)
        self._mesh_roots = tuple(mesh_roots)
        self.message = ""
        if plan is not None and plan.obstacles is not None and world is None:
            world = plan.obstacles.model.world
        self.state = states.start(arm, world)
        self.plan: Plan | None = None
        self.place = 0.0
        self._height = 640
        self.path: PathPanel | None = None
        self.path_line: Any = None
        self._player = playback.Player(self.go_to, self._ended)
        self._token = guard.token()
        self.server = guard.start(self._token, guard.DEFAULT_PORT if port is None else port)
        self._latest = Latest(lambda: self.panel.show_intervals(self.state))
        if port and self.port != port:  # somebody took it since it was looked at
            self.close()
            raise ArgumentError(f"port {port} is in use; name another one, or leave it out")
        self.server.gui.configure_theme(control_width="large", show_share_button=False)
        self.server.gui.add_html(STYLE, order=-1e9)
        self.server.scene.add_grid("/grid", width=4.0, height=4.0, cell_size=0.1, section_size=0.5)
        self._message = self.server.gui.add_markdown("")
        self._show_arm(self.state)
        add_sources(self.server.gui, self.open, lambda: self.state.arm.name, self.html)
        frame = self.server.gui.add_command("Frame arm, path and obstacles", hotkey="F")
        frame.on_trigger(lambda event: self._ask_for_view(event.client))
        self.server.on_client_connect(self._greet)
        try:
            if plan is not None:
                self.show_plan(plan)
        except UrdfIkError:
            self.close()
            raise
        self._latest.put("start", lambda: None)  # the intervals are drawn after a request
        self.settle()

    def __enter__(self) -> "Viewer":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def port(self) -> int:
        """The port that the server really listens on."""
        return int(self.server.get_port())

    @property
    def url(self) -> str:
        """Address of the page, for a browser on this machine; who knows its token may use the page."""
        return f"http://{guard.HOST}:{self.port}/{self._token}/"

    def close(self) -> None:
        """Stop the server."""
        self._player.stop()
        self._latest.close()
        with guard.quiet():
            self.server.stop()

    def show(self, height: int = 640) -> "Viewer":
        """The viewer itself, which a notebook shows as the page, ``height`` pixels high.

        The browser must reach the address of the page: where the notebook runs on another machine, forward its port.
        Where it does not answer, as in an exported notebook, the cell holds a picture of the arm and its solutions.
        """
        self._height = height
        return self

    def _repr_html_(self) -> str:
        size = f'width="100%" height="{self._height}" style="border:0"'
        return f'<object type="text/html" data="{escape(self.url)}" {size}>{picture(self.state)}</object>'

    def wait(self) -> None:
        """Wait until the program is interrupted (Ctrl-C), then stop the server."""
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            pass
        finally:
            self.close()

    def settle(self, timeout: float | None = None) -> bool:
        """Wait until all that was asked for is shown; false if that takes longer than ``timeout`` [s]."""
        return self._latest.settle(timeout)

    def html(self) -> str:
        """The page of :func:`urdf_ik.export.html`; where there is none, or with a path or a world: the scene."""
        if self.path is None and self.state.world is None:
            with suppress(MissingPackage, UnsupportedArm):
                return str(export.html(self.state.arm, q=self.state.q))
        target = self.drawing.target
        target.visible = False  # handles that would move nothing
        try:
            return str(self.server.scene.as_html())
        finally:
            target.visible = True

    def move_target(self, T: NDArray[np.float64]) -> None:
        """Move the target to the pose (4, 4) [m]; the arm follows to the nearest solution inside its limits."""
        self._update("target", lambda state: states.with_target(state, T))

    def move_joint(self, index: int, value: float) -> None:
        """Set one joint [rad or m], and the target with the arm."""
        self._update(("joint", index), lambda state: states.with_joint(state, index, value))

    def choose(self, column: int) -> None:
        """Move the arm to the solution of that branch."""
        self._update("branch", lambda state: states.with_branch(state, column))

    def show_plan(self, plan: Plan | None) -> None:
        """Show another plan of this arm, with its path and, where it was not found, why.

        Raises:
            ArgumentError: the plan is another arm's.
        """
        if plan is not None and plan.solver is not self.state.arm.solver:
            raise ArgumentError(f"the plan is one of {plan.solver.name}, not of the arm that is shown")
        self._latest.put("plan", lambda: self._show_plan(plan))

    def go_to(self, place: float) -> None:
        """Go to a place of the plan that is shown; 2.5 is half way from waypoint 2 to waypoint 3."""
        self._latest.put("place", lambda: self._go_to(place))

    def play(self) -> None:
        """Play the plan that is shown, from where it is; pause it where it is being played."""
        if self.plan is None:
            return
        playing = self._player.playing
        if self.path is not None:  # before it is played: its end is shown, too
            self.path.show_playing(not playing)
        if playing:
            self._player.stop()
        else:
            self._player.start(playback.last(self.plan), self.place)

    def open(self, source: str | bytes, base: str | None = None, tip: str | None = None) -> None:
        """Show another arm: a path, a catalogue name, or a URDF's text as bytes; what goes wrong stands in the page."""
        self._latest.put("arm", lambda: self._open(source, base, tip))

    def _open(self, source: str | bytes, base: str | None, tip: str | None) -> None:
        self._say("Loading ...")
        try:
            given = io.BytesIO(source) if isinstance(source, bytes) else source
            state = states.start(load(given, base, tip, mesh_roots=self._mesh_roots), self.state.world)
        except (UrdfIkError, OSError) as error:
            return self._say(str(error))
        except Exception as error:
            self._say(f"a defect of this program; the terminal says more: {error!r}")
            raise
        self._show_plan(None)
        self.drawing.remove()
        self.panel.remove()
        self.work.remove()
        self.obstacles.remove()
        self._show_arm(state)
        return None

    def _say(self, text: str) -> None:
        self.message = text
        self._message.content = "\n\n".join(plain(line) for line in text.splitlines())

    def _show_arm(self, state: State) -> None:
        """Build scene and panel of another arm."""
        self.state, arm = state, state.arm
        self.drawing = Drawing(self.server.scene, arm)
        self.panel = Panel(self.server.gui, arm, self.choose, self._slid, self._turned)
        self.obstacles = Obstacles(self.server.scene, state.world, arm.chain.size)
        self.work = WorkPanel(self.server.gui, arm, lambda step: self._update(object(), step), self._say)
        self._say("\n".join([*self.drawing.unseen, *self.obstacles.missing.values()]))
        self.drawing.target.on_update(self._dragged)
        first = self.server.initial_camera
        with self.server.atomic():
            first.position, first.look_at = self.view(first.fov)
        self._frame(*self.server.get_clients().values())
        self._show(state)

    def view(self, fov: float, aspect: float | None = None) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Where a camera stands, and what it looks at, to see all there is; ``aspect`` is its window's."""
        beside = points_beside(self.plan, self.state.world, self.state.arm.chain.size)
        return self.drawing.camera(self.state, fov, aspect, beside)

    def _greet(self, client: Any) -> None:
        """Have a new page see the whole arm, also after it went to viser's first view: a slow one does so late."""

        async def moved(camera: Any) -> None:
            first = self.server.initial_camera
            if np.allclose(camera.position, first.position) and np.allclose(camera.look_at, first.look_at):
                self._ask_for_view(client)

        client.camera.on_update(moved)
        self._ask_for_view(client)

    def _ask_for_view(self, client: Any) -> None:
        if client is not None:
            self._latest.put(("view", client.client_id), lambda: self._frame(client))

    def _frame(self, *clients: Any) -> None:
        """Have pages see the whole arm, path and obstacles."""

        def turn(client: Any, position: NDArray[np.float64], look_at: NDArray[np.float64]) -> None:
            with suppress(UserWarning):  # viser warns of each message to a closed page
                if client.client_id in self.server.get_clients():
                    client.camera.position, client.camera.look_at = position, look_at

        for client in clients:
            view = self.view(client.camera.fov, client.camera.aspect)
            self.server.get_event_loop().call_soon_threadsafe(turn, client, *view)

    def _show(self, state: State, held: object = None) -> None:
        """Show ``state`` in everything but ``held``, which the reader is moving and which may be further on."""
        self.state = state
        with self.server.atomic():
            self.drawing.show(state, keep_target=held is self.drawing.target)
            self.panel.show(state, keep=held)
            self.work.show(state)
            self.obstacles.update()
        self.server.flush()

    def _show_plan(self, plan: Plan | None) -> None:
        self._player.stop()
        for part in (self.path, self.path_line):
            if part is not None:
                part.remove()
        self.path = self.path_line = None
        self.plan = plan
        if plan is None:
            return
        self.path = PathPanel(self.server.gui, plan, self._scrubbed, self.play)
        self.path_line = add_path(self.server.scene, plan)
        self._go_to(0.0)
        self._frame(*self.server.get_clients().values())

    def _go_to(self, place: float, *, scrubbed: bool = False) -> None:
        """Show a place of the plan; where it was chosen with the slider, that is left alone."""
        if self.plan is None or self.path is None:
            return
        self.place = place
        self._show(playback.at(self.plan, self.state, place))
        if not scrubbed:
            self.path.show(place)

    def _scrubbed(self, place: float) -> None:
        self._player.stop()
        self._ended()
        self._latest.put("place", lambda: self._go_to(place, scrubbed=True))

    def _ended(self) -> None:
        if self.path is not None:
            self.path.show_playing(False)

    def _update(self, key: Hashable, step: Callable[[State], State], held: object = None) -> None:
        arm = self.state.arm

        def do() -> None:
            if self.state.arm is not arm:  # the page has gone on to another one
                return
            try:
                self._show(step(self.state), held)
            except UrdfIkError as error:  # a value that no widget gives
                self._say(str(error))

        self._latest.put(key, do)

    def _dragged(self, _: Any) -> None:
        handle = self.drawing.target

        def step(state: State) -> State:  # a click moves nothing
            return state if np.allclose(T, state.target, rtol=0.0, atol=1e-9) else states.with_target(state, T)

        with READING:
            try:
                T = pose(np.array(handle.position), quat_wxyz=np.array(handle.wxyz))
            except UrdfIkError as error:
                self._say(str(error))
            else:
                self._update("target", step, handle)

    def _slid(self, index: int, value: float) -> None:
        step = partial(states.with_joint, index=index, value=value)
        self._update(("joint", index), step, self.panel.sliders[index])

    def _turned(self, which: int, value: float) -> None:
        change = partial(states.with_redundancy, value=value, which=which)
        self._update("redundancy", change, self.panel.redundancies[which])


def picture(state: State) -> str:
    """The arm and every solution of its target as stick figures, and what they are."""
    arm = state.arm
    figures = np.array([*(ghost.q for ghost in state.ghosts), state.q])
    shades = [*colours(len(state.ghosts)), (0.0, 0.0, 0.0)]
    count = len(state.ghosts)
    words = f"{arm.name}: {count} solution{'' if count == 1 else 's'} of the target, and the arm in black"
    return (
        f"<figure>{stick_picture(arm.chain, figures, shades)}"
        f"<figcaption>{escape(words)}. The page itself needs the viewer to run.</figcaption></figure>"
    )
