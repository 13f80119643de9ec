"""Methods, properties and interfaces at the prompt."""

import pytest

from plcruntime.repl.completion import candidates
from stcore.paths import PathError

TEXT = """\
INTERFACE IValve
METHOD Open : BOOL
VAR_INPUT percent : REAL := 100; END_VAR
END_METHOD
PROPERTY IsOpen : BOOL GET END_GET END_PROPERTY
END_INTERFACE
FUNCTION_BLOCK Valve IMPLEMENTS IValve
VAR pos : REAL; n : INT; END_VAR
METHOD Open : BOOL
VAR_INPUT percent : REAL := 100; END_VAR
VAR old : REAL; END_VAR
  old := pos;
  pos := percent;
  n := n + 1;
  Open := TRUE;
END_METHOD
PROPERTY IsOpen : BOOL
GET
  IsOpen := pos > 0;
END_GET
END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK Fast EXTENDS Valve
METHOD Slam
  THIS^.Open(0);
END_METHOD
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR v : Valve; f : Fast; i : IValve; ok : BOOL; END_VAR
i := v;
i.Open(50);
ok := v.IsOpen;
END_PROGRAM
"""


@pytest.fixture
def source(tmp_path, monkeypatch):
    monkeypatch.setenv("SCANCYCLE_STATE", str(tmp_path / "state"))
    (tmp_path / "valve.st").write_text(TEXT)
    return tmp_path / "valve.st"


def test_break_and_step_in_a_method(prompt):
    assert prompt("break Valve.Open").endswith("old := pos;")
    assert "PLC_PRG.v (Valve.Open), in scan 0" in prompt("c")
    assert prompt("percent") == "50" and prompt("n := 5") == "" and prompt("IsOpen") == "FALSE"
    assert "pos := percent;" in prompt("next")
    where = prompt("where")
    assert where.startswith("PLC_PRG.v, ") and "valve.st:13, call depth 2" in where
    assert "ok := v.IsOpen" in prompt("out")
    assert "IsOpen := pos > 0" in prompt("into")
    assert "METHOD Open : BOOL" in prompt("list Valve.Open")


def test_calls(prompt):
    assert prompt("f.Open(20)") == "TRUE" and prompt("f.pos") == "20"
    assert prompt("f.Slam(); i := f") == "" and prompt("i.IsOpen") == "FALSE"
    assert prompt("v.Opne()") == "Valve has no member Opne; did you mean Open?"
    assert prompt.plc.evaluate("f.Open(percent := 7) AND f.IsOpen") is True


def test_completion(prompt):
    def completed(text: str) -> list[str]:
        return [name for name, _ in candidates(prompt.repl.session, text)]

    assert completed("v.O") == ["Open"] and completed("i.I") == ["IsOpen"] and completed("f.S") == ["Slam"]
    assert {"Open", "IsOpen", "Slam", "pos"} <= set(completed("f."))
    assert "Valve.Open" in completed("break Valve.")


@pytest.mark.parametrize("name", ["v.IsOpen", "f.IsOpen", "f.Slam", "v.Open"])
def test_code_has_no_place(prompt, name):
    with pytest.raises(PathError, match=rf"PLC_PRG.{name} is code, not a variable"):
        prompt.plc[name]


def test_an_interface_is_shown_and_kept_as_an_address(prompt):
    prompt.plc.scan()
    address = prompt.plc["i"]
    assert address == prompt.plc.place("v").address and prompt("i") == f"16#{address:08X}"
    snapshot = prompt.plc.snapshot()
    prompt.plc["i"] = 0
    prompt.plc.restore(snapshot)
    assert prompt.plc["i"] == address
