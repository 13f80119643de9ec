"""Hostile text: no uncaught exception, whatever stands in a file; an undamaged module or diagnostics."""

import random
import re
import threading
from pathlib import Path

import pytest
from sample import some_examples

import mclib
import stcore
from stcore.machine import Machine
from stcore.source import Source

ROOT = Path(__file__).parents[2]
PROGRAMS = sorted([*some_examples(), *(ROOT / "tests" / "stcore" / "lang").rglob("*.st")])
WORDS = (
    "IF THEN END_IF ( ) [ ] ; := = VAR END_VAR ^ . 1 x 16#FF T#1s 'a' REAL CASE OF FOR TO DO NOT - 1.5 %IX0.0 "
    "STRUCT TYPE "
    "(* *) { } # $ ' \" ADR( MOD ** END_PROGRAM FUNCTION .. , => REF= % \x00 é 一 ENO=> [1,2(3)] POINTER"
).split(" ")
TOKEN = re.compile(r"\w+|\s+|[^\w\s]")
# texts that once were more than the compiler could take
FOUND = (
    "PROGRAM p VAR a, b : ARRAY[1..2] OF INT; x : BOOL; END_VAR x := a = b; END_PROGRAM",
    "PROGRAM p VAR x : INT; END_VAR x := Nothing([1, 2], (a := 1)); END_PROGRAM",
    "PROGRAM p VAR x : INT; END_VAR x := ABS(IN := 2(3)); END_PROGRAM",
    "PROGRAM p VAR t1 : TON; END_VAR t1(IN := TRUE, ENO => , EN := ); END_PROGRAM",
    "{attribute nothing} PROGRAM p END_PROGRAM",
    "PROGRAM p VAR x : INT; END_VAR x := " + "(" * 10000 + "1" + ")" * 10000 + "; END_PROGRAM",
    "PROGRAM p VAR x : INT; END_VAR x := " + "-" * 5000 + "1; END_PROGRAM",
)


def damaged(text: str, chance: random.Random) -> str:
    """The text with a few tokens removed, doubled, moved or replaced."""
    parts = TOKEN.findall(text)
    for _ in range(chance.choice((1, 1, 2, 3, 6))):
        at, kind = chance.randrange(len(parts)), chance.randrange(5)
        if kind == 0:
            del parts[at]
        elif kind == 1:
            parts.insert(at, f" {chance.choice(WORDS)} ")
        elif kind == 2:
            parts[at] = chance.choice(parts)
        elif kind == 3:
            parts[at] = chance.choice(WORDS)
        else:
            parts[at : at + chance.randrange(1, 12)] = []
    return "".join(parts)


def survive(text: str) -> None:
    """Compile and run; only the errors that are meant may come out."""
    try:
        program = stcore.compile([Source(text, "hostile.st")], libraries=[mclib.LIBRARY])
    except stcore.CompileError:
        return
    machine = Machine(program)
    watchdog = threading.Timer(0.5, machine.interrupt)
    watchdog.start()
    try:
        machine.run(2)
    except stcore.Fault as fault:
        assert fault.code
    finally:
        watchdog.cancel()


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda p: p.stem)
def test_damaged_programs(path):
    chance = random.Random(path.stem)
    text = path.read_text(encoding="utf-8")
    for _ in range(4):
        survive(damaged(text, chance))


@pytest.mark.parametrize("text", FOUND, ids=range(len(FOUND)))
def test_found(text):
    survive(text)


def test_random_bytes():
    chance = random.Random(7)
    for _ in range(60):
        survive(bytes(chance.randrange(256) for _ in range(200)).decode("latin-1"))
