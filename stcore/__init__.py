"""stcore: Structured Text (IEC 61131-3) compiled to WebAssembly. It knows no motion, no project files, no clock."""

from stcore.compiler import compile, compile_condition, diagnose
from stcore.diagnostics import CompileError, Diagnostic
from stcore.faults import Fault

__all__ = ["CompileError", "Diagnostic", "Fault", "compile", "compile_condition", "diagnose"]
