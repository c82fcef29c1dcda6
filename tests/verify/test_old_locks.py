"""Lock files that an earlier release wrote: each arm still has the answers of then.

They hold every kind of family, and a few poses each. `urdf-ik freeze` of commit 889e87b wrote them. An arm without a
name in the catalogue has its URDF beside its lock.
"""

from pathlib import Path

import pytest

import urdf_ik
from urdf_ik.verify.baselines import Lock

LOCKS = Path(__file__).parent.parent / "goldens" / "locks"


@pytest.mark.parametrize("path", sorted(LOCKS.glob("*.lock.json")), ids=lambda path: path.name.partition(".")[0])
def test_an_old_lock_verifies_and_is_written_the_same(path: Path) -> None:
    """Every pose has the solutions of then, and the lock is written as the same text."""
    name = path.name.removesuffix(".lock.json")
    urdf = path.with_name(f"{name}.urdf")
    lock = Lock.load(path)
    found = lock.verify(urdf_ik.load(urdf if urdf.is_file() else name))
    assert found.passed and found.poses == len(lock.poses), found
    assert all(note.startswith("contacts were not checked: no collision shapes") for note in found.notes), found
    assert lock.to_text() == path.read_text()
