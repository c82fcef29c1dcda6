"""What tests of the viewer take."""

from collections.abc import Iterator

import pytest

from urdf_ik import Arm


@pytest.fixture
def viewer(arm: Arm) -> Iterator[object]:
    """A running viewer of the file's own ``arm``."""
    from urdf_ik.show.viewer import Viewer

    with Viewer(arm, port=0) as running:
        yield running
