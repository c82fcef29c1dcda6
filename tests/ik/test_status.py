"""The status of a pose: four words, kept by filters, parts of a batch and copies."""

import copy
import pickle

import numpy as np
import pytest

import urdf_ik
from urdf_ik.ik.solutions import IKSolutions

WORDS = {0: "complete", 32: "incomplete", 64: "clustered", 96: "continuum"}


@pytest.fixture(scope="module")
def arm() -> urdf_ik.Arm:
    """An arm with limits that exclude some of its solutions."""
    return urdf_ik.load("puma_560")


@pytest.fixture(scope="module")
def every_status(arm: urdf_ik.Arm) -> IKSolutions:
    """The same pose with each of the statuses."""
    s = arm.ik(np.tile(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]), (len(WORDS), 1, 1)))
    info = s._info.copy()
    info[:, 0] |= np.array(list(WORDS), np.uint8)
    return IKSolutions(s.solver, s.poses, s.q, info, s.branches)


def test_the_flags_of_the_first_column_hold_the_status(every_status: IKSolutions) -> None:
    """Two bits make four words; the other bits stay what they are."""
    assert every_status.status.tolist() == list(WORDS.values())
    assert every_status.certain.tolist() == [True, False, True, False]
    assert every_status.valid.all() and not every_status.singular.any()


def test_filters_parts_and_copies_keep_the_status(every_status: IKSolutions) -> None:
    """What is known about a pose does not depend on the solutions that are picked."""
    words = list(WORDS.values())
    for s in (every_status.within_limits(), every_status.turns(), every_status.nearest(np.zeros(6))):
        assert s.status.tolist() == words
    for s in (pickle.loads(pickle.dumps(every_status)), copy.deepcopy(every_status)):
        assert s.status.tolist() == words
    assert [str(s.status) for s in (every_status[k] for k in range(4))] == words
    assert every_status[1:3].within_limits().status.tolist() == words[1:3]
