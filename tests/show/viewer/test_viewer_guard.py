"""Who may talk to the viewer: the page at the printed address, and nobody whom another web page sends."""

from __future__ import annotations

import contextlib
import gc
import math
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik import Arm, MissingPackage

viser = pytest.importorskip("viser", reason="pip install viser")

import msgspec.msgpack  # noqa: E402  they come with viser
import zstandard  # noqa: E402
from websockets.exceptions import ConnectionClosed, InvalidStatus  # noqa: E402
from websockets.sync.client import connect  # noqa: E402

from urdf_ik.show.viewer import Viewer, guard  # noqa: E402
from urdf_ik.show.viewer.work import uploads  # noqa: E402

PATIENCE = 60.0
PROTOCOL = f"viser-v{viser.__version__}"


@pytest.fixture(scope="module")
def arm() -> Arm:
    """Small, so that a page is quickly there."""
    return urdf_ik.load("planar_2r")


def page(viewer: Viewer, **options: Any) -> Any:
    """A connection as the page opens it."""
    own = f"http://127.0.0.1:{viewer.port}"
    options = {"origin": own, "subprotocols": [PROTOCOL], "max_size": None} | options
    return connect(options.pop("url", viewer.url.replace("http", "ws")), **options)


def send(connection: Any, kind: str, **fields: Any) -> None:
    """A message as the page writes it."""
    connection.send(msgspec.msgpack.encode({"type": kind, **fields}))


def wait(what: Callable[[], object]) -> bool:
    """Whether ``what()`` comes true."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if what():
            return True
        time.sleep(0.02)
    return False


def begin(connection: Any, viewer: Viewer, size: int, parts: int, transfer: str = "t") -> None:
    """Announce a file."""
    uuid = viewer.sources[1]._impl.uuid
    send(connection, "FileTransferStartUpload", source_component_uuid=uuid, transfer_uuid=transfer, filename="a.urdf",
         mime_type="", part_count=parts, size_bytes=size)  # fmt: skip


def part(connection: Any, viewer: Viewer, index: int, content: bytes, transfer: str = "t") -> None:
    """Send a part of a file."""
    uuid = viewer.sources[1]._impl.uuid
    send(connection, "FileTransferPart", source_component_uuid=uuid, transfer_uuid=transfer, part_index=index,
         content=content)  # fmt: skip


def test_the_page_itself_is_let_in(viewer: Viewer) -> None:
    """With the printed address, from a browser on this machine; also by 'localhost', and through a forwarded port."""
    with page(viewer) as connection:
        assert connection.recv(timeout=PATIENCE)
    host = f"localhost:{viewer.port}"
    with page(viewer, url=viewer.url.replace("http://127.0.0.1", "ws://localhost"), origin=f"http://{host}") as other:
        assert other.recv(timeout=PATIENCE)


@pytest.mark.parametrize("origin", ["https://example.org", "http://127.0.0.1:1", "http://localhost", "null", "file://"])
def test_other_pages_are_refused(viewer: Viewer, origin: str) -> None:
    """Even one that knows the token: its Origin is another."""
    with pytest.raises(InvalidStatus, match="403"), page(viewer, origin=origin):
        pass


@pytest.mark.parametrize(
    "host", ["attacker.example", "attacker.example:8080", "127.0.0.1.attacker.example", "127.0.0.1@x", "192.0.2.7", ""]
)
def test_other_names_of_this_machine_are_refused(viewer: Viewer, host: str) -> None:
    """A name that was made to lead here (DNS rebinding) is not this server's, for a page as for a socket."""
    request = urllib.request.Request(viewer.url, headers={"Host": host})
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(request, timeout=PATIENCE)


@pytest.mark.parametrize("path", ["", "/", "/?token=", "/" + "A" * 32, "/" + "A" * 32 + "/", "//", "/%00", "/\u00e4"])
def test_without_the_token_nothing_is_answered(viewer: Viewer, path: str) -> None:
    """Neither the page nor the socket."""
    start = f"127.0.0.1:{viewer.port}{path}".encode().decode("ascii", "replace").replace("\ufffd", "%c3")
    with pytest.raises(urllib.error.HTTPError, match="403") as refused:
        urllib.request.urlopen(f"http://{start}", timeout=PATIENCE)
    assert b"address that was printed" in refused.value.read()
    with pytest.raises(InvalidStatus, match="403"), page(viewer, url=f"ws://{start}"):
        pass


