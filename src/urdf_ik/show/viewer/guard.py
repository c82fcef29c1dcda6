"""Guard: only the page itself, opened at the printed address with its token, may talk to the viewer's server.

A browser lets every web page that its user visits open a connection to this machine. So a request must name this
server (Host), come from the server's own page (Origin) and begin with the token in the printed address.
"""

import dataclasses
import http.client
import ipaddress
import logging
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

from urdf_ik.show.viewer import address
from urdf_ik.support import extras, forks

MAX_MESSAGE = 2**20
"""Greatest size of a message of the page [bytes]."""

_LOCK = forks.lock()
_LOGGER = logging.getLogger("urdf_ik.show.viewer")
_LOGGER.addHandler(logging.NullHandler())  # invalid requests do not belong in the terminal
_LOGGER.propagate = False


class Guard:
    """The token of a server that listens on ``host``, and which requests it answers.

    Attributes:
        token: what the path of every request begins with.
    """

    def __init__(self, host: str) -> None:
        self.token = secrets.token_urlsafe(24)
        self._host = host

    def refusal(self, path: str, hosts: list[str], origins: list[str]) -> str:
        """Why a request with this path and these Host and Origin headers is refused; '' where it is answered."""
        if len(hosts) != 1 or not self._is_own(hosts[0]):
            return "the Host is not this server"
        # Programs that are no browsers send no Origin.
        if origins and origins not in ([f"http://{hosts[0]}"], [f"https://{hosts[0]}"]):
            return "the Origin is not this page"
        first = path.split("?")[0].removeprefix("/").split("/")[0]
        if not secrets.compare_digest(first.encode(errors="replace"), self.token.encode()):
            return "open the address that was printed, with its token"
        return ""

    def _is_own(self, host: str) -> bool:
        """Whether a Host header can name this server: DNS rebinding lets other names lead here."""
        try:
            parts = urlsplit(f"//{host}")
            name, _ = parts.hostname or "", parts.port
        except ValueError:
            return False
        if parts.netloc != host or "@" in host:
            return False
        if name == self._host.lower() or address.is_local(name):
            return True
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return not address.is_local(self._host)

    def before(self, answer: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        """A ``process_request`` of websockets that calls ``answer``, without the token, where nothing is refused."""
        from websockets.datastructures import Headers
        from websockets.http11 import Response

        def process_request(connection: Any, request: Any) -> Any:
            headers = request.headers
            if reason := self.refusal(request.path, headers.get_all("Host"), headers.get_all("Origin")):
                plain = Headers({"Content-Type": "text/plain", "Connection": "close"})
                return Response(403, "Forbidden", plain, f"{reason}\n".encode())
            path = "/" + request.path.removeprefix(f"/{self.token}").removeprefix("/")
            response = answer(connection, dataclasses.replace(request, path=path))
            if response is not None:
                response.headers["Referrer-Policy"] = "no-referrer"  # or the token would leave with a link
            return response

        return process_request


def start(guard: Guard, host: str, port: int) -> Any:
    """A viser server on ``host`` whose requests ``guard`` checks.

    viser hands each request to websockets' ``serve`` and has no argument for a check. So the check is added to that
    call while the server starts; whether it works is asked of the server itself.
    """
    import viser
    from websockets.asyncio import server

    own = host.encode().decode()  # an object that only this server's call passes
    with _LOCK, quiet():
        original: Any = server.serve

        def serve(handler: Any, host: Any = None, *arguments: Any, **options: Any) -> Any:
            if host is own:
                options["process_request"] = guard.before(options["process_request"])
                options |= {"max_size": MAX_MESSAGE, "logger": _LOGGER}
            return original(handler, host, *arguments, **options)

        server.serve = serve  # type: ignore[misc, assignment]
        try:
            started = viser.ViserServer(host=own, port=port, label="urdf-ik", verbose=False)
        finally:
            server.serve = original  # type: ignore[misc]
        setattr(started, "request_share_url", lambda *_, **__: None)  # noqa: B010  a page must not publish the server
        if not _is_refused(address.reachable(host), started.get_port()):
            started.stop()
            raise extras.missing("requests to the installed viser cannot be checked, a newer one is needed", "viewer")
    return started


def _is_refused(host: str, port: int) -> bool:
    """Whether a server refuses a request without a token."""
    connection = http.client.HTTPConnection(host, port, timeout=10.0)
    try:
        connection.request("GET", "/")
        return connection.getresponse().status == http.HTTPStatus.FORBIDDEN
    except OSError:
        return False
    finally:
        connection.close()


@contextmanager
def quiet() -> Iterator[None]:
    """Keep viser from printing when it starts and stops: it has no setting for that."""
    import rich

    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before
