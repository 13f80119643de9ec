"""``scancycle check``: all messages of the files, in one pass."""

from __future__ import annotations

import argparse
import sys

from plcruntime import sources
from plcruntime.cli import DONE, FAILED, output
from stcore.diagnostics import CompileError, as_json, gcc


def execute(arguments: argparse.Namespace) -> int:
    import mclib
    from stcore.compiler import diagnose

    files, project = sources.gather(arguments.files, arguments.config)
    libraries = [*project.libraries, *mclib.libraries(project.dialect)]
    with output.working("checking"):
        try:
            diagnostics = diagnose(files, libraries=libraries, strict=arguments.strict or project.strict)
        except CompileError as error:  # a file that can't be read
            diagnostics = error.diagnostics
    if arguments.format == "json":
        print(as_json(diagnostics))
    elif arguments.format == "gcc":
        for d in diagnostics:
            print(gcc(d))
    else:
        output.print_diagnostics(diagnostics)
        print(output.summary(diagnostics), file=sys.stderr if diagnostics else sys.stdout)
    return FAILED if any(d.severity == "error" for d in diagnostics) else DONE
