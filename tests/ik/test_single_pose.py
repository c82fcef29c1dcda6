"""The compiled answer to a single pose, whose arrays are made when they are asked for."""

import copy
import gc
import pickle
import weakref

import numpy as np

import urdf_ik


def test_solutions_of_a_single_pose_own_their_numbers() -> None:
    """The arrays of one pose's answer are those of a batch, and are shared with no other answer."""
    arm = urdf_ik.load("zyyzyz_6r")
    T = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
    target, kept = T.copy(), arm.ik(T[None])[0]
    s = arm.ik(T)
    T[:] = 0.0
    again = [s, copy.copy(s), copy.deepcopy(s), pickle.loads(pickle.dumps(s))]
    for each in again:
        np.testing.assert_array_equal(each.q, kept.q)
        np.testing.assert_array_equal(each.valid, kept.valid)
        np.testing.assert_array_equal(each.poses, target)
        assert each.branches == kept.branches and each.step is None and each.shape == ()
        assert each.q is each.q and not each.q.flags.writeable and not each.poses.flags.writeable
    q, at = s.q, weakref.ref(arm)
    del s, again, each, kept, arm
    gc.collect()
    assert at() is None and np.isfinite(q).all()
