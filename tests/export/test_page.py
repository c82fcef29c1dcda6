"""The page that needs no server, in Chromium from file:// without a network: what it solves and refuses."""

from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import CHROMIUM, INSTALL, PATIENCE, chromium
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.errors import ArgumentError, MissingPackage
from urdf_ik.export import html
from urdf_ik.export.page import WEB, bodies

Array = NDArray[np.float64]

BUILT = all((WEB / name).is_file() for name in ("urdf_ik.wasm", "page.bundle.js"))
pytest.importorskip("playwright.sync_api", reason=INSTALL)
WHY = INSTALL if BUILT else "make wasm page builds what is tested"


def needs_page(test: Any) -> Any:
    """Mark a test that opens the page in Chromium."""
    return pytest.mark.slow(pytest.mark.skipif(not BUILT or CHROMIUM is None, reason=WHY)(test))


POSES = 200
READY = "document.documentElement.dataset.ready || document.getElementById('refused')"
# Of poses (m, 16): the joint vector before, and how many solutions the page lists then.
COUNTS = """([poses, redundancy]) => poses.map((T, i) => {
    if (redundancy) urdfIk.state.redundancy = redundancy[i];
    const {q} = urdfIk.state;
    urdfIk.state.moveTarget(T);
    return [q, document.querySelectorAll('#solutions li').length];
})"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium without a network."""
    with chromium() as started:
        yield started


@pytest.fixture
def tab(browser: Any) -> Iterator[Any]:
    """An empty tab that is offline."""
    context = browser.new_context(viewport={"width": 1000, "height": 640}, offline=True)
    page = context.new_page()
    page.set_default_timeout(1000.0 * PATIENCE)
    page.problems = []
    page.on("pageerror", lambda problem: page.problems.append(str(problem)))
    yield page
    assert page.problems == []
    context.close()


def opened(tab: Any, arm: urdf_ik.Arm, folder: Path, hash_: str = "") -> Any:
    """The tab with the arm's page, from disk."""
    file = folder / "arm.html"
    if not file.is_file():
        file.write_text(html(arm))
    tab.goto(file.as_uri() + hash_)
    tab.wait_for_function(READY)
    return tab


def reached(arm: urdf_ik.Arm, m: int) -> tuple[Array, Array | None]:
    """Poses (m, 4, 4), a fifth of them round and singular, and values (m, p) of what they leave free."""
    q = np.random.default_rng(5).uniform(-3.0, 3.0, (m, arm.dof))
    q[::5] = np.round(q[::5] / (np.pi / 2)) * (np.pi / 2)
    T = arm.fk(q)
    return T, None if arm.redundancy is None else np.asarray(arm.solver.redundant_member.value_of(q, T)).reshape(m, -1)


@needs_page
@pytest.mark.parametrize("name", ["zyyzyz_6r", "srs_7r"])
def test_the_page_counts_what_python_counts(tab: Any, name: str, tmp_path: Path) -> None:
    """Of 200 poses of a 6R and a 7R the page lists as many solutions as ``arm.ik`` has."""
    arm = urdf_ik.load(name)
    T, values = reached(arm, POSES)
    page = opened(tab, arm, tmp_path)
    seen = page.evaluate(COUNTS, [T.reshape(POSES, 16).tolist(), None if values is None else values.tolist()])
    free = [None] * POSES if values is None else values[:, 0].tolist()
    # On a continuum there are representatives near where the arm stands.
    expected = [len(arm.ik(pose, q_ref=q, redundancy=at)) for pose, at, (q, _) in zip(T, free, seen, strict=True)]
    assert [count for _, count in seen] == expected


@needs_page
def test_a_dragged_target_is_reached(tab: Any, tmp_path: Path) -> None:
    """The mouse drags a handle of the target; the arm's tip follows, as the URDF's forward kinematics say."""
    arm = urdf_ik.load("zyyzyz_6r")
    page = opened(tab, arm, tmp_path)
    before = np.array(page.evaluate("urdfIk.state.T"))
    # Along the handle of x: from a place on it, as the camera sees it.
    at = page.evaluate("""() => {
        const {view} = urdfIk, box = view.renderer.domElement.getBoundingClientRect();
        view.scene.updateMatrixWorld();
        const size = view.handles.getHelper().children[0].gizmo.translate.children.find(each => each.name === 'X');
        const at = new size.position.constructor(0.3, 0, 0).applyMatrix4(size.matrixWorld).project(view.camera);
        return [box.x + (at.x + 1) / 2 * box.width, box.y + (1 - at.y) / 2 * box.height];
    }""")
    page.mouse.move(*at)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(at[0] + 4 * k, at[1] + 3 * k)
    page.mouse.up()
    T, q = (np.array(page.evaluate(f"urdfIk.state.{name}")) for name in "Tq")
    assert np.abs(T - before).max() > 1e-3
    assert np.abs(arm.fk(q).ravel() - T).max() < 1e-9
    assert page.locator("#solutions li").count() == len(arm.ik(T.reshape(4, 4)))


