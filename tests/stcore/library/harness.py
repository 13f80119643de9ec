"""Small ST programs, compiled and run: expressions to Python values, and blocks scan by scan."""

from __future__ import annotations

import ast
import struct
from collections.abc import Iterable, Sequence

import stcore
from stcore import paths, values
from stcore.machine import Machine
from stcore.program import INTERVAL
from stcore.source import Source

MS = 10**6


class Plc:
    """A program in memory. Variables by path; interval: of a scan in ms."""

    def __init__(self, text: str, interval: float = 1) -> None:
        self.program = stcore.compile([Source(text, "case.st")])
        self.machine = Machine(self.program)
        struct.pack_into("<q", self.machine.memory, INTERVAL, round(interval * MS))

    def __getitem__(self, path: str):
        return values.read(self.machine.memory, paths.resolve(self.program, path))

    def __setitem__(self, path: str, value) -> None:
        place = paths.resolve(self.program, path)
        for address, data in values.encode(self.machine.memory, place, value):
            self.machine.memory[address : address + len(data)] = data

    def scan(self, count: int = 1) -> None:
        assert self.machine.run(count) == count

    def write_numbers(self, path: str, numbers: Sequence[float], code: str = "d") -> None:
        """A whole ARRAY OF LREAL (REAL with code 'f') at once."""
        address = paths.resolve(self.program, path).address
        struct.pack_into(f"<{len(numbers)}{code}", self.machine.memory, address, *numbers)


def evaluate(cases: Iterable[tuple], declarations: str = "", before: str = "") -> list:
    """The values of (result type, expression) pairs, all compiled into one program and run in one scan.

    declarations, before: variables and statements that the expressions may use. TIME and dates are seconds.
    """
    cases = list(cases)
    names = [f"r{i}" for i in range(len(cases))]
    declared = "\n".join(f"  {n} : {case[0]};" for n, case in zip(names, cases, strict=True))
    assigned = "\n".join(f"  {n} := {case[1]};" for n, case in zip(names, cases, strict=True))
    plc = Plc(f"PROGRAM PLC_PRG\nVAR\n{declared}\n{declarations}\nEND_VAR\n{before}\n{assigned}\nEND_PROGRAM\n")
    plc.scan()
    return [plc[f"PLC_PRG.{n}"] for n in names]


def check(cases: str | Iterable[tuple], declarations: str = "", before: str = "") -> None:
    """Each case is (result type, expression, expected value), or a line ``TYPE expression -> value`` of a text.

    All that differ are shown.
    """
    cases = _table(cases) if isinstance(cases, str) else list(cases)
    got = evaluate([c[:2] for c in cases], declarations, before)
    wrong = [f"{c[1]} = {g!r}, not {c[2]!r}" for c, g in zip(cases, got, strict=True) if not _same(g, c[2])]
    assert not wrong, "\n".join(wrong)


def _table(text: str) -> list[tuple]:
    rows = []
    for line in text.strip().splitlines():
        case, value = line.strip().rsplit(" -> ", 1)
        kind, expression = case.split(" ", 1)
        rows.append((kind, expression, ast.literal_eval(value)))
    return rows


def _same(a, b) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        return repr(a) == repr(b)  # tells -0.0 from 0.0, and NaN is NaN
    return a == b and type(a) is type(b)


def apply(function: str, arguments: Sequence[Sequence[float]], kind: str = "LREAL") -> list[float]:
    """function(x) or function(x, y) of many arguments in one scan. kind: LREAL or REAL."""
    count, arity, code = len(arguments[0]), len(arguments), "d" if kind == "LREAL" else "f"
    names = "xyz"[:arity]
    arrays = "".join(f"  {n} : ARRAY[0..{count - 1}] OF {kind};\n" for n in [*names, "result"])
    call = ", ".join(f"{n}[i]" for n in names)
    plc = Plc(
        f"PROGRAM PLC_PRG\nVAR\n{arrays}  i : DINT;\nEND_VAR\n"
        f"FOR i := 0 TO {count - 1} DO result[i] := {function}({call}); END_FOR\nEND_PROGRAM\n"
    )
    for name, numbers in zip(names, arguments, strict=True):
        plc.write_numbers(f"PLC_PRG.{name}", numbers, code)
    plc.scan()
    return plc["PLC_PRG.result"]


def trace(
    block: str, inputs: dict[str, str], rows: Sequence[tuple], outputs: Sequence[str], interval: float = 1
) -> list[tuple]:
    """Scan a block once for each row of input values; the outputs after each scan.

    inputs: name -> type. interval: of a scan in ms.
    """
    declared = "\n".join(f"  {n} : {kind};" for n, kind in inputs.items())
    call = ", ".join(f"{n} := {n}" for n in inputs)
    text = f"PROGRAM PLC_PRG\nVAR\n{declared}\n  block : {block};\nEND_VAR\nblock({call});\nEND_PROGRAM\n"
    plc = Plc(text, interval)
    result = []
    for row in rows:
        for name, value in zip(inputs, row, strict=True):
            plc[f"PLC_PRG.{name}"] = value
        plc.scan()
        result.append(tuple(plc[f"PLC_PRG.block.{o}"] for o in outputs))
    return result
