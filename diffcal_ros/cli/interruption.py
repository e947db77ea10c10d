# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Work that Ctrl-C ends soon, also in the middle of a factorisation that takes a minute.

Python looks at signals between two of its own instructions in the main thread, so the main thread
does nothing but wait. The work is asked to end; native code that does not return in time is left
behind, and the process ends under it. A second Ctrl-C ends the process at once.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
import ctypes
from multiprocessing import active_children
import signal
import threading
from typing import Any

from diffcal_ros.cli.half_made import leave_half_made_untold

# For so long what was interrupted may put its files in order [s].
_GRACE = 1.0


class Abandoned(KeyboardInterrupt):
    """The work was interrupted and has not ended: only the end of the process ends it."""


def run_interruptibly(work: Callable[[], int]) -> int:
    """Do the work in a thread of its own and return what it returns.

    Raises:
        KeyboardInterrupt: it was interrupted, and has ended.
        Abandoned: it was interrupted, and goes on.
        BaseException: whatever the work raised.
    """
    if threading.current_thread() is not threading.main_thread():
        return work()
    ended: dict[str, Any] = {}
    # Not `join`, which takes a thread for ended once it was interrupted (Python 3.11).
    has_ended = threading.Event()

    def run() -> None:
        try:
            ended['code'] = work()
        except BaseException as error:
            ended['error'] = error
        finally:
            has_ended.set()

    thread = threading.Thread(target=run, name='diffcal', daemon=True)
    with second_interrupt_ends():
        try:
            thread.start()
            has_ended.wait()
        except KeyboardInterrupt as interrupt:
            _end(thread, has_ended)
            if not has_ended.is_set():
                raise Abandoned from interrupt
            if 'code' not in ended:
                raise
    if 'error' in ended:
        raise ended['error']
    return int(ended['code'])


def _end(thread: threading.Thread, has_ended: threading.Event) -> None:
    """Ask the work to end, and wait a little for it to do so."""
    leave_half_made_untold()
    # It may wait for them.
    for child in active_children():
        child.terminate()
    ctypes.pythonapi.PyThreadState_SetAsyncExc(
        ctypes.c_ulong(thread.ident or 0), ctypes.py_object(KeyboardInterrupt)
    )
    with suppress(KeyboardInterrupt):
        has_ended.wait(_GRACE)


@contextmanager
def second_interrupt_ends() -> Iterator[None]:
    """Let a second SIGINT end the process, native code or not, where the system can do that."""
    usual = signal.getsignal(signal.SIGINT)
    if usual is signal.default_int_handler:
        with suppress(AttributeError, OSError):
            _reset_after_first()
    try:
        yield
    finally:
        if usual is not None:
            signal.signal(signal.SIGINT, usual)


def _reset_after_first() -> None:
    """Keep Python's own handler, for one signal: the next finds the system's, which ends us."""
    library = ctypes.CDLL(None)
    install_once, install = library.sysv_signal, library.signal
    for function in (install, install_once):
        function.restype = ctypes.c_void_p
        function.argtypes = (ctypes.c_int, ctypes.c_void_p)
    of_python = install(signal.SIGINT, None)
    install_once(signal.SIGINT, of_python)
