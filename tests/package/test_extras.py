"""The command that installs a missing package, by how this copy was installed."""

from importlib import metadata
from pathlib import Path

import pytest

from urdf_ik.support import extras

REQUIRES = """Metadata-Version: 2.1
Name: urdf-ik
Requires-Dist: numpy
Requires-Dist: viser>=1.1; extra == "viewer"
Requires-Dist: pandas; extra == "notebooks"
Requires-Dist: urdf-ik[viewer]; extra == "notebooks"
"""


@pytest.mark.parametrize("url", [None, "file:///tmp/urdf_ik-0.1.0-cp311-cp311-linux_x86_64.whl", "file:///checkout"])
def test_a_missing_package_says_what_pip_can_install(
    url: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An index's copy is found by its name; for a wheel file or a checkout the packages themselves are named."""
    (tmp_path / "METADATA").write_text(REQUIRES)
    if url is not None:
        (tmp_path / "direct_url.json").write_text(f'{{"url": "{url}"}}')
    copy = metadata.PathDistribution(tmp_path)
    monkeypatch.setattr(metadata, "distribution", lambda name: copy)
    named = "'urdf-ik[notebooks]'" if url is None else "'pandas' 'viser>=1.1'"
    assert str(extras.missing("tables", "notebooks")) == f"tables: pip install {named}"
