"""Ends runs that do not end by themselves: Ctrl-C and the watchdog for endless loops.

While the module runs, the main thread is inside a C call and Python handles no signal. A thread watches over it: the
interpreter writes to a pipe at once when a signal arrives (signal.set_wakeup_fd), and the module counts its scans in
memory. The thread lives while scans are run and a moment longer, so that a loop of single scans does not pay for it.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
from contextlib import contextmanager
from time import monotonic

from stcore.program import SCAN

TICK = 0.1  # s between two looks at the scan counter
GRACE = 0.15  # s that a running call has to end at a scan's boundary after Ctrl-C
LINGER = 1.0  # s without a run after which the thread ends


class Guard:
    """Watches the calls into one machine. seconds: a scan that takes longer (wall clock) is an endless loop; 0: never.

    stopped: the user pressed Ctrl-C during the present run.
    """

    def __init__(self, machine, seconds: float) -> None:
        self.machine, self.seconds = machine, seconds
        self.stopped = False
        self._running = False  # a run is under way: the thread and its pipe must stay
        self._busy = False  # the module is running
        self._raise_now = False  # Python code of the user is running: Ctrl-C ends it as anywhere
        self._paused = False  # the scan waits for the user
        self._pauses = 0  # that have ended
        self._call = 0
        self._memory = None
        self._last_use = 0.0
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._wake: _Wake | None = None

    @contextmanager
    def run(self):
        """Around a whole run: Ctrl-C sets `stopped` instead of raising in the middle of the book-keeping."""
        self.stopped = False
        self._begin()
        handler = signal.getsignal(signal.SIGINT)
        main = threading.current_thread() is threading.main_thread()
        ours = main and handler is signal.default_int_handler
        if ours:
            signal.signal(signal.SIGINT, self._on_sigint)
            before = signal.set_wakeup_fd(self._wake.write_end, warn_on_full_buffer=False)
        try:
            yield
        finally:
            if ours:
                signal.set_wakeup_fd(before)
                signal.signal(signal.SIGINT, handler)
            self._last_use = monotonic()
            self._running = False

    @contextmanager
    def call(self):
        """Around one call into the module, inside of `run`."""
        with self._lock:
            self._memory = self.machine.memory
            self._call += 1
            self.machine.clear_interrupt()
            self._busy = True
        try:
            yield
        finally:
            with self._lock:
                self._busy = False
                self._memory = None

    @contextmanager
    def paused(self):
        """While a scan waits for the user in its middle: that is no endless loop."""
        self._paused = True
        try:
            yield
        finally:
            self._pauses += 1
            self._paused = False

    @contextmanager
    def users_code(self):
        """Around Python code of the user that is called between scans."""
        if self.stopped:
            raise KeyboardInterrupt
        self._raise_now = True
        try:
            yield
        finally:
            self._raise_now = False

    def _on_sigint(self, _signum, _frame) -> None:
        self.stopped = True
        if self._raise_now:
            raise KeyboardInterrupt

    def _begin(self) -> None:
        with self._lock:
            self._running = True
            if self._thread is None or not self._thread.is_alive():  # not alive: this process was forked
                self._wake = _Wake()
                self._thread = threading.Thread(target=self._watch, name="scancycle guard", daemon=True)
                self._thread.start()

    def _watch(self) -> None:
        seen, since, signalled = None, monotonic(), 0.0
        while True:
            woken = self._wake.wait(GRACE / 3 if signalled else TICK)
            now = monotonic()
            if woken:
                signalled = signalled or now
            with self._lock:
                if not self._busy:
                    signalled = 0.0
                    if not self._running and now - self._last_use > LINGER:
                        self._wake.close()
                        self._thread = None
                        return
                    continue
                state = (self._call, self._pauses, bytes(self._memory[SCAN : SCAN + 8]))
                if state != seen:
                    seen, since = state, now
                elif self.seconds and not self._paused and now - since >= self.seconds:
                    self.machine.interrupt()
                if self.stopped and not signalled:  # it came just before the call
                    signalled = now
                if signalled and now - signalled >= GRACE:
                    self.machine.interrupt()


class _Wake:
    """What a signal writes to: a pipe, or sockets where select() knows nothing else (Windows)."""

    def __init__(self) -> None:
        if sys.platform == "win32":
            import socket

            self._sockets = socket.socketpair()
            self._sockets[0].setblocking(False)
            self._sockets[1].setblocking(False)
            self._read_end, self.write_end = (s.fileno() for s in self._sockets)
        else:
            self._sockets = ()
            self._read_end, self.write_end = os.pipe()
            os.set_blocking(self._read_end, False)
            os.set_blocking(self.write_end, False)

    def wait(self, seconds: float) -> bool:
        """Wait until a signal came, at most so long; whether one came."""
        ready, _, _ = select.select([self._read_end], [], [], seconds)
        if ready and self._sockets:
            self._sockets[0].recv(64)
        elif ready:
            os.read(self._read_end, 64)
        return bool(ready)

    def close(self) -> None:
        for s in self._sockets:
            s.close()
        if not self._sockets:
            os.close(self._read_end)
            os.close(self.write_end)
