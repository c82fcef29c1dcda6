"""Who may talk to the viewer: the page at the printed address, and nobody whom another web page sends."""

import urllib.error
import urllib.request
from pathlib import Path

import pytest
from wire import PATIENCE, WirePage, connect, wait

import urdf_ik
from urdf_ik import Arm, MissingPackage

viser = pytest.importorskip("viser", reason="pip install viser")

from websockets.exceptions import ConnectionClosed, InvalidStatus  # noqa: E402

from urdf_ik.show.viewer import Viewer, guard  # noqa: E402


@pytest.fixture(scope="module")
def arm() -> Arm:
    """Small, so that a page is quickly there."""
    return urdf_ik.load("planar_2r")


def test_the_page_itself_is_let_in(viewer: Viewer) -> None:
    """With the printed address, from a browser on this machine; also by 'localhost', and through a forwarded port."""
    with connect(viewer) as connection:
        assert connection.recv(timeout=PATIENCE)
    host = f"localhost:{viewer.port}"
    with connect(
        viewer, url=viewer.url.replace("http://127.0.0.1", "ws://localhost"), origin=f"http://{host}"
    ) as other:
        assert other.recv(timeout=PATIENCE)


@pytest.mark.parametrize("origin", ["https://example.org", "http://127.0.0.1:1", "http://localhost", "null", "file://"])
def test_other_pages_are_refused(viewer: Viewer, origin: str) -> None:
    """Even one that knows the token: its Origin is another."""
    with pytest.raises(InvalidStatus, match="403"), connect(viewer, origin=origin):
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
    with pytest.raises(InvalidStatus, match="403"), connect(viewer, url=f"ws://{start}"):
        pass


def test_a_page_publishes_nothing_and_reads_no_files(
    viewer: Viewer, arm: Arm, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It cannot have a tunnel opened, as viser would let it, nor a path looked at in place of a catalogue name."""
    monkeypatch.setattr("viser._tunnel.ViserTunnel.__init__", lambda *_, **__: pytest.fail("a tunnel is opened"))
    file = tmp_path / "secret.urdf"
    file.write_text('<robot name="secret"><link name="a"/></robot>')
    with WirePage(viewer) as page:
        page.send("ShareUrlRequest")
        for value in (str(file), "/etc/passwd", "no/such"):
            page.change("Catalogue", value)
        page.change("joint_1 [rad]", 0.25)  # is read after them
        wait(lambda: viewer.state.q[0] == 0.25)
    assert viewer.settle(PATIENCE) and viewer.state.arm is arm and not viewer.message


def test_a_huge_message_ends_the_connection(viewer: Viewer) -> None:
    """No widget sends more than a megabyte."""
    with connect(viewer) as connection, pytest.raises(ConnectionClosed):
        connection.send(bytes(guard.MAX_MESSAGE + 1))
        while True:
            connection.recv(timeout=PATIENCE)


def test_a_viser_whose_requests_are_not_checked_is_refused(arm: Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rather no viewer than one that lets everybody in."""
    monkeypatch.setattr(guard, "checked", lambda token, answer: answer)
    with pytest.raises(MissingPackage, match=r"newer one is needed: pip install '(urdf-ik\[viewer\]|viser)"):
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
