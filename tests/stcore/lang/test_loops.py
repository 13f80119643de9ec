"""A loop that keeps variables in locals leaves the same as one that reads them from memory each time, as a build with
probes does: whatever way they are changed in it."""

import pytest
from running import program

from stcore import paths, values
from stcore.build_program import build
from stcore.compiler import LIBRARY
from stcore.machine import Machine
from stcore.source import Source

BEFORE = """
VAR_GLOBAL g : DINT; gi : INT; END_VAR
TYPE Pair : STRUCT a : DINT; b : DINT; END_STRUCT END_TYPE
FUNCTION AddToG : DINT
VAR_INPUT d : DINT; END_VAR
g := g + d; AddToG := g;
END_FUNCTION
FUNCTION AddTo : BOOL
VAR_IN_OUT v : DINT; END_VAR
VAR_OUTPUT o : DINT; END_VAR
v := v + 1; o := v * 2; AddTo := TRUE;
END_FUNCTION
FUNCTION Through : BOOL
VAR_INPUT p : POINTER TO DINT; END_VAR
p^ := p^ + 3;
END_FUNCTION
FUNCTION_BLOCK Count
VAR_INPUT step : DINT; END_VAR
VAR_OUTPUT n : DINT; twice : INT; END_VAR
VAR other : POINTER TO Count; i : INT; left : DINT; END_VAR
FOR i := 1 TO 3 DO n := n + step; THIS^.n := THIS^.n + 1;
  IF other <> 0 AND left > 0 THEN left := left - 1; other^(); END_IF
END_FOR
twice := TO_INT(n * 2);
g := g + 1;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Watched
VAR_OUTPUT n : DINT; END_VAR
VAR i : INT; parent : POINTER TO Holder; deep : BOOL; END_VAR
IF deep THEN RETURN; END_IF
deep := TRUE;
FOR i := 1 TO 4 DO n := n + 1; IF parent <> 0 THEN parent^(); END_IF END_FOR
deep := FALSE;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Holder
VAR inner : Watched; END_VAR
inner.n := inner.n + 10;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Meter
VAR n : DINT; i : INT; k : DINT; END_VAR
METHOD Up : DINT
n := n + 1; Up := n;
END_METHOD
PROPERTY Level : DINT
GET
Level := n;
END_GET
SET
n := Level; k := k + 1;
END_SET
END_PROPERTY
FOR i := 1 TO 4 DO
  n := n + 2; k := k + n; THIS^.Up(); k := k + n; Up(); n := n + k; Level := n + 1; k := k + Level;
END_FOR
END_FUNCTION_BLOCK
PROGRAM Other
VAR k : DINT; END_VAR
k := k + 1; g := g + k; PLC_PRG.x := PLC_PRG.x + 1;
END_PROGRAM
"""
DECLARATIONS = """i, j, n, s : INT; x, y, z : DINT; sum : LREAL; r : REAL; b : BOOL; w : WORD; t : TIME;
 e : (red, green, blue); p : POINTER TO DINT; pb : POINTER TO BYTE; ref : REFERENCE TO DINT;
 pair, pair2 : Pair; c, d : Count; h : Holder; mt : Meter;
 l : LINT; a : ARRAY[0..9] OF DINT; us : USINT; si : SINT;"""
