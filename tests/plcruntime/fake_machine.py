"""A machine in Python, with the tables of the system area as stcore/program.py has them, for tests without a compiler.

The program: counter (DINT) counts scans, while `run` (BOOL) holds position (LREAL) grows by velocity, `t` is the time.
"""

from __future__ import annotations

import struct
import threading

from stcore.faults import Fault
from stcore.program import (
    FORCES,
    INTERRUPT,
    INTERVAL,
    NOW,
    SCAN,
    TRACE,
    Program,
    Site,
    TaskSpec,
    Variable,
)  # fmt: skip
from stcore.types import (
    BOOL,
    DINT,
    ELEMENTARY,
    INT,
    LREAL,
    REAL,
    TIME,
    WORD,
    Array,
    Block,
    Enum,
    Field,
    Pointer,
    String,
    Struct,
)

BASE = 1024


def layout(fields) -> tuple[dict[str, Field], int]:
    """Members at aligned offsets, and the size. fields: (name, type) or (name, type, attributes of Field)."""
    members, at = {}, 0
    for name, t, *more in fields:
        at = -(-at // t.align) * t.align
        members[name.upper()] = Field(name, t, at, **(more[0] if more else {"section": "VAR"}))
        at += 4 if members[name.upper()].by_reference else t.size
    return members, -(-at // 8) * 8


def struct_type(name: str, *fields) -> Struct:
    members, size = layout(fields)
    return Struct(name, members, size=size, align=8)


def program() -> Program:
    trap = struct_type("TTrapPrm", ("acc", LREAL), ("dec", LREAL), ("smoothTime", INT))
    mode = Enum("Mode", INT, {"idle": 0, "moving": 5})
    timer_members, timer_size = layout([("IN", BOOL), ("ET", TIME), ("axis", trap, {"section": "VAR_IN_OUT"})])
    timer = Block("Timer", "FUNCTION_BLOCK", timer_members, timer_size)
    members, size = layout([
        ("counter", DINT), ("run", BOOL), ("position", LREAL), ("velocity", LREAL), ("t", TIME),
        ("trap", trap), ("arr", Array(INT, [(1, 4)])), ("grid", Array(LREAL, [(0, 1), (1, 3)])), ("name", String(10)),
        ("wide", String(5, True)), ("mode", mode), ("timers", Array(timer, [(1, 2)])), ("status", WORD), ("r", REAL),
        ("p", Pointer(trap)), ("ref", Pointer(LREAL, True)), ("limit", INT, {"section": "VAR", "constant": True}),
        ("kept", DINT, {"section": "VAR", "retain": True}), ("saved", DINT, {"section": "VAR", "persistent": True}),
        ("date", ELEMENTARY["DT"]), ("endless", BOOL), ("divide", BOOL), ("Axis", INT),
    ])  # fmt: skip
    main = Block("PLC_PRG", "PROGRAM", members, size)
    other_members, other_size = layout([("position", LREAL), ("only", INT)])
    other = Block("Other", "PROGRAM", other_members, other_size)
    axis = struct_type(
        "Axis",
        ("prfPos", LREAL),
        ("prfVel", LREAL),
        ("prfAcc", LREAL),
        ("drive", struct_type("Drive", ("alarm", BOOL))),
    )
    axes = Array(axis, [(1, 2)])
    at = BASE + 64
    variables = {}
    for v in (
        Variable("PLC_PRG", "PLC_PRG", main, 0), Variable("Other", "Other", other, 0),
        Variable("gain", "GVL.gain", LREAL, 0), Variable("Axis", "SIM.Axis", axes, 0, library=True),
    ):  # fmt: skip
        v.address = at
        at += -(-v.type.size // 8) * 8
        variables[v.path.upper()] = v
    variables["DOOR"] = Variable("door", "door", BOOL, BASE + 1, direct="%IX1.2", bit=2)
    image = bytearray(at)
    struct.pack_into("<d", image, variables["PLC_PRG"].address + members["VELOCITY"].offset, 0.5)
    return Program(
        b"", bytes(image), at, at + 4096, inputs=(BASE, 16), outputs=(BASE + 16, 16), markers=(BASE + 32, 32),
        variables=variables, tasks=[TaskSpec("Main", ["PLC_PRG"])],
    )  # fmt: skip


class FakeMachine:
    """Runs `program()`; the same interface as stcore.machine.Machine."""

    def __init__(self, program: Program, host: dict) -> None:
        self.program = program
        self._bytes = bytearray(1 << 24)
        self._top = program.limit
        self._until = []
        self.calls: list[int] = []
        self._stop = threading.Event()
        self._root = program.variables["PLC_PRG"]
        self.initialise()

    @property
    def memory(self) -> memoryview:
        return memoryview(self._bytes)

    def allocate(self, size: int) -> int:
        address = -(-self._top // 8) * 8
        self._top = address + size
        assert self._top < len(self._bytes)
        return address

    def initialise(self) -> None:
        self._bytes[: len(self.program.image)] = self.program.image

    def set_until(self, *conditions) -> None:
        self._until = [c for c in conditions if c is not None]

    def until_holds(self, slot: int = 0) -> bool:
        return bool(self._until[slot](self))

    def clear_interrupt(self) -> None:
        struct.pack_into("<i", self._bytes, INTERRUPT, 0)
        self._stop.clear()

    def interrupt(self) -> None:
        struct.pack_into("<i", self._bytes, INTERRUPT, 1)
        self._stop.set()

    def at(self, name: str) -> int:
        return self._root.address + self._root.type.members[name].offset

    def _get(self, code: str, name: str):
        return struct.unpack_from("<" + code, self._bytes, self.at(name))[0]

    def _set(self, code: str, name: str, value) -> None:
        struct.pack_into("<" + code, self._bytes, self.at(name), value)

    def run(self, scans: int) -> int:
        self.calls.append(scans)
        for done in range(1, scans + 1):
            self._scan()
            if self._row() or any(condition(self) for condition in self._until):
                return done
        return scans

    def _scan(self) -> None:
        number, interval = (
            struct.unpack_from("<q", self._bytes, SCAN)[0],
            struct.unpack_from("<q", self._bytes, INTERVAL)[0],
        )
        struct.pack_into("<q", self._bytes, NOW, number * interval)
        self._forces()
        self._set("i", "COUNTER", self._get("i", "COUNTER") + 1)
        self._set("I", "T", number * interval // 10**6)
        if self._get("?", "RUN"):
            self._set("d", "POSITION", self._get("d", "POSITION") + self._get("d", "VELOCITY"))
        if self._get("?", "DIVIDE"):
            raise Fault("F0102", "division by zero", Site("prog.st", 7, 3, "PLC_PRG"), "PLC_PRG", number, "")
        if self._get("?", "ENDLESS"):
            assert self._stop.wait(30), "nobody interrupted an endless loop"
            raise Fault("F0108", "endless loop", Site("prog.st", 9, 3, "PLC_PRG"), "PLC_PRG", number, "")
        self._forces()
        struct.pack_into("<q", self._bytes, SCAN, number + 1)

    def _forces(self) -> None:
        table, count = struct.unpack_from("<II", self._bytes, FORCES)
        for i in range(count):
            address, size, value, mask = struct.unpack_from("<II8s8s", self._bytes, table + 24 * i)
            for k in range(size):
                old = self._bytes[address + k]
                self._bytes[address + k] = old & ~mask[k] | value[k] & mask[k]

    def _row(self) -> bool:
        """Copy a row; True when the buffer is full."""
        control = struct.unpack_from("<I", self._bytes, TRACE)[0]
        if not control:
            return False
        at, table_end, first, to, end = struct.unpack_from("<5I", self._bytes, control)
        while at < table_end:
            address, size = struct.unpack_from("<II", self._bytes, at)
            self._bytes[to : to + size] = self._bytes[address : address + size]
            at, to = at + 8, to + size
        struct.pack_into("<I", self._bytes, control + 12, to)
        if to < end:
            return False
        self._search(control, 16)
        value, header, needed = struct.unpack_from("<III", self._bytes, control + 24)
        return header - value < needed

    def search_rows(self) -> None:
        control = struct.unpack_from("<I", self._bytes, TRACE)[0]
        first, to, _, size = struct.unpack_from("<4I", self._bytes, control + 8)
        if to > first:
            self._search(control, (to - first) // size)

    def _search(self, control: int, rows: int) -> None:
        first, _, _, size = struct.unpack_from("<4I", self._bytes, control + 8)
        value, header, _, searched = struct.unpack_from("<4I", self._bytes, control + 24)
        for pair in range(size // 16):
            bits = 0
            for bit in range(2 * rows):
                at = first + 16 * pair + bit // 2 * size + bit % 2 * 8
                word = self._bytes[at : at + 8]
                if word != self._bytes[at - size : at - size + 8]:
                    bits |= 1 << bit
                    self._bytes[value : value + 8] = word
                    value += 8
            if bits:
                struct.pack_into("<HHI", self._bytes, header, pair, searched, bits)
                header -= 8
        last = first + (rows - 1) * size
        self._bytes[first - size : first] = self._bytes[last : last + size]
        struct.pack_into("<I", self._bytes, control + 12, first)
        struct.pack_into("<II", self._bytes, control + 24, value, header)
        struct.pack_into("<I", self._bytes, control + 36, searched + 1)