@needs_page
def test_sliders_branches_and_typed_poses(tab: Any, tmp_path: Path) -> None:
    """A slider moves its joint, a branch is chosen by its name, and a typed pose is solved or refused in words."""
    arm = urdf_ik.load("srs_7r")
    page = opened(tab, arm, tmp_path)
    T = page.evaluate("urdfIk.state.T")
    page.get_by_label("swivel").fill("0.7")
    assert page.evaluate("urdfIk.state.T") == T and page.evaluate("urdfIk.state.redundancy") == [0.7]
    page.get_by_label("joint_2", exact=True).fill("0.4")
    assert page.evaluate("urdfIk.state.q[1]") == 0.4
    names = page.locator("#solutions button").all_inner_texts()
    assert set(names) <= set(arm.structure.branches) and len(names) == 8
    page.locator("#solutions button").nth(5).click()
    q = page.evaluate("urdfIk.state.q")
    assert np.abs(arm.fk(q).ravel() - page.evaluate("urdfIk.state.T")).max() < 1e-9
    page.locator("#pose").fill("0.3 0.2 0.9 0 3.0 0.1")
    page.locator("#pose").press("Enter")
    typed = urdf_ik.pose([0.3, 0.2, 0.9], rpy=[0.0, 3.0, 0.1])
    assert np.abs(np.reshape(page.evaluate("urdfIk.state.T"), (4, 4)) - typed).max() < 1e-12
    page.locator("#pose").fill("0.3 0.2 high")
    page.locator("#pose").press("Enter")
    assert page.locator("#error").inner_text() == 'no pose: "high" is no number'


@needs_page
def test_a_link_holds_the_pose(tab: Any, tmp_path: Path) -> None:
    """A page that is opened by another one's link shows the same joint vector and target; a wrong link is named."""
    arm = urdf_ik.load("zyyzyz_6r")
    page = opened(tab, arm, tmp_path)
    page.evaluate("urdfIk.state.moveJoints([0.1, -0.9, 1.1, 0.3, 0.6, -0.2])")
    page.evaluate("""() => {
        Object.defineProperty(navigator, 'clipboard', {value: {writeText: async text => { window.kept = text; }}});
    }""")
    page.get_by_text("copy link").click()
    page.wait_for_function("window.kept")
    link = page.evaluate("window.kept")
    page.goto("about:blank")
    opened(page, arm, tmp_path, "#" + link.partition("#")[2])
    assert page.evaluate("urdfIk.state.q") == [0.1, -0.9, 1.1, 0.3, 0.6, -0.2]
    page.goto("about:blank")
    opened(page, arm, tmp_path, "#q=1,2")
    assert page.locator("#error").inner_text() == "the link: the link's q has 2 numbers; this arm needs 6"


@needs_page
def test_a_urdf_that_changed_is_noticed(tab: Any, tmp_path: Path) -> None:
    """A URDF that is dropped onto the page is compared by its hash with the one that the page was made from."""
    urdf = tmp_path / "arm.urdf"
    urdf.write_bytes(urdf_ik.load("zyyzyz_6r").model.xml)
    arm = urdf_ik.load(urdf)
    page = opened(tab, arm, tmp_path)
    drop = """text => {
        const data = new DataTransfer();
        data.items.add(new File([text], 'arm.urdf'));
        window.dispatchEvent(new DragEvent('drop', {dataTransfer: data}));
    }"""
    page.evaluate(drop, urdf.read_text())
    page.get_by_text("arm.urdf is the URDF that this page was made from").wait_for()
    page.evaluate(drop, urdf.read_text() + "<!-- later -->")
    page.get_by_text("arm.urdf is not the URDF that this page was made from").wait_for()


@pytest.mark.parametrize("faces", [300, 3000])
def test_shapes_have_as_few_triangles_as_asked_for(faces: int) -> None:
    """Of an arm whose meshes have more."""
    arm = urdf_ik.load("ur5")
    some, many = ([len(b64decode(body["faces"])) // 12 for body in bodies(arm, most)] for most in (faces, 12_000))
    assert all(some) and sum(some) <= faces < sum(many) <= 12_000


def test_what_a_page_is_not_made_of(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Wrong options and an installation without its parts are refused in words."""
    arm = urdf_ik.load("planar_2r")
    with pytest.raises(ArgumentError, match="faces=0 given; a whole number from 200"):
        html(arm, faces=0)
    monkeypatch.setattr("urdf_ik.export.page.WEB", tmp_path)
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "page.css").write_text("")
    with pytest.raises(MissingPackage, match=r"urdf_ik\.wasm is missing .*: `make wasm page`"):
        html(arm)
