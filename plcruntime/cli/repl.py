"""``scancycle repl``: load, stop before the first scan, prompt."""

from __future__ import annotations

import argparse

from plcruntime.cli import DONE, FAILED
from stcore.diagnostics import CompileError


def execute(arguments: argparse.Namespace) -> int:
    from plcruntime.plc import PLC

    try:
        plc = PLC.load(arguments.files, arguments.task_interval, arguments.config, probes=True)
    except CompileError as error:
        from plcruntime.cli import output

        output.print_diagnostics(error.diagnostics)
        return FAILED
    from plcruntime.repl import Repl

    Repl(plc).loop()
    return DONE
