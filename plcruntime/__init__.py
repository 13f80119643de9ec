"""The soft PLC: loads a program, runs it in virtual time, shows and tests it. ``from plcruntime import PLC``."""

from __future__ import annotations

import sys

if sys.version_info < (3, 11):  # noqa: UP036 - only newer ones are asked for, but any may be used
    # no f-string: the oldest must read this too
    _words = "scancycle needs Python 3.11 or newer; this is %d.%d: %s" % (*sys.version_info[:2], sys.executable)  # noqa: UP031
    # `python -m plcruntime` ends with the sentence alone, an import with a traceback that leads to the cause
    raise SystemExit(_words) if sys.argv[:1] == ["-m"] else ImportError(_words)

__all__ = ["PLC", "CompileError", "ConditionTimeout", "Fault", "PathError", "UsageError"]

_HOMES = {
    "PLC": "plcruntime.plc", "ConditionTimeout": "plcruntime.errors", "UsageError": "plcruntime.errors",
    "CompileError": "stcore.diagnostics", "Fault": "stcore.faults", "PathError": "stcore.paths",
}  # fmt: skip


def __getattr__(name: str):
    # loaded when asked for: `scancycle --help` needs none of it
    if name in _HOMES:
        import importlib

        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'plcruntime' has no attribute '{name}'")