def test_tokens_differ_and_cannot_be_guessed(arm: Arm, viewer: Viewer) -> None:
    """Two viewers have two, of 192 random bits."""
    with Viewer(arm, port=0) as other:
        tokens = [one.url.rstrip("/").rpartition("/")[2] for one in (viewer, other)]
        assert tokens[0] != tokens[1] and all(len(token) == 32 for token in tokens)


def test_no_tunnel_is_opened_for_a_page(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    """A page cannot publish the server, as viser would let it."""
    asked = []
    monkeypatch.setattr(viewer.server, "request_share_url", lambda *_, **__: asked.append(1))
    with page(viewer) as connection:
        send(connection, "ShareUrlRequest")
        send(connection, "ShareUrlDisconnect")
        begin(connection, viewer, 9, 1)  # comes after them
        assert wait(lambda: viewer.uploads.unfinished)
    assert not asked and viewer.server._share_tunnel is None


def test_a_page_cannot_have_files_of_this_machine_read(viewer: Viewer, arm: Arm, tmp_path: Any) -> None:
    """What the page chooses is a name of the catalogue; a path in its place is not looked at."""
    file = tmp_path / "secret.urdf"
    file.write_text('<robot name="secret"><link name="a"/></robot>')
    dropdown = viewer.sources[0]
    with page(viewer) as connection:
        for value in (str(file), "/etc/passwd", "no/such"):
            send(connection, "GuiUpdateMessage", uuid=dropdown._impl.uuid, updates={"value": value})
        begin(connection, viewer, 9, 1)
        assert wait(lambda: viewer.uploads.unfinished)
        assert viewer.settle(PATIENCE) and viewer.state.arm is arm and not viewer.message.startswith(str(file))


def test_an_uploaded_urdf_is_shown(viewer: Viewer) -> None:
    """In parts, in any order."""
    text = b'<robot name="sent"><link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/>' \
           b'<child link="b"/></joint></robot>'  # fmt: skip
    with page(viewer) as connection:
        begin(connection, viewer, len(text), 2)
        part(connection, viewer, 1, text[50:])
        part(connection, viewer, 0, text[:50])
        assert wait(lambda: viewer.state.arm.name == "sent")
        assert not viewer.uploads.unfinished


def test_a_file_that_is_too_large_is_refused_before_it_is_kept(viewer: Viewer) -> None:
    """By what it says of its size; one that says less and sends more is dropped; so is a huge message."""
    with page(viewer) as connection:
        begin(connection, viewer, uploads.MAX_BYTES + 1, 40)
        assert wait(lambda: "larger than 16 MiB" in viewer.message) and not viewer.uploads.unfinished
        begin(connection, viewer, 10, 2)
        assert wait(lambda: viewer.uploads.unfinished)
        part(connection, viewer, 0, bytes(11))
        assert wait(lambda: not viewer.uploads.unfinished)
        with pytest.raises(ConnectionClosed):
            part(connection, viewer, 0, bytes(guard.MAX_MESSAGE + 1))
            while True:
                connection.recv(timeout=PATIENCE)


def test_unfinished_files_go_with_their_page(viewer: Viewer) -> None:
    """A page has one file on its way, and leaves nothing behind."""
    with page(viewer) as connection:
        for transfer in ("a", "b", "c"):
            begin(connection, viewer, 2**20, 2, transfer)
        part(connection, viewer, 0, bytes(2**19), "c")
        assert wait(lambda: any(file.received for file in viewer.uploads.unfinished.values()))
        assert len(viewer.uploads.unfinished) == 1
    assert wait(lambda: not viewer.uploads.unfinished)
    assert wait(lambda: gc.collect() >= 0 and not viewer.server.gui._current_file_upload_states)  # viser's own neither


def looking(connection: Any) -> None:
    """A client counts for viser once it has said where its camera is."""
    send(connection, "ViewerCameraMessage", wxyz=[1, 0, 0, 0], position=[1, 1, 1], fov=1.0, near=0.1, far=9.0,
         image_height=10, image_width=10, look_at=[0, 0, 0], up_direction=[0, 0, 1])  # fmt: skip


@pytest.mark.parametrize("value", [float("nan"), float("inf"), "abc", None, True, [0.1], {"a": 1}, 1e300, ""], ids=repr)
def test_senseless_values_of_a_slider_change_nothing(
    viewer: Viewer, value: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    """The page says what was dropped, slider and arm stay, nothing is printed."""
    before, slider = viewer.state.q.copy(), viewer.panel.sliders[0]
    shown = slider.value
    with page(viewer) as connection:
        looking(connection)
        assert wait(viewer.server.get_clients)
        send(connection, "GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": value})
        assert wait(lambda: "a page sent" in viewer.message)
    assert (viewer.state.q == before).all() and slider.value == shown
    assert not capfd.readouterr().err


@pytest.mark.parametrize("position", [[float("nan"), 0, 0], ["a", "b", "c"], [1.0], 3, None], ids=repr)
def test_senseless_targets_change_nothing(viewer: Viewer, position: Any, capfd: pytest.CaptureFixture[str]) -> None:
    """The handle and the target stay where they are, nothing is printed."""
    before = viewer.state.target.copy()
    with page(viewer) as connection:
        looking(connection)
        assert wait(viewer.server.get_clients)
        send(connection, "TransformControlsUpdateMessage", name="/target", wxyz=[1, 0, 0, 0], position=position)
        assert wait(lambda: viewer.message or not viewer.server.get_clients())  # refused, or sent away
    assert (viewer.state.target == before).all() and np.isfinite(viewer.drawing.target.position).all()
    assert "Traceback" not in capfd.readouterr().err


def values_seen(connection: Any, uuid: str) -> list[float]:
    """The values of a widget that a page is sent, until nothing is sent for a second."""
    messages: list[Any] = []
    with contextlib.suppress(TimeoutError):
        while True:
            data = connection.recv(timeout=1.0)
            packed = data[16 : 16 + int.from_bytes(data[8:16], "little")]
            messages += msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(packed))["messages"]
    return [m["updates"]["value"] for m in messages if m.get("uuid") == uuid and "value" in m.get("updates", ())]


