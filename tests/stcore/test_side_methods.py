"""Methods, properties and interfaces in what is typed beside a loaded program."""

import pytest
from side_session import Session

from stcore.diagnostics import CompileError
from stcore.faults import Fault
from stcore.known import Scene

TEXT = """
INTERFACE INamed
METHOD Name : STRING(20) VAR_INPUT before : STRING(5) := '<'; END_VAR END_METHOD
PROPERTY Size : LREAL GET END_GET SET END_SET END_PROPERTY
END_INTERFACE
FUNCTION_BLOCK Base IMPLEMENTS INamed
VAR held : LREAL := 2; calls : INT; END_VAR
METHOD Name : STRING(20) VAR_INPUT before : STRING(5) := '<'; END_VAR
Name := CONCAT(before, 'base');
END_METHOD
PROPERTY Size : LREAL
GET
Size := held;
END_GET
SET
held := Size;
END_SET
END_PROPERTY
METHOD Add : INT
VAR_INPUT up : INT := 7; END_VAR
VAR_OUTPUT twice : INT; END_VAR
calls := calls + 1; twice := 2 * up; Add := up + calls;
END_METHOD
METHOD PRIVATE Own : INT
Own := calls;
END_METHOD
calls := calls + 10;
END_FUNCTION_BLOCK
FUNCTION_BLOCK Derived EXTENDS Base
METHOD Name : STRING(20) VAR_INPUT before : STRING(5) := '<'; END_VAR
Name := CONCAT(SUPER^.Name(before), '+');
END_METHOD
calls := calls + 100;
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR b : Base; d : Derived; any : INamed := d; none : INamed; p : POINTER TO Base := ADR(d); two : INT; END_VAR
METHOD Sum : INT VAR_INPUT x : INT; END_VAR
Sum := two + x;
END_METHOD
two := 2;
END_PROGRAM
"""


@pytest.fixture(scope="module", params=[False, True], ids=["plain", "probed"])
def run(request) -> Session:
    return Session(TEXT, request.param, 1)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("b.Name()", "'<base'"), ("d.Name()", "'<base+'"), ("any.Name()", "'<base+'"), ("p^.Name('>')", "'>base+'"),
        ("any.Size", "2.0"), ("b.Size + 1", "3.0"), ("any = d", "TRUE"), ("none = 0", "TRUE"), ("PLC_PRG.Sum(5)", "7"),
    ],
)  # fmt: skip
def test_expressions(run, text, value):
    assert run(text) == value


def test_statements(run):
    run("b.calls := 0; d.calls := 0; any.Size := 5; b.Size := 6; none := b; two := none.Size")
    assert (run("d.Size"), run("two")) == ("5.0", "6")
    run("b.Add(3, twice => two)")
    assert (run("two"), run("b.calls"), run("b.Own()")) == ("6", "1", "1")
    run("p^(); b(); d()")
    assert (run("d.calls"), run("b.calls")) == ("200", "11")
    run("none := 0; two := 2")


def test_names_of_the_block_where_a_probe_stopped(run):
    scene = Scene("Base.Add", run.program.types["DERIVED"])
    this = run.program.variables["PLC_PRG"].address + run.program.types["PLC_PRG"].members["D"].offset
    assert run("Name()", scene, this) == "'<base+'"
    assert run("Size", scene, this) == run("d.Size")


def test_errors(run):
    with pytest.raises(CompileError, match="(?s)Base has no member Nam.*did you mean Name"):
        run("b.Nam()")
    with pytest.raises(Fault, match="none is NULL"):
        run("none.Name()")
