"""What every test of pictures takes."""

import pytest

import urdf_ik


@pytest.fixture(autouse=True)
def _no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


@pytest.fixture(name="arm")
def _arm() -> urdf_ik.Arm:
    return urdf_ik.load("zyyzyz_6r")
