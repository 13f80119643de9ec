"""The two builds of a program at the prompt: the fast one, and the one with probes (stcore/emit/probes.wat).

The prompt loads the probed build, so that the first statement step waits for nothing; the fast one is compiled in the
background and takes over as soon as it is there. A PLC that was loaded without probes has it the other way round.
"""

from __future__ import annotations

import sys
import threading
from concurrent.futures import Future
from typing import TYPE_CHECKING

from plcruntime.errors import UsageError
from stcore.diagnostics import CompileError
from stcore.program import Program

if TYPE_CHECKING:
    from plcruntime.plc import PLC

BACKGROUND = 0.0005  # s that a compilation in the background holds up what the user does


class Builds:
    """The machines of a PLC: one for each build, made when it is needed."""

    def __init__(self, plc: PLC) -> None:
        self._plc = plc
        self._engine = plc._engine
        self._probes_first = bool(plc.program.probes)
        self._first = plc._machine
        self._other = None  # the machine of the other build
        self._ahead: Future[Program] | None = None

    @property
    def probed(self) -> bool:
        """True while the probed build runs."""
        return (self._engine.machine is self._first) == self._probes_first

    def prepare(self) -> None:
        """Compile the other build in the background."""
        if self._plc.origin is not None and self._ahead is None:
            self._ahead = ahead = Future()
            # a daemon: whoever quits at once does not wait for it
            threading.Thread(target=self._compile_ahead, args=(ahead,), name="scancycle build", daemon=True).start()

    def _compile_ahead(self, ahead: Future[Program]) -> None:
        usual = sys.getswitchinterval()
        sys.setswitchinterval(BACKGROUND)
        try:
            ahead.set_result(self._compile())
        except BaseException as error:  # told to whoever asks for the build
            ahead.set_exception(error)
        finally:
            sys.setswitchinterval(usual)

    def _compile(self) -> Program:
        from plcruntime.plc import build
        from stcore.machine import load_module

        program, _ = build(**self._plc.origin, probes=not self._probes_first)
        load_module(program.wasm)  # to machine code, kept in the cache
        return program

    def with_probes(self):
        """The machine of the probed build, and change to it. Raises UsageError when the source has changed."""
        if self._probes_first:
            machine = self._first
        else:
            self._other = machine = self._other or self._made()
        self._use(machine)
        return machine

    def without_probes(self, *, wait: bool) -> None:
        """Change to the fast build, if it is there. wait: until it is compiled, as a long run is worth it."""
        if not self._probes_first:
            self._use(self._first)
            return
        if self._other is None and self._ahead is not None and (wait or self._ahead.done()):
            try:
                self._other = self._made()
            except (UsageError, CompileError):  # the source is being edited: the probed build goes on
                self._ahead = None
        if self._other is not None:
            self._use(self._other)

    def _made(self):
        """A machine with the other build of the program."""
        plc = self._plc
        if plc.origin is None:
            raise UsageError("breakpoints and statement steps need a program that was loaded from its source")
        ahead, self._ahead = self._ahead, None
        program = ahead.result() if ahead else self._compile()
        if program.digest != plc.program.digest:
            raise UsageError("the source has changed since it was loaded; leave and load it again")
        return plc.new_machine(program)

    def _use(self, machine) -> None:
        if machine is not self._engine.machine:
            self._engine.use(machine)
            self._plc._machine = machine
