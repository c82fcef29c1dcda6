"""Guard: only the page itself, opened at the printed address with its token, may talk to the viewer's server.

A browser lets every web page that its user visits open a connection to this machine. So a request must name this
server (Host), come from the server's own page (Origin) and begin with the token in the printed address. viser has no
argument for such a check, so it is added where viser calls websockets, for the viewer's own server alone.
"""

from __future__ import annotations

import dataclasses
import http
import ipaddress
import logging
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

from urdf_ik.errors import MissingPackage
from urdf_ik.show.viewer import address
from urdf_ik.support import forks

MAX_MESSAGE = 2**20
"""Greatest size of a message of the page [bytes]; it sends files in parts of half of that."""

_LOCK = forks.lock()
_LOGGER = logging.getLogger("urdf_ik.show.viewer")
_LOGGER.addHandler(logging.NullHandler())  # invalid requests do not belong in the terminal
_LOGGER.propagate = False


class Guard:
    """The token of a server, and which requests it answers.

    Attributes:
        token: what the path of every request begins with.
        active: whether a server asks this guard.
    """

    def __init__(self, host: str) -> None:
        """``host`` is the interface that the server listens on."""
        self.token = secrets.token_urlsafe(24)
        self.active = False
        self._host = host

    def refusal(self, path: str, hosts: list[str], origins: list[str]) -> tuple[http.HTTPStatus, str] | None:
        """Why a request is refused, or None.

        Args:
            path: of the request, with the token.
            hosts: its Host headers.
            origins: its Origin headers; programs that are no browsers send none.

        Example:
            >>> guard = Guard("127.0.0.1")
            >>> guard.refusal(f"/{guard.token}/", ["127.0.0.1:8080"], ["http://127.0.0.1:8080"])
            >>> guard.refusal(f"/{guard.token}/", ["127.0.0.1:8080"], ["https://example.org"])[1]
            'the Origin is not this page'
        """
        if len(hosts) != 1 or not self._is_own(hosts[0]):
            return http.HTTPStatus.FORBIDDEN, "the Host is not this server"
        if origins and origins not in ([f"http://{hosts[0]}"], [f"https://{hosts[0]}"]):
            return http.HTTPStatus.FORBIDDEN, "the Origin is not this page"
        first = path.split("?")[0].removeprefix("/").split("/")[0]
        if not secrets.compare_digest(first.encode(errors="replace"), self.token.encode()):
            return http.HTTPStatus.FORBIDDEN, "open the address that was printed, with its token"
        return None

    def without_token(self, path: str) -> str:
        """The path of a request as viser knows it."""
        return "/" + path.removeprefix(f"/{self.token}").removeprefix("/")

    def _is_own(self, host: str) -> bool:
        """Whether a Host header can name this server; a name of a stranger may lead here by DNS rebinding.

        The port may be another one, since ports are forwarded.
        """
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


class _Host(str):
    """The interface to listen on, with the guard that goes with it through viser's hands."""

    guard: Guard


@contextmanager
def guarding(guard: Guard, host: str) -> Iterator[str]:
    """While this lasts, a viser server that is started on the host that is given asks ``guard`` about every request.

    viser has no place for such a check; what it starts its server with, ``websockets.asyncio.server.serve``, has one.
    Servers of others that start meanwhile are left as they are.
    """
    from websockets.asyncio import server

    own = _Host(host)
    own.guard = guard
    with _LOCK:
        original: Any = server.serve

        def serve(handler: Any, host: Any = None, *arguments: Any, **options: Any) -> Any:
            if not isinstance(host, _Host):
                return original(handler, host, *arguments, **options)
            options["process_request"] = _checked(host.guard, options.get("process_request"))
            options |= {"max_size": MAX_MESSAGE, "logger": _LOGGER}
            host.guard.active = True
            return original(handler, str(host), *arguments, **options)

        server.serve = serve  # type: ignore[misc, assignment]
        try:
            yield own
        finally:
            server.serve = original  # type: ignore[misc]


@contextmanager
def quiet() -> Iterator[None]:
    """Keep viser from printing: it does so when it starts and stops, and has no setting for that."""
    import rich

    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


def require(guard: Guard, server: Any) -> None:
    """Make sure that a viser server asks the guard, and that it opens no tunnel for the page.

    Raises:
        MissingPackage: this cannot be had from the installed viser.
    """
    from viser import _messages as messages

    try:
        for kind in (messages.ShareUrlRequest, messages.ShareUrlDisconnect):
            server._websock_server.unregister_handler(kind)
    except (AttributeError, AssertionError):
        guard.active = False
    if not guard.active:
        raise MissingPackage("the installed viser listens in another way than is known: pip install 'viser==1.1.1'")


def _checked(guard: Guard, then: Callable[[Any, Any], Any] | None) -> Callable[[Any, Any], Any]:
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    def process_request(connection: Any, request: Any) -> Any:
        headers = request.headers
        refused = guard.refusal(request.path, headers.get_all("Host"), headers.get_all("Origin"))
        if refused is not None:
            status, reason = refused
            plain = Headers({"Content-Type": "text/plain", "Connection": "close"})
            return Response(status.value, status.phrase, plain, f"{reason}\n".encode())
        if then is None:
            return None
        answer = then(connection, dataclasses.replace(request, path=guard.without_token(request.path)))
        if answer is not None:
            answer.headers["Referrer-Policy"] = "no-referrer"  # or the token would leave with a link
        return answer

    return process_request
