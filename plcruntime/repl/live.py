"""`axes live`: the table of the axes on a terminal while the PLC keeps the wall clock's pace; a key ends it."""

from __future__ import annotations

import os
import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from plcruntime import layout
from plcruntime.plc import PLC
from plcruntime.repl import axis_table

FRAME = 0.1  # s of wall clock between two pictures
_ANSWER = re.compile(rb"\x1b\[\d+;\d+R")  # of a busy terminal, late, to the prompt's question where its cursor is


class KeyPressed(Exception):
    """The user has seen enough."""


class LiveAxes:
    """Draws the axes between calls into the module; to be given to PLC.on_progress."""

    def __init__(self, plc: PLC, pressed: Callable[[], bool], draw: Callable[[object], None]) -> None:
        self._plc, self._pressed, self._draw = plc, pressed, draw
        self._next = 0.0

    def __call__(self, _done: int, _goal: int) -> None:
        """Raises KeyPressed."""
        now = time.monotonic()
        if now >= self._next:
            self._draw(picture(self._plc, layout.width()))
            self._next = now + FRAME
        if self._pressed():
            raise KeyPressed


def picture(plc: PLC, room: int | None, hint: str = "; any key stops"):
    """The axes as they stand, for rich."""
    from rich.text import Text

    lines = [*axis_table.lines(plc, room), "", f"{layout.INDENT}{plc.time:.3f} s{hint}"]
    return Text("\n".join(lines), no_wrap=True)


@contextmanager
def live_axes(plc: PLC) -> Iterator[LiveAxes]:
    """The display for a run on this terminal. The last picture stays on the screen."""
    from rich.live import Live

    with _keys() as pressed, Live(picture(plc, layout.width()), auto_refresh=False) as screen:
        try:
            yield LiveAxes(plc, pressed, lambda drawn: screen.update(drawn, refresh=True))
        finally:
            screen.update(picture(plc, layout.width(), ""), refresh=True)


if os.name == "nt":

    @contextmanager
    def _keys() -> Iterator[Callable[[], bool]]:
        """A function that tells whether a key was pressed."""
        import msvcrt

        yield msvcrt.kbhit
        while msvcrt.kbhit():
            msvcrt.getwch()

else:

    @contextmanager
    def _keys() -> Iterator[Callable[[], bool]]:
        """A function that tells whether a key was pressed; Ctrl-C goes on being a signal."""
        import select
        import termios
        import tty

        where = sys.stdin.fileno()
        before = termios.tcgetattr(where)
        tty.setcbreak(where)
        try:
            yield lambda: bool(select.select([where], [], [], 0)[0]) and bool(_ANSWER.sub(b"", os.read(where, 4096)))
        finally:
            termios.tcflush(where, termios.TCIFLUSH)  # the key is no input for the prompt
            termios.tcsetattr(where, termios.TCSADRAIN, before)
