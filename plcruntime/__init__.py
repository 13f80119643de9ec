"""The soft PLC: loads a program, runs it in virtual time, shows and tests it. ``from plcruntime import PLC``."""

import sys

# Only newer ones are asked for, but any may be used; even the oldest must be able to read this file.
if sys.version_info < (3, 11):  # noqa: UP036
    _words = "scancycle needs Python 3.11 or newer; this is %d.%d: %s"  # noqa: UP031
    _words = _words % (sys.version_info[0], sys.version_info[1], sys.executable)
    # `python -m plcruntime` ends with the sentence alone, an import with a traceback that leads to the cause
    raise SystemExit(_words) if sys.argv[:1] == ["-m"] else ImportError(_words)

__all__ = ["PLC", "CompileError", "ConditionTimeout", "Fault", "PathError", "UsageError"]

_HOMES = {
    "PLC": "plcruntime.plc", "ConditionTimeout": "plcruntime.errors", "UsageError": "plcruntime.errors",
    "CompileError": "stcore.diagnostics", "Fault": "stcore.faults", "PathError": "stcore.paths",
}  # fmt: skip


def __getattr__(name):
    # loaded when asked for: `scancycle --help` needs none of it
    if name in _HOMES:
        import importlib

        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError("module 'plcruntime' has no attribute '" + name + "'")
