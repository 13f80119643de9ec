"""ST typed beside a program that has run some scans."""

from stcore.compiler import compile
from stcore.known import Names, Scene
from stcore.machine import Machine
from stcore.show import show
from stcore.side import compile_side
from stcore.source import Source
from stcore.values import decode


class Session:
    def __init__(self, text: str, probes: bool, scans: int) -> None:
        self.program = compile([Source(text, "<test>")], probes=probes)
        self.machine = Machine(self.program)
        self.names = Names(self.program)
        self.machine.run(scans)

    def __call__(self, text: str, scene: Scene | None = None, this: int = 0) -> str:
        side = compile_side(self.names, text, scene)
        address = self.machine.side(side)(this, 0)
        return "" if side.type is None else show(side.type, decode(self.machine.memory, side.type, address))
