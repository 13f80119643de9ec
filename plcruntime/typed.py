"""ST that is typed while the PLC stands: expressions and statements, run beside the program in its memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stcore import values
from stcore.known import Names, Scene
from stcore.program import NULL_PAGE, Program
from stcore.show import show
from stcore.side import Side, compile_side, condition
from stcore.types import Type

if TYPE_CHECKING:
    from plcruntime.plc import PLC

PIECE = 64  # bytes: how finely a change of the image is noted


@dataclass(slots=True)
class Result:
    """type None: statements, which have no value. text: the value as ST writes it."""

    type: Type | None
    value: object = None
    text: str = ""


class Typed:
    """Runs typed text between two scans; what it changes is remembered for going back."""

    def __init__(self, plc: PLC) -> None:
        self._plc = plc
        self._names: dict[int, Names] = {}

    def names(self, program: Program) -> Names:
        """The names of the program or of its other build, gathered once."""
        if id(program) not in self._names:
            self._names[id(program)] = Names(program)
        return self._names[id(program)]

    def run(self, text: str) -> Result:
        """Raises stcore.CompileError, PathError, SideError, Fault; after those the variables are as they were."""
        plc, engine = self._plc, self._plc._engine
        machine = engine.machine
        side = compile_side(self.names(machine.program), text)
        function = machine.side(side)
        end = plc.program.image_end
        before = bytes(machine.memory[NULL_PAGE:end])
        try:
            with engine.guard.run(), engine.guard.call():
                result = self.result(side.type, function(0, 0))
        except BaseException:
            machine.memory[NULL_PAGE:end] = before
            raise
        pieces = list(_changes(before, bytes(machine.memory[NULL_PAGE:end])))
        if pieces:
            engine.write(pieces)
        return result

    def run_inside(self, text: str, scene: Scene, this: int, frame: int) -> tuple[Result, bool]:
        """The same in the middle of a scan, where a probe stopped, and whether a variable of the image changed.

        To be called by the thread that runs the scan. After what it raises the variables are as they were."""
        machine, end = self._plc._engine.machine, self._plc.program.image_end
        side = compile_side(self.names(machine.program), text, scene)
        before = bytes(machine.memory[NULL_PAGE:end])
        try:
            result = self.result(side.type, machine.side(side)(this, frame))
        except BaseException:
            machine.memory[NULL_PAGE:end] = before
            raise
        return result, before != bytes(machine.memory[NULL_PAGE:end])

    def condition(self, text: str, scene: Scene, offset: int) -> Side:
        """A condition in a POU: a function (instance, stack frame) that may be called often. offset: of its constants,
        among those of other conditions."""
        return condition(self.names(self._plc._engine.machine.program), text, scene, offset)

    def result(self, kind: Type | None, address: int) -> Result:
        if kind is None:
            return Result(None)
        value = values.decode(self._plc._engine.machine.memory, kind, address)
        return Result(kind, value, show(kind, value))


def _changes(before: bytes, after: bytes):
    """(address, bytes) of what differs."""
    if before == after:
        return
    for at in range(0, len(after), PIECE):
        piece = after[at : at + PIECE]
        if piece != before[at : at + PIECE]:
            yield NULL_PAGE + at, piece
