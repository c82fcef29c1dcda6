"""Lock files that an earlier release wrote: each arm still has the answers of then.

`urdf-ik freeze` of commit 889e87b wrote them, and a few of the poses of each were kept. An arm without a name in the
catalogue has its URDF beside its lock.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import urdf_ik
from urdf_ik.verify.baselines import Baseline

LOCKS = Path(__file__).parent.parent / "goldens" / "locks"


@pytest.mark.parametrize("path", sorted(LOCKS.glob("*.lock.json")), ids=lambda path: path.name.partition(".")[0])
def test_an_old_lock_verifies_and_is_written_the_same(path: Path) -> None:
    """Closed forms, rounded, calibrated, general, few and seven joints, slides, mimicry; today's text is that of then."""
    name = path.name.removesuffix(".lock.json")
    urdf = path.with_name(f"{name}.urdf")
    lock = Baseline.load(path)
    found = lock.verify(urdf_ik.load(urdf if urdf.is_file() else name))
    assert found.passed and found.poses == len(lock.poses), found
    assert all(note.startswith("contacts were not checked: no collision shapes") for note in found.notes), found
    assert lock.to_text() == path.read_text()