# what stands in a loop beside statements that change x, n, sum and read them
WAYS = {
    "nothing": "",
    "own name": "PLC_PRG.x := PLC_PRG.x + 2; PLC_PRG.n := 0;",
    "own counter": "PLC_PRG.i := PLC_PRG.i + 1;",
    "pointer": "p := ADR(x); p^ := p^ + 1;",
    "pointer index": "p := ADR(a); p[i] := x; x := x + p[1];",
    "reference": "ref REF= x; ref := ref + 5;",
    "bytes": "pb := ADR(x); pb^ := 7;",
    "MEMSET": "SysMemSet(ADR(x), 1, 2);",
    "in-out": "b := AddTo(v := x, o => y); y := y + x;",
    "address": "b := Through(ADR(x)) OR x > 5;",
    "outputs": "c(step := x, n => x, twice => n);",
    "ENO": "z := AddToG(EN := n > 1, 2, ENO => b); IF b THEN n := n + 3; END_IF",
    "global": "g := g + x; x := AddToG(2); g := g - 1;",
    "block with itself": "c.other := ADR(d); d.other := ADR(c); c.left := 2; d.left := 1; c(step := 1); x := x + c.n;",
    "child and parent": "h.inner.parent := ADR(h); h.inner(); x := h.inner.n;",
    "methods": "mt(); x := x + mt.Up() + mt.Level; mt.Level := x; n := n + TO_INT(mt.Up());",
    "another program": "Other(); x := x + Other.k; g := g + 1;",
    "bits": "w.3 := NOT w.3; w := w + 1; w.%B1 := 16#A; x.5 := b; b := NOT b;",
    "loop": "FOR j := 1 TO n DO x := x + j; IF j = 3 THEN EXIT; END_IF END_FOR; x := x + j;",
    "inner while": "WHILE x MOD 7 <> 0 DO x := x + 1; IF x > 90 THEN CONTINUE; END_IF y := y + x; END_WHILE",
    "struct": "pair.a := x; pair2 := pair; x := pair2.a + pair2.b; pair.b := pair.b + 1;",
    "wrap": "us := us + 100; si := si * 3 + 50; s := s * 1000 + us - si; w := w * 300; l := l * 7 + us;",
    "types": "t := t + T#3ms; e := blue; IF t > T#5ms THEN e := red; END_IF r := r / 3 + 1; b := b XOR e = red;",
    "jump": "IF x > 5 THEN JMP low; END_IF x := x + 3; low: x := x + 1; n := n - 1;",
    "set": "b S= x > 3; x := x + SEL(b, 1, 2); b R= x > 6;",
    "assigned twice": "x := y := x + 1; y := y + x;",
    "operators": "IF x > 2 AND_THEN AddTo(v := y, o => z) OR_ELSE AddTo(v := z, o => x) THEN z := z + x; END_IF",
}  # fmt: skip
LOOPS = {
    "FOR": "FOR i := 1 TO 6 DO x := x + i; n := n + 1; sum := sum + x; {} END_FOR",
    "FOR BY": "FOR i := 6 TO 1 BY -2 DO {} x := x + i; n := n + 1; sum := sum + x; END_FOR",
    "WHILE": "i := 0; WHILE i < 6 AND x < 5000 DO i := i + 1; {} x := x + i; n := n + 1; sum := sum + x; END_WHILE",
    "REPEAT": "i := 0; REPEAT i := i + 1; x := x + i; {} n := n + 1; sum := sum + x; UNTIL i > 5 OR x > 5000 "
    "END_REPEAT",
    "nested": "FOR j := 1 TO 2 DO x := x + j; FOR i := 1 TO 3 DO n := n + 1; x := x + n; {} END_FOR "
    "sum := sum + x; END_FOR",
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_a_loop_leaves_the_same_with_and_without_copies(way):
    before, programs = BEFORE, []
    text = WAYS[way]
    for number, loop in enumerate(LOOPS.values()):
        if way == "loop" and loop is LOOPS["nested"]:
            continue  # its counter is taken
        name = f"P{number}"
        body = loop.format(text).replace("PLC_PRG", name).replace("low", f"low{number}")
        programs.append((name, f"PROGRAM {name}\nVAR {DECLARATIONS} END_VAR\n{body}\nEND_PROGRAM\n"))
    calls = "".join(f"{name}(); " for name, _ in programs)
    source = before + "".join(text for _, text in programs) + program(calls, "x : DINT;")
    left = []
    for probes in (False, True):
        made, _ = build([Source(source, "case.st")], None, [LIBRARY], False, probes)
        machine = Machine(made)
        machine.run(3)
        left.append({n: values.read(machine.memory, paths.resolve(made, n)) for n in [p for p, _ in programs]})
    assert left[0] == left[1]
    assert any(x["x"] not in (0, None) for x in left[0].values())
