"""Pictures in a notebook."""

import numpy as np
import pytest
from pictures import is_png, stick_lines

import urdf_ik
from urdf_ik.show import plot


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
