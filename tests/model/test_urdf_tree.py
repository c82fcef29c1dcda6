"""The tree of links: the default chain, names that are not there, parents and children."""

import pytest
from urdf_texts import arm

from urdf_ik.errors import ChainError
from urdf_ik.model.urdf import read

BRANCHED = arm(
    "stand fixed world base_link",
    "j1 revolute base_link link1",
    "j2 continuous link1 link2",
    "flange fixed link2 flange",
    "tool fixed flange tool0",
    "camera fixed link2 camera",
    "lamp fixed base_link lamp",
)


def test_the_only_movable_chain_is_the_default() -> None:
    """From the root to the one leaf that moves; fixed leaves elsewhere do not make it ambiguous."""
    model = read(arm("s fixed world b", "j revolute b c", "k prismatic c d", "t fixed d tool", "l fixed b lamp"))
    assert model.resolve_chain() == ("world", "tool")
    assert model.resolve_chain(base="c") == ("c", "tool")
    assert model.resolve_chain(tip="c") == ("world", "c")
    assert model.resolve_chain("tool", "lamp") == ("tool", "lamp")
    assert [joint.name for joint in model.path_between("b", "tool")] == ["j", "k", "t"]
    assert model.path_between("b", "b") == ()


def test_several_leaves_on_the_last_link_are_ambiguous() -> None:
    """Plates and cameras fixed to the last moving link are candidates, unless one of them is named as a tool frame."""
    two = arm("j revolute base link", "p fixed link plate", "t fixed plate torch", "c fixed link camera")
    with pytest.raises(ChainError, match=r"4 links, all fixed to 'link'.*candidates: link, plate, camera, torch"):
        read(two).resolve_chain()
    assert read(BRANCHED).resolve_chain() == ("world", "tool0")


def test_several_movable_chains_are_ambiguous() -> None:
    """Two arms list their tips; below one of the shoulders the chain is clear, and either has a name."""
    model = read(arm("l revolute torso left", "r revolute torso right", "rh fixed right hand", "h fixed torso head"))
    with pytest.raises(ChainError, match="2 movable chains.*'left': torso to left, 1 joint; 'right'") as caught:
        model.resolve_chain()
    assert caught.value.candidates == ("left", "hand")
    assert model.resolve_chain(tip="left") == model.resolve_chain(chain="left") == ("torso", "left")


def test_without_a_moving_joint_there_is_no_chain() -> None:
    """A rigid body, or a base at the very end, is refused in words."""
    with pytest.raises(ChainError, match="no movable chain"):
        read(arm("j fixed a b", "k floating b c")).resolve_chain()
    with pytest.raises(ChainError, match="below base 'tool0'.*--tip") as caught:
        read(BRANCHED).resolve_chain(base="tool0")
    assert caught.value.candidates == ()  # another base is another frame


@pytest.mark.parametrize("role", ["base", "tip"])
def test_unknown_names_list_the_candidates(role: str) -> None:
    """A name that is not there brings the links with the closest first."""
    model = read(BRANCHED)
    with pytest.raises(ChainError, match=f"no {role} link 'tol0'; did you mean 'tool0'") as caught:
        model.resolve_chain(**{role: "tol0"})
    assert caught.value.candidates[0] == "tool0"
    assert set(caught.value.candidates) == set(model.links)
    with pytest.raises(ChainError, match="no link 'tol0'"):
        model.children("tol0")
    with pytest.raises(ChainError, match=f"no {role} link 'tol0'"):
        model.path_between(**{"base": "world", "tip": "lamp", role: "tol0"})


def test_the_tree_is_walked_both_ways() -> None:
    """Parents and children are those of the file, in its order."""
    model = read(BRANCHED)
    assert model.parent_joint("world") is None
    assert model.parent_joint("tool0") is model.joints[4]
    assert [joint.child for joint in model.children("link2")] == ["flange", "camera"]
    assert model.children("tool0") == ()
    for base, tip, names in [
        ("world", "link1", ["stand", "j1"]),
        ("link1", "world", ["j1", "stand"]),
        ("link2", "lamp", ["j2", "j1", "lamp"]),
        ("camera", "tool0", ["camera", "flange", "tool"]),
        ("lamp", "lamp", []),
    ]:
        assert [joint.name for joint in model.path_between(base, tip)] == names
