"""URDFs that are refused: what is broken, with its place and a hint, and what would be dangerous to read."""

from pathlib import Path

import pytest
from urdf_texts import TINY, arm, edited, refused

from urdf_ik.model.urdf import read

JOINT = '<joint name="turn">'
LIMIT = '<limit lower="-1" upper="2" effort="3" velocity="4"/>'
BROKEN = {
    # what is wrong: (line, old, new, line reported, element, words of the problem, words of the hint)
    "no robot name": (2, ' name="tiny"', "", 2, "<robot>", "no name", 'name="..."'),
    "unknown version": (2, "<robot", '<robot version="2.0"', 2, "<robot>", "'2.0'", "1.2"),
    "link without name": (4, ' name="arm"', "", 4, "<link>", "no name", 'name="..."'),
    "duplicated link": (4, '"arm"', '"base"', 4, '<link name="base">', "taken by line 3", "different name"),
    "reserved joint name": (7, '"turn"', '"universe"', 7, '<joint name="universe">', "Pinocchio's own", "another name"),
    "unknown type": (7, "revolute", "ball", 7, JOINT, "'ball'", "revolute, continuous, prismatic, fixed"),
    "no parent": (8, '<parent link="base"/>', "", 7, JOINT, "<parent> is missing", "<parent link="),
    "parent without link": (8, ' link="base"', "", 8, f"<parent> of {JOINT}", "link is missing", "<parent link="),
    "undeclared parent": (8, '"base"', '"bose"', 8, f"<parent> of {JOINT}", "'bose' is not declared", "base"),
    "two parents": (16, '"hand"', '"arm"', 16, '<child> of <joint name="slide">', "'turn' at line 7", "closed loop"),
    "cycle": (8, '"base"', '"tool"', 7, JOINT, "arm <- tool <- hand <- arm", "tree"),
    "several roots": (6, "/>", '/><link name="lost"/>', 6, '<link name="lost">', "base, lost", "fixed joints"),
    "NaN in xyz": (10, "0 0 1", "0 nan 1", 10, f"<origin> of {JOINT}", "'nan' is no finite number", "3 numbers"),
    "overflow in xyz": (10, "0 0 1", "0 0 1e400", 10, f"<origin> of {JOINT}", "'1e400'", "finite"),
    "two values in xyz": (10, '"0 0 1"', '"0 1"', 10, f"<origin> of {JOINT}", "2 values instead of 3", "3 numbers"),
    "commas in xyz": (10, "0 0 1", "0,0,1", 10, f"<origin> of {JOINT}", "'0,0,1'", "spaces"),
    "digits only Python reads": (10, "0 0 1", "0 0 1_0", 10, f"<origin> of {JOINT}", "'1_0'", "decimal"),
    "quaternion origin": (10, "rpy", 'quat_xyzw="0 0 0 1" rpy', 10, f"<origin> of {JOINT}", "quat_xyzw", "rpy"),
    "zero axis": (11, "0 0 1", "0 0 0", 11, f"<axis> of {JOINT}", "zero axis", "0 0 1"),
    "axis without xyz": (11, ' xyz="0 0 1"', "", 11, f"<axis> of {JOINT}", "xyz is missing", "3 numbers"),
    "lower above upper": (12, '"-1"', '"3"', 12, f"<limit> of {JOINT}", "lower 3 is greater than upper 2", "PyBullet"),
    "no effort": (12, ' effort="3"', "", 12, f"<limit> of {JOINT}", "no effort", "effort="),
    "no velocity": (12, ' velocity="4"', "", 12, f"<limit> of {JOINT}", "no velocity", "velocity="),
    "negative velocity": (12, '"4"', '"-4"', 12, f"<limit> of {JOINT}", "negative", "zero or more"),
    "no limit": (12, LIMIT, "", 7, JOINT, "revolute joint without <limit>", "continuous"),
    "mimic of nothing": (
        19, "turn", "trun", 19, '<mimic> of <joint name="slide">', "no such joint", "did you mean 'turn'"
    ),
    "mimic without joint": (19, 'joint="turn"', "", 19, '<mimic> of <joint name="slide">', "missing", "to follow"),
    "mimic of itself": (19, "turn", "slide", 19, '<mimic> of <joint name="slide">', "mimics itself", "by itself"),
    "mimic of a fixed joint": (
        7, "revolute", "fixed", 19, '<mimic> of <joint name="slide">', "a fixed joint, which does not move", "revolute"
    ),
    "circle of mimics": (
        12, "/>", '/><mimic joint="slide"/>', 12, f"<mimic> of {JOINT}", "turn -> slide -> turn", "by itself"
    ),
    "xacro in an origin": (10, "0 0 1", "0 0 ${height}", 10, f"<origin> of {JOINT}", "${height}", "end the file"),
    "xacro in a name": (4, '"arm"', '"$(arg prefix)arm"', 4, '<link name="$(arg prefix)arm">', "xacro", "end the file"),
    "xacro include": (3, "<link", "<xacro:include/><link", 3, "<xacro:include>", "xacro", "end the file"),
    "malformed": (9, '"arm"', "arm", 9, None, "malformed XML", "correct the XML"),
    "DOCTYPE": (2, "<robot", "<!DOCTYPE robot><robot", 2, "<!DOCTYPE>", "DOCTYPE is refused", "delete"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_what_is_broken_is_refused_with_place_and_mend(case: str) -> None:
    """Each defect is named with its line, its element, its value and a hint, all of them in the message."""
    line, old, new, reported, element, problem, hint = BROKEN[case]
    error = refused(edited(line, old, new))
    assert (error.source, error.line, error.element) == ("<text>", reported, element)
    assert problem in error.problem
    assert error.hint is not None
    assert hint in error.hint
    assert str(error).startswith(f"<text>:{reported}: {element or ''}")
    assert error.problem in str(error)
    assert error.hint in str(error)


def test_the_file_is_named_in_the_error(tmp_path: Path) -> None:
    """A refusal of a file begins with file:line, as compilers write it, whatever its line ends are."""
    path = tmp_path / "broken arm.urdf"
    path.write_bytes(edited(11, "0 0 1", "0 0 0").replace("\n", "\r\n").encode())
    for source in (path, str(path)):
        assert str(refused(source)).startswith(f"{path}:11: <axis> of {JOINT}: ")


def test_truncated_xml_is_refused_wherever_it_ends() -> None:
    """No beginning of a URDF short of its last tag is taken for a smaller robot."""
    end = TINY.index("</robot>") + len("</robot>")
    for length in range(len(TINY.split(">")[0]) + 1, end, 7):
        error = refused(TINY[:length])
        assert error.line is not None
        assert "malformed XML" in error.problem or "empty" in error.problem
    assert "</robot> is missing" in str(refused(TINY[: end - len("</robot>")]))


BILLION_LAUGHS = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">' + (
    "".join(f'<!ENTITY b{i} "{("&b" + (str(i - 1) if i else "") + ";") * 9}">' for i in range(12)) + "]>"
)


@pytest.mark.parametrize("doctype", ['<!DOCTYPE r [<!ENTITY b11 SYSTEM "file:///etc/passwd">]>', BILLION_LAUGHS])
def test_a_doctype_is_refused_before_an_entity_is_expanded(doctype: str) -> None:
    """No entity reaches a file, the network or the memory, behind any comment; the word in a comment is harmless."""
    text = f'<?xml version="1.0"?>\n<!-- <robot> -->\n{doctype}<robot name="&b11;"/>'
    assert refused(text).line == 3
    assert read("<!-- <!DOCTYPE robot> -->" + arm("j revolute a b")).root == "a"


@pytest.mark.parametrize(
    ("root", "words"),
    [("sdf", "this is SDF"), ("u:robot xmlns:u='x'", "URDF is one <robot"), ("launch", "launch file")],
)
def test_another_root_element_is_refused(root: str, words: str) -> None:
    """A model of another format is distinguished from a broken URDF."""
    error = refused(f"\n<{root}/>")
    assert (error.line, error.hint is not None and words in error.hint) == (2, True)


def test_a_robot_without_links_is_refused_and_one_link_is_enough() -> None:
    """The smallest robot is one link."""
    assert "no <link>" in str(refused('<robot name="r"/>'))
    assert read('<robot name="r"><link name="only"/></robot>').root == "only"


def test_a_cycle_off_the_root_is_refused() -> None:
    """A loop of links beside the tree, which Pinocchio drops in silence, is found and spelled out."""
    error = refused(arm("j revolute a b", "k revolute c d", "m revolute d c"))
    assert "cycle" in error.problem
    assert {"c", "d"} <= set(error.problem.replace("<-", " ").split())


def test_the_number_of_links_is_bounded() -> None:
    """500 links in a row are read, one more is refused, before a reader that would hang sees them."""
    chain = [f"j{i} fixed l{i} l{i + 1}" for i in range(500)]
    assert len(read(arm(*chain[:-1])).links) == 500
    error = refused(arm(*chain))
    assert "more than 500 links" in error.problem
    assert error.element == '<link name="l500">'
