"""``scancycle demo``: a move, its plot, and what to type next."""

from __future__ import annotations

import argparse
from importlib import resources
from pathlib import Path

from plcruntime.cli import FAILED, output
from plcruntime.errors import UsageError

PLOT = Path("demo.png")
WATCH = ["PLC_PRG.position", "PLC_PRG.status"]
SECONDS = "5s"

_INTRODUCTION = """\
The program {file} moves an axis out and back with GT_ functions of a motion controller.
It is compiled to WebAssembly and runs on a simulated controller, in virtual time.
"""
_NEXT = """
{plot} shows position, velocity and acceleration. Now try:

  scancycle run {file} --for 5s --watch position,step --plot moves.html
  scancycle run {file} --until "PLC_PRG.step = 4" --trace moves.csv
  scancycle repl {file}    step through it; there: axes live
  scancycle list GT_*                        what the library has
  scancycle check my.st                      all mistakes of a file of yours, in one pass
  scancycle run my.st --set start=TRUE@1s    run it, with an input set at a time
"""


def execute(arguments: argparse.Namespace) -> int:
    from plcruntime.picture import axis_names
    from plcruntime.plc import PLC
    from plcruntime.plot import draw
    from stcore.diagnostics import CompileError

    file = Path(str(resources.files("plcruntime") / "demo" / "demo.st"))
    print(_INTRODUCTION.format(file=_short(file)))
    try:
        plc = PLC.load(file)
    except CompileError as error:
        output.print_diagnostics(error.diagnostics)
        return FAILED
    trace = plc.trace(*axis_names(plc, 5000), *WATCH)
    plc.run(SECONDS)
    speed = plc.time / plc.run_seconds if plc.run_seconds else 0.0
    rows = [(name, plc.show(name), str(plc.place(name).type)) for name in (*WATCH, "PLC_PRG.step", "PLC_PRG.failed")]
    output.print_table(("variable", "value", "type"), rows)
    print(f"{plc.time:g} s of virtual time in {1000 * plc.run_seconds:.1f} ms: {speed:,.0f} times real time.")
    try:
        draw(trace, PLOT, plc=plc, title="Two moves of an axis", watched=WATCH[1:])
    except OSError as error:
        raise UsageError(f"can't write {PLOT}: {error.strerror}") from None
    print(_NEXT.format(plot=PLOT, file=_short(file)))
    return 0


def _short(file: Path) -> str:
    """Relative to the current folder where that is shorter."""
    try:
        return str(file.relative_to(Path.cwd()))
    except ValueError:
        return str(file)
