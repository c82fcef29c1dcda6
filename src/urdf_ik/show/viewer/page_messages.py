"""Messages of pages, checked before viser acts on them: what no widget can send changes nothing."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable
from numbers import Real
from typing import Any

Refused = Callable[[str], None]


def check_messages(server: Any, refused: Refused, changed: Callable[[], None]) -> None:
    """Have every message of a page checked.

    viser casts the values of a page to the type of its widget and keeps them, NaN too; what cannot be cast ends in a
    traceback.

    Args:
        server: the viser server.
        refused: called with the reason where a message is dropped.
        changed: called when a page has sent the value of a widget, a dropped one too: several pages may differ now.
    """
    handlers = server._websock_server._incoming_handlers
    for kind, calls in handlers.items():
        handlers[kind] = [_checked(call, server.gui, refused, changed) for call in calls]


def _checked(call: Any, gui: Any, refused: Refused, changed: Callable[[], None]) -> Callable[[int, Any], Any]:
    async def handle(client: int, message: Any) -> None:
        problem = why_refused(gui, message)
        if not problem:
            try:
                answer = call(client, message)
                if inspect.isawaitable(answer):
                    await answer
            except Exception as error:  # fields of other types than viser reads
                problem = f"a page sent a malformed message ({type(error).__name__})"
        if problem:
            refused(problem)
        if hasattr(message, "updates"):
            changed()

    return handle


def why_refused(gui: Any, message: Any) -> str:
    """Why a message of a page is dropped; '' where it is valid."""
    if not all(map(_is_plain, vars(message).values())):
        return "a page sent a number that is not finite"
    if not hasattr(message, "updates"):
        return ""
    handle = gui._gui_input_handle_from_uuid.get(message.uuid) if isinstance(message.uuid, str) else None
    if handle is None:
        return ""  # a widget that has gone meanwhile
    if not isinstance(message.updates, dict) or set(message.updates) != {"value"}:
        return "a page changed something else than the value of a widget"
    return "" if _fits(handle, message.updates["value"]) else f"a page sent an invalid value of {handle.label!r}"


def _is_plain(value: object) -> bool:
    """Whether all numbers in a field of a message are finite."""
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, dict):
        value = value.values()
    return not isinstance(value, Iterable) or isinstance(value, str | bytes) or all(map(_is_plain, value))


def _fits(handle: Any, value: object) -> bool:
    """Whether a widget can take a value: that of a check box, a text or dropdown, or a number within its ends."""
    kind = handle.value
    if isinstance(kind, bool) or isinstance(value, bool):
        return isinstance(kind, bool) and isinstance(value, bool)
    if isinstance(kind, str):
        return isinstance(value, str) and value in getattr(handle, "options", (value,))
    return isinstance(kind, Real) and isinstance(value, Real) and bool(handle.min <= value <= handle.max)
