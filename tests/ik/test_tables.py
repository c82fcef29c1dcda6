"""Answers as data frames and HTML: the same values, names that cannot break a page."""

from xml.etree import ElementTree

import numpy as np
import pytest

import urdf_ik
from urdf_ik.model import catalogue

Q = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])


@pytest.fixture(scope="module")
def arm() -> urdf_ik.Arm:
    """An arm with limits that exclude some of its solutions."""
    return urdf_ik.load("puma_560")


def test_a_frame_has_a_row_a_solution(arm: urdf_ik.Arm) -> None:
    """Joint values, branches and limits are those of the solutions, for one pose and for a stack of stacks."""
    pytest.importorskip("pandas")
    s = arm.ik(arm.fk(Q))
    frame = s.to_frame()
    columns = [f"q{k}" for k in range(1, 7)]
    np.testing.assert_array_equal(frame[columns].to_numpy(), s.q[s.valid])
    assert frame.attrs["joints"] == dict(zip(columns, arm.joint_names, strict=True))
    np.testing.assert_array_equal(frame["limit_margin"], arm.limit_margin(s.to_array()))
    np.testing.assert_array_equal(frame["manipulability"], arm.manipulability(s.to_array()))
    assert list(frame["contact"]) == list(arm.cell.collisions.in_collision(s.to_array()))
    assert list(frame["branch"]) == [one.branch for one in s]
    kept = {one.branch for one in s.within_limits()}
    assert 0 < len(kept) < 8 and set(frame["branch"][frame["within_limits"]]) == kept
    stack = np.stack([[Q, 1.1 * Q, 1.2 * Q], [0.9 * Q, 0.8 * Q, 0.7 * Q]])
    batch = arm.ik(arm.fk(stack))
    frame = batch.to_frame()
    assert len(frame) == batch.count.sum()
    row = frame[(frame["pose_0"] == 1) & (frame["pose_1"] == 2)].iloc[0]
    np.testing.assert_array_equal(row[columns].to_numpy(float), batch[1, 2][0].q)
    assert row["pose"] == 5


def test_frames_of_two_arms_go_together(arm: urdf_ik.Arm) -> None:
    """Joints of other names, and of another number, stand in the same columns; what is not known is missing."""
    pandas = pytest.importorskip("pandas")
    other = urdf_ik.load("panda")
    poses = other.fk(np.array([[0.0, -0.3, 0.0, -2.0, 0.0, 1.8, 0.5]] * 2))
    frames = [arm.ik(arm.fk(Q)).to_frame(contacts=False), other.ik(poses, redundancy=[0.4, 0.5]).to_frame()]
    both = pandas.concat(frames)
    assert set(both["arm"]) == {"puma_560", "panda"}
    assert both["q7"].isna().sum() == len(frames[0]) == both["contact"].isna().sum()
    assert set(frames[1]["redundancy"]) == {0.4, 0.5} and set(frames[1]["pose"]) == {0, 1}
    assert frames[0].attrs["contacts"] == "not asked for" and frames[1].attrs["contacts"] == ""


def test_an_answer_says_at_which_value_it_is(arm: urdf_ik.Arm) -> None:
    """Printed, as a line and as HTML: the redundancy parameter, its value and unit; nothing without one."""
    other = urdf_ik.load("panda")
    s = other.ik(other.fk([0.0, -0.3, 0.0, -2.0, 0.0, 1.8, 0.5]), redundancy=0.5)
    assert "solutions at panda_joint7 = 0.5000 rad" in str(s) and "panda_joint7 = 28.65 deg" in s.table(degrees=True)
    assert "panda_joint7 = 0.5000 rad" in repr(s) and "panda_joint7 = 0.5000 rad" in s._repr_html_()
    assert " at " not in str(arm.ik(arm.fk(Q))).splitlines()[0]
    assert "no solution at panda_joint7 = 0.5000 rad" in str(other.ik(urdf_ik.pose([9.0, 0, 0]), redundancy=0.5))


def test_puma_straight_wrist_is_a_word_in_the_frame(arm: urdf_ik.Arm) -> None:
    """A straight wrist stands in the frame as a word."""
    pytest.importorskip("pandas")
    q = Q * [1, 1, 1, 1, 0, 1]
    assert "WRIST" in set(arm.ik(arm.fk(q)).to_frame()["singular"])


def test_html_is_well_formed_and_names_are_escaped() -> None:
    """A name in a URDF is text in the page, whatever it holds; tables and pictures can be parsed."""
    text = catalogue.resolve("puma_560").path.read_text()
    evil = "&lt;script&gt;x()&lt;/script&gt;"
    arm = urdf_ik.load(text.replace('name="joint_1"', f'name="{evil}"').replace('name="puma_560"', 'name="a&lt;b"'))
    assert arm.joint_names[0] == "<script>x()</script>"
    answers = [arm, arm.ik(arm.fk(Q)), arm.ik(arm.fk(np.stack([Q, Q]))), arm.ik(urdf_ik.pose([9.0, 0.0, 0.0]))]
    for shown in answers:
        page = shown._repr_html_()
        assert "<script" not in page and "a&lt;b" in page
        ElementTree.fromstring(page.replace("&#9679;", "o"))
    assert answers[1]._repr_html_().count("<tr>") == 9
    assert "2 poses, 2 solved, 16 solutions" in answers[2]._repr_html_()
    assert "no solution" in answers[3]._repr_html_()
