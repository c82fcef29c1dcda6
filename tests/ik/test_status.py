"""The status of a pose belongs to the pose: filters and parts of a batch keep it."""

import numpy as np

import urdf_ik


def test_filters_and_parts_keep_the_status() -> None:
    """What is known about a pose does not depend on the solutions that are picked."""
    arm = urdf_ik.load("puma_560")
    q = np.tile([0.3, -0.5, 0.8, 0.4, 0.7, -0.2], (4, 1))
    q[1::2, 4] = 0.0  # a straight wrist leaves joint 4 free
    whole = arm.ik(arm.fk(q).reshape(2, 2, 4, 4))
    assert whole.status.tolist() == [["complete", "continuum"]] * 2
    for s in (whole, whole.within_limits(), whole.turns(), whole.nearest(np.zeros(6))):
        assert s.status.tolist() == whole.status.tolist()
        assert s.certain.tolist() == whole.certain.tolist() == [[True, False]] * 2
        assert s[1].within_limits().status.tolist() == ["complete", "continuum"]
        assert str(s[0, 1].status) == "continuum"
