import pytest

from plcruntime import PLC
from plcruntime.repl import Repl

PROGRAM = """\
TYPE TPoint : STRUCT x, y : LREAL; END_STRUCT END_TYPE
FUNCTION Twice : INT
VAR_INPUT a : INT := 7; END_VAR
VAR half : INT; END_VAR
half := a;
Twice := half * 2;
END_FUNCTION

FUNCTION_BLOCK Acc
VAR_INPUT d : INT; END_VAR
VAR_OUTPUT sum : INT; END_VAR
VAR_TEMP tmp : INT; END_VAR
tmp := Twice(d);
sum := sum + tmp;
END_FUNCTION_BLOCK

PROGRAM PLC_PRG
VAR
  n : INT; p : TPoint; acc : Acc; blocks : ARRAY[1..2] OF Acc; wait : TON; arr : ARRAY[1..3] OF INT := [1, 2, 3];
  txt : STRING := 'abc'; lim : INT := 10; flag : BOOL;
END_VAR
n := n + 1;
acc(d := 2);
blocks[2](d := n);
wait(IN := TRUE, PT := T#10ms);
IF n > lim THEN
  flag := TRUE;
END_IF
p.x := p.x + 0.5;
END_PROGRAM

PROGRAM Other
VAR lim : INT; END_VAR
lim := 1;
END_PROGRAM
"""


class Prompt:
    """A session without a terminal: a line in, what it says out."""

    def __init__(self, plc: PLC, capsys) -> None:
        self.repl = Repl(plc)
        self.plc = plc
        self._capsys = capsys

    def __call__(self, line: str) -> str:
        self._capsys.readouterr()
        assert self.repl.handle(line) is True
        return self._capsys.readouterr().out.rstrip("\n")

    def all(self, *lines: str) -> str:
        return [self(line) for line in lines][-1]


@pytest.fixture
def source(tmp_path, monkeypatch):
    monkeypatch.setenv("SCANCYCLE_STATE", str(tmp_path / "state"))
    file = tmp_path / "prog.st"
    file.write_text(PROGRAM)
    return file


@pytest.fixture
def prompt(source, capsys):
    made = Prompt(PLC.load(source), capsys)
    yield made
    made.repl.session.close()


@pytest.fixture
def line_of():
    """The number of the line of the program that begins with a text."""

    def find(text: str) -> int:
        return next(i for i, line in enumerate(PROGRAM.splitlines(), 1) if line.strip().startswith(text))

    return find
