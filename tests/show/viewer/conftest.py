"""What tests of the viewer take."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from urdf_ik import Arm

if TYPE_CHECKING:
    from urdf_ik.show.viewer import Viewer


@pytest.fixture
def viewer(arm: Arm) -> Iterator[Viewer]:
    """A running viewer of the file's own ``arm``."""
    from urdf_ik.show.viewer import Viewer

    with Viewer(arm, port=0) as running:
        yield running