def test_two_pages_that_fight_agree_with_the_arm_in_the_end(viewer: Viewer) -> None:
    """Both move both sliders as fast as they can; afterwards each was last sent where the arm is."""
    sliders = viewer.panel.sliders
    with page(viewer) as one, page(viewer) as other:
        for connection in (one, other):
            looking(connection)
        assert wait(lambda: len(viewer.server.get_clients()) == 2)
        for k in range(100):
            for slider, first, second in ((sliders[0], 0.001, -0.002), (sliders[1], -0.003, 0.004)):
                send(one, "GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": first * k})
                send(other, "GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": second * k})
        for connection in (one, other):
            begin(connection, viewer, 9, 1)  # is read after all of them
        assert wait(lambda: len(viewer.uploads.unfinished) == 2)
        last = {one: math.nan, other: math.nan}

        def agree() -> bool:
            for connection in last:
                last[connection] = [last[connection], *values_seen(connection, sliders[0]._impl.uuid)][-1]
            off = [abs(slider.value - value) for slider, value in zip(sliders, viewer.state.q, strict=True)]
            return max(off) <= 0.0005 + 1e-9 and set(last.values()) == {sliders[0].value}

        assert wait(agree)


def test_a_viser_that_listens_in_another_way_is_refused(arm: Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rather no viewer than one that lets everybody in."""
    monkeypatch.setattr(guard.Guard, "active", property(lambda self: False, lambda self, value: None), raising=False)
    with pytest.raises(MissingPackage, match="pip install 'viser=="):
        Viewer(arm, port=0)


def test_servers_of_others_are_left_as_they_are(arm: Arm) -> None:
    """Only the viewer's own server asks the guard."""
    with Viewer(arm, port=0):
        other = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            address = f"http://127.0.0.1:{other.get_port()}"
            assert urllib.request.urlopen(address, timeout=PATIENCE).status == 200
        finally:
            other.stop()
