"""Sliders and windows: in a notebook, without a display, and on a display that nobody sees."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator

import matplotlib
import numpy as np
import pytest
from pictures import is_png, stick_lines
from typer.testing import CliRunner

import urdf_ik
from urdf_ik.cli import app
from urdf_ik.show import plot


@pytest.mark.parametrize("name", ["planar_2r", "zyyzyz_6r", "scara_rrpr"])
def test_sliders_move_the_arm(name: str) -> None:
    """One slider a joint over its limits; moving one moves the tip to where forward kinematics has it."""
    arm = urdf_ik.load(name)
    held = plot.sliders(arm, window=False)
    assert [slider.label.get_text() for slider in held.sliders] == list(arm.joint_names)
    scale = np.where(arm.chain.prismatic, 1.0, 180.0 / np.pi)
    np.testing.assert_allclose([(s.valmin, s.valmax) for s in held.sliders], scale[:, None] * arm.limits)
    target = arm.limits[:, 0] + 0.3 * np.ptp(arm.limits, axis=1)
    for slider, value in zip(held.sliders, scale * target, strict=True):
        slider.set_val(value)
    np.testing.assert_allclose(held.q, target)
    (line,) = stick_lines(held.figure.axes[0])
    if name == "planar_2r":
        tip = arm.solver.control.plane.coordinates(arm.fk(target))[:2]
        np.testing.assert_allclose(np.array(line.get_data())[:, -1], tip)
        assert len(held.figure.axes[0].patches) == 4
    else:
        np.testing.assert_allclose(np.array(line.get_data_3d())[:, -1], arm.fk(target)[:3, 3], atol=1e-12)


def test_sliders_begin_where_they_were_asked_to_or_say_why_not() -> None:
    """At joint values within the limits; outside them no slider can stand, and none is moved without a word."""
    arm = urdf_ik.load("zyyzyz_6r")
    q = 0.999 * arm.limits[:, 1]
    held = plot.sliders(arm, q, window=False)
    np.testing.assert_allclose([slider.val for slider in held.sliders], np.degrees(q))
    q[4] = arm.limits[4, 1] + 0.01
    with pytest.raises(urdf_ik.ArgumentError, match=r"'joint_5' is at .* outside its limits .*: sliders begin"):
        plot.sliders(arm, q, window=False)
    text = urdf_ik.load("planar_2r_unit").model.xml.decode().replace('type="revolute"', 'type="continuous"')
    wound = plot.sliders(urdf_ik.load(re.sub(r"<limit[^>]*/>", "", text)), [4.0, -7.0], window=False)
    np.testing.assert_allclose([slider.val for slider in wound.sliders], np.degrees([4.0, -7.0]))


def test_in_a_notebook_there_is_a_control_for_each_joint() -> None:
    """Where ipywidgets is installed: sliders over the limits, which start within them and move the arm."""
    ipywidgets = pytest.importorskip("ipywidgets")
    arm = urdf_ik.load("planar_2r")
    shown = plot.interact(arm, [0.2, -0.4])
    controls = [child for child in shown.children if isinstance(child, ipywidgets.FloatSlider)]
    assert [control.description for control in controls] == [f"{name} [°]" for name in arm.joint_names]
    np.testing.assert_allclose([(control.min, control.max) for control in controls], np.degrees(arm.limits))
    np.testing.assert_allclose([control.value for control in controls], np.degrees([0.2, -0.4]))
    controls[1].value = -90.0
    figure = shown.f(**{control.description.split(" ")[0]: control.value for control in controls})
    (line,) = stick_lines(figure.axes[0])
    tip = arm.solver.control.plane.coordinates(arm.fk([np.radians(controls[0].value), -0.5 * np.pi]))[:2]
    np.testing.assert_allclose(np.array(line.get_data())[:, -1], tip, atol=1e-12)


def test_a_notebook_shows_the_pictures(arm: urdf_ik.Arm) -> None:
    """Without pyplot: they give their own PNG."""
    assert is_png(plot.arm(arm, shapes=False)._repr_png_())
    assert is_png(plot.sliders(arm, window=False).figure._repr_png_())


WINDOWS = """
import sys
import numpy as np
import matplotlib
matplotlib.use("tkagg")
import urdf_ik
from urdf_ik.show import plot
arm = urdf_ik.load(sys.argv[1])
held = plot.sliders(arm)
window, canvas = held.figure.canvas.manager.window, held.figure.canvas
done = []
def pull():
    if not window.winfo_viewable():
        return  # the timer comes again
    timer.stop()
    window.update()
    row = held.sliders[0].ax.get_window_extent()
    y = canvas.figure.bbox.height - 0.5 * (row.y0 + row.y1)
    for event, share in (("<Button-1>", 0.5), ("<B1-Motion>", 0.6), ("<ButtonRelease-1>", 0.6)):
        canvas.get_tk_widget().event_generate(event, x=int(row.x0 + share * row.width), y=int(y))
    window.update()
    done.extend([window.winfo_viewable(), window.wm_title(), *np.degrees(held.q).round(1)])
    canvas.manager.destroy()
timer = canvas.new_timer(500)
timer.add_callback(pull)
timer.start()
plot.show(held.figure)
print(*done, sep=";")
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["planar_2r", "zyyzyz_6r"])
def test_a_slider_is_pulled_in_a_real_window(name: str, display: str) -> None:
    """On a display: the window opens, the mouse moves the first joint by a tenth of its range, closing it goes on."""
    environment = os.environ | {"DISPLAY": display}
    command = [sys.executable, "-c", WINDOWS, name]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120.0, check=False)
    assert done.returncode == 0, done.stderr
    visible, title, *degrees = done.stdout.strip().split(";")
    lower, upper = np.degrees(urdf_ik.load(name).limits[0])
    assert visible == "1" and title == f"urdf-ik: {name}"
    assert float(degrees[0]) == pytest.approx(lower + 0.6 * (upper - lower), abs=0.01 * (upper - lower))
    assert all(float(value) == 0.0 for value in degrees[1:])


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """A display that nobody sees."""
    pytest.importorskip("tkinter", reason="windows are not tested: apt-get install python3-tk")
    server = shutil.which("Xvfb")
    if server is None:
        pytest.skip("windows are not tested: apt-get install xvfb")
    reader, writer = os.pipe()
    with subprocess.Popen([server, "-displayfd", str(writer), "-screen", "0", "1200x1000x24"], pass_fds=[writer],
                          stderr=subprocess.DEVNULL) as running:  # fmt: skip
        os.close(writer)
        with os.fdopen(reader) as numbers:
            yield f":{numbers.readline().strip()}"
        running.terminate()


def test_a_window_without_a_display_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error says so, and what to do; with a display but no toolkit, too."""
    arm = urdf_ik.load("planar_2r")
    with pytest.raises(urdf_ik.ArgumentError, match="no display.*--output"):
        plot.sliders(arm)
    with pytest.raises(urdf_ik.ArgumentError, match="no display"):
        plot.show(plot.arm(arm))
    monkeypatch.setenv("DISPLAY", ":99")
    with matplotlib.rc_context({"backend": "agg"}), pytest.raises(urdf_ik.ArgumentError, match="'agg'.*no windows"):
        plot.sliders(arm)
    monkeypatch.delenv("DISPLAY")
    result = CliRunner().invoke(app, ["plot", "planar_2r", "sliders"])
    assert result.exit_code == 2 and "no display" in result.stderr
