"""The soft PLC: loads a program, runs it in virtual time, shows and tests it. ``from plcruntime import PLC``."""

from __future__ import annotations

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
