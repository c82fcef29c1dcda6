"""Fork safety: a fork waits until no other thread holds a lock of this package or an import lock.

A lock that another thread holds during fork() would stay locked in the child, which has only the thread that forked. A
thread holds such locks while it imports modules or computes cached properties, as every first call does.
"""

import _imp
import concurrent.futures.thread  # noqa: F401  it and logging hold locks during a fork, which imports want: see the end
import functools
import logging  # noqa: F401
import os
import sys
import threading
import time
from typing import Any
from weakref import WeakSet

PATIENCE = 30.0
"""Longest wait of a fork [s]; the longest first call takes a third of it on a slow machine."""
_PAUSE = 0.001


_own: WeakSet[Any] = WeakSet()
_held: list[Any] = []
_import_lock: list[bool] = []


def lock() -> threading.RLock:
    """A lock that is free after a fork, in both processes."""
    made = threading.RLock()
    _own.add(made)
    return made


def _locks() -> list[Any]:
    """This package's locks, and those of its cached properties, which have one before Python 3.12."""
    found = list(_own)
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == "urdf_ik":
            for value in list(vars(module).values()):
                if isinstance(value, type) and value.__module__ == name:
                    found += [
                        each.lock
                        for each in list(vars(value).values())
                        if isinstance(each, functools.cached_property) and hasattr(each, "lock")
                    ]
    return found


def _importing() -> bool:
    """Whether another thread is importing a module."""
    bootstrap: Any = sys.modules["_frozen_importlib"]
    references = list(getattr(bootstrap, "_module_locks", {}).values())
    owners = {getattr(reference(), "owner", None) for reference in references}
    return bool(owners - {None, threading.get_ident()})


def _before() -> None:
    end = time.monotonic() + PATIENCE
    while True:
        taken: list[Any] = []
        for each in _locks():
            if not each.acquire(blocking=False):
                break
            taken.append(each)
        else:
            # No import begins while this is held: another thread may run between here and the fork.
            _imp.acquire_lock()
            if not _importing() or time.monotonic() > end:
                _held.extend(taken)
                _import_lock.append(True)
                return
            _imp.release_lock()
        for each in taken:
            each.release()
        if time.monotonic() > end:  # a child that may hang is better than a program that does
            return
        time.sleep(_PAUSE)


def _after() -> None:
    while _import_lock:
        _import_lock.pop()
        _imp.release_lock()
    while _held:
        _held.pop().release()


if hasattr(os, "register_at_fork"):
    # The handler registered last runs first: an import that this fork waits for may need locks that the handlers of
    # other modules take.
    os.register_at_fork(before=_before, after_in_parent=_after, after_in_child=_after)
