"""`{attribute 'only_with' := 'F'}`: a function of the library whose code only a program that needs F has."""

import pytest

from stcore.compiler import compile
from stcore.faults import Fault
from stcore.machine import Machine
from stcore.source import Source

LIBRARY = {
    "Order": "VAR_GLOBAL given : INT; END_VAR",
    "Give": "FUNCTION Give : INT VAR_INPUT n : INT; END_VAR\ngiven := n;\nGive := n;\nEND_FUNCTION",
    "Serve": "{attribute 'only_with' := 'Give'}\nFUNCTION Serve : INT\nServe := Detail(given) + 1;\nEND_FUNCTION",
    "Detail": "FUNCTION Detail : INT VAR_INPUT n : INT; END_VAR\nDetail := n * n / (n - 9);\nEND_FUNCTION",
    "Look": "FUNCTION Look : INT\nIF given <> 0 THEN\n  Look := Serve();\nEND_IF\nEND_FUNCTION",
}


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("library")
    for name, text in LIBRARY.items():
        (folder / f"{name}.st").write_text(text)
    return folder


def machine(library, body: str, probes: bool) -> Machine:
    text = f"PROGRAM P VAR n, m : INT; END_VAR\n{body}\nEND_PROGRAM"
    return Machine(compile([Source(text, "p.st")], libraries=[library], probes=probes))


def value(machine: Machine, offset: int) -> int:
    at = machine.program.variables["P"].address + offset
    return int.from_bytes(machine.memory[at : at + 2], "little", signed=True)


@pytest.mark.parametrize("probes", [False, True])
def test_with_the_other_it_is_there(library, probes):
    made = machine(library, "n := Look();\nm := Give(4);", probes)  # the caller comes first
    made.run(2)
    assert value(made, 0) == -2  # 16 / -5 is -3
    assert value(made, 2) == 4
    assert "DETAIL" in made.program.routines


@pytest.mark.parametrize("probes", [False, True])
def test_without_it_is_not(library, probes):
    made = machine(library, "n := Look();", probes)
    made.run(2)
    assert value(made, 0) == 0
    assert "DETAIL" not in made.program.routines


@pytest.mark.parametrize("probes", [False, True])
def test_calling_it_all_the_same_is_a_fault(library, probes):
    made = machine(library, "n := 3;\nm := Serve();", probes)
    with pytest.raises(Fault) as fault:
        made.run(1)
    assert fault.value.code == "F0107" and fault.value.file.endswith("Serve.st")
