"""Ctrl-C and SIGTERM: from the first line of the command on, either signal ends it with status 130.

The signal handler raises ``KeyboardInterrupt`` in the main thread, so that files and locks are released on the way out.
That alone is not enough. Some packages catch ``BaseException`` around an optional import (trimesh does) and go on as if
the package were missing; an interrupt inside a destructor or a callback is dropped by the interpreter; compiled code
returns to Python late. Three things close these gaps:

- A signal is remembered. However the work ends afterwards, the status is that of an interrupt, and errors that follow
  from a half-finished import are not shown.
- A thread wakes up with the signal, even while the main thread is in compiled code. :data:`GRACE` later it ends the
  process. Stores and files survive that, because they survive a kill.
- Child processes, such as Dask's workers, do not see Ctrl-C (:func:`deaf_to_ctrl_c`) and are killed with the process.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from typing import Any, NoReturn

GRACE = 0.25
"""Time between the signal and the end of the process, if the main thread does not get there earlier [s]."""
INTERRUPTED = 130
_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class _Interrupt:
    """The state of this process.

    Attributes:
        came: whether a signal has arrived.
        raised: whether the main thread has got its ``KeyboardInterrupt``.
        finished: whether the work is done and only the interpreter has to stop.
        status: exit status after a signal.
    """

    came = False
    raised = False
    finished = False
    status = INTERRUPTED


_state = _Interrupt()


def guarded(work: Callable[[], object]) -> None:
    """Do the command's work; a signal during it ends the process.

    Example:
        >>> guarded(lambda: print("the work"))  # doctest: +SKIP
        the work
    """
    try:
        try:
            _listen()
            work()
        finally:
            _state.finished = True
    except KeyboardInterrupt:
        _leave(flush=True)
    except BaseException:
        if _state.came:
            _leave(flush=True)
        raise
    if _state.came:  # a library has swallowed the interrupt
        _leave(flush=True)


def came() -> bool:
    """Whether a signal has arrived, so that an error is only its consequence.

    Example:
        >>> came()
        False
    """
    return _state.came


@contextlib.contextmanager
def as_the_usual_end() -> Iterator[None]:
    """Inside, Ctrl-C is how the user ends the work: the status is 0.

    Example:
        >>> with as_the_usual_end():
        ...     raise KeyboardInterrupt
    """
    _state.status = 0
    try:
        yield
    except KeyboardInterrupt:
        return
    finally:
        if not _state.came:
            _state.status = INTERRUPTED


def deaf_to_ctrl_c(start: Callable[[], Any]) -> Any:
    """Call a function whose threads and processes must not get the Ctrl-C of the terminal; returns its result.

    A terminal sends the signal to every process of the command; Python's default there is a traceback. The call runs in
    a thread that blocks the signal, because threads and processes inherit that.

    Example:
        >>> deaf_to_ctrl_c(lambda: 2 + 2)
        4
    """
    found: Future[Any] = Future()
    if os.name == "posix":
        from multiprocessing import resource_tracker

        # The first child process starts it, which would unblock the signal in the thread that starts this child.
        resource_tracker.ensure_running()

    def act() -> None:
        if os.name == "posix":
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            found.set_result(start())
        except BaseException as error:
            found.set_exception(error)

    threading.Thread(target=act, name="urdf-ik start", daemon=True).start()
    return found.result()


def _listen() -> None:
    """Install the handlers; a signal that the parent process ignores (``nohup``, a script's ``&``) stays ignored."""
    for number in _SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _on_signal)
    atexit.register(_ignore_signals)  # first in, last out: from then on the status is settled
    if os.name == "posix":
        ours, theirs = os.pipe()
        os.set_blocking(theirs, False)
        signal.set_wakeup_fd(theirs, warn_on_full_buffer=False)
        threading.Thread(target=_watch, args=(ours,), name="urdf-ik interrupts", daemon=True).start()


def _on_signal(number: int, frame: Any) -> None:
    """Raise the interrupt once: a second one would interrupt the clean-up of the first one."""
    if _state.finished:
        _leave()
    if not _state.raised:
        _state.raised = True
        _remember()
        raise KeyboardInterrupt


def _watch(pipe: int) -> None:
    """Wait for a signal in a thread of its own, and end the process if the main thread does not."""
    while os.read(pipe, 1)[0] not in _SIGNALS:
        pass
    _remember()
    time.sleep(GRACE)
    _leave()


def _remember() -> None:
    _state.came = True
    # The interpreter prints an interrupt inside a destructor or a thread: silence it.
    sys.unraisablehook = lambda *_: None
    threading.excepthook = lambda *_: None


def _leave(*, flush: bool = False) -> NoReturn:
    """End the process and its children at once; only the main thread may flush, because it may hold a stream's lock."""
    _kill_children()
    for stream in (sys.stdout, sys.stderr) if flush else ():
        with contextlib.suppress(Exception):
            stream.flush()
    if sys.stderr is not None and sys.stderr.isatty():
        os.write(sys.stderr.fileno(), b"\x1b[?25h")  # a progress bar hides the cursor
    os._exit(_state.status)


def _kill_children() -> None:
    psutil: Any = sys.modules.get("psutil")  # Dask brings it, and only Dask starts processes
    if psutil is not None:
        with contextlib.suppress(Exception):
            for child in psutil.Process().children(recursive=True):
                child.kill()


def _ignore_signals() -> None:
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
