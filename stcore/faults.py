"""Faults of a running program, and where they happened.

The emitter puts a dropped constant - the number of a site - in front of every statement and check. It costs nothing at
run time: wasmtime removes it. When a module traps, the function's bytes are read up to the trap and the last such
constant tells the place.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

from stcore.codes import CODES
from stcore.program import FAULT_A, FAULT_HIGH, FAULT_LOW, NULL_PAGE, SCAN, Program, Site

ASSERTIONS = Path(__file__).parent / "library" / "testing"


class Fault(Exception):
    """A run-time fault: code, message, file, line, column, instance (path of the POU instance), scan, hint.

    stack: the sites of the calls that were under way, innermost first.
    """

    def __init__(
        self, code: str, message: str, site: Site | None, instance: str, scan: int, hint: str,
        stack: Sequence[Site] = (),
    ) -> None:  # fmt: skip
        self.code = code
        self.message = message
        self.file = site.file if site else ""
        self.line = site.line if site else 0
        self.column = site.column if site else 0
        self.instance = instance
        self.scan = scan
        self.hint = hint
        self.stack = list(stack)
        super().__init__(f"{self.file}:{self.line}:{self.column}: fault {code} in {instance}, scan {scan}: {message}")

    def __reduce__(self):
        site = Site(self.file, self.line, self.column, "")
        return Fault, (self.code, self.message, site, self.instance, self.scan, self.hint, self.stack)


def locate(program: Program, memory: memoryview, code: str, frames: list[tuple[int, int]], cause: str = "") -> Fault:
    """The fault of a trap. frames: (function index, offset in the module), innermost first."""
    found = _sites(program, frames)
    sites = [s for s in found if s is not None]
    whole = not found or found[-1] is None  # the scan loop has no site; a deep nesting hides the outer frames
    what = sites[0].note if sites else ""
    if len(sites) > 1 and sites[0].code in ("F0105", "F0109"):
        code = sites[0].code
        sites = sites[1:]  # the call, not the function that had no room or found no instance
    site = sites[0] if sites else None
    if not code:
        code = site.code if site and site.code else "F0107"
    # an assertion that does not hold is the business of who made it
    site = next((s for s in sites if Path(s.file).parent != ASSERTIONS), site)
    values = struct.unpack_from("<q", memory, FAULT_A)[0]
    low, high = (struct.unpack_from("<q", memory, at)[0] for at in (FAULT_LOW, FAULT_HIGH))
    if code == "F0103" and values >= NULL_PAGE:
        code = "F0104"
    entry = CODES[code]
    named = {"value": values, "low": low, "high": high, "what": what, "cause": cause}
    scan = struct.unpack_from("<q", memory, SCAN)[0]
    path = instance_path(sites) if whole else f"...{instance_path(sites)}"
    return Fault(code, entry.message.format(**named), site, path, scan, entry.hint.format(**named), sites)


def calls_under_way(program: Program, frames: list[tuple[int, int]]) -> list[Site]:
    """The sites of the calls that a stack holds, innermost first; frames as for `locate`."""
    return [s for s in _sites(program, frames) if s is not None]


def instance_path(sites: Sequence[Site]) -> str:
    """The instance path, from the outermost POU inwards: names of the instances called, where they are known."""
    parts: list[str] = []
    for site in reversed(sites):
        parts = parts or [site.pou]
        if site is not sites[0] and site.note and not site.code:
            parts.append(site.note)
    if sites and len(sites) > 1 and not any(s.note and not s.code for s in sites[1:]):
        parts.append(sites[0].pou)
    return ".".join(parts)


def _sites(program: Program, frames: list[tuple[int, int]]) -> list[Site | None]:
    bodies = _Bodies(program.wasm)
    found: list[Site | None] = []
    for _, offset in frames:
        number = bodies.last_marker(offset)
        site = program.sites[number] if number is not None and 0 <= number < len(program.sites) else None
        found.append(site)
        while site is not None and site.within >= 0:  # code that was taken into its caller has no frame of its own
            site = program.sites[site.within]
            found.append(site)
    return found


class _Bodies:
    """The function bodies of a module, as (start of code, end) offsets."""

    def __init__(self, wasm: bytes) -> None:
        self.wasm = wasm
        self.spans = self._code_section()

    def _leb(self, at: int) -> tuple[int, int]:
        value = shift = 0
        while True:
            byte = self.wasm[at]
            value |= (byte & 127) << shift
            at, shift = at + 1, shift + 7
            if byte < 128:
                return value, at

    def _signed(self, at: int) -> tuple[int, int]:
        start = at
        value, at = self._leb(at)
        bits = 7 * (at - start)
        return (value - (1 << bits) if self.wasm[at - 1] & 64 else value), at

    def _code_section(self) -> list[tuple[int, int]]:
        at, spans = 8, []
        while at < len(self.wasm):
            kind, (size, at) = self.wasm[at], self._leb(at + 1)
            if kind == 10:
                count, body = self._leb(at)
                for _ in range(count):
                    length, body = self._leb(body)
                    spans.append((body, body + length))
                    body += length
            at += size
        return spans

    def last_marker(self, offset: int) -> int | None:
        """The last dropped constant before an offset, in the function that holds it."""
        span = next((s for s in self.spans if s[0] <= offset < s[1]), None)
        if span is None:
            return None
        at = span[0]
        groups, at = self._leb(at)
        for _ in range(groups):
            _, at = self._leb(at)
            at += 1
        found = pending = None
        while at < offset:
            op = self.wasm[at]
            if op == 0x1A and pending is not None:
                found = pending
            pending = None
            if op == 0x41:
                pending, at = self._signed(at + 1)
            else:
                at = self._skip(op, at + 1)
        return found

    def _skip(self, op: int, at: int) -> int:
        """The offset behind an instruction's immediates."""
        if op in (0x02, 0x03, 0x04):  # block, loop, if: a block type
            return self._signed(at)[1]
        if op in (0x0C, 0x0D, 0x10, 0x12, 0x20, 0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0xD2):
            return self._leb(at)[1]
        if op == 0x0E:  # br_table
            count, at = self._leb(at)
            for _ in range(count + 1):
                _, at = self._leb(at)
            return at
        if op == 0x11 or 0x28 <= op <= 0x3E:  # call_indirect; loads and stores
            return self._leb(self._leb(at)[1])[1]
        if op in (0x3F, 0x40):
            return at + 1
        if op == 0x42:
            return self._signed(at)[1]
        if op == 0x43:
            return at + 4
        if op == 0x44:
            return at + 8
        if op == 0x1C:  # select with types
            count, at = self._leb(at)
            return at + count
        if op == 0xFC:
            sub, at = self._leb(at)
            return at + {8: 2, 9: 1, 10: 2, 11: 1}.get(sub, 0)
        if op == 0xFE:
            _, at = self._leb(at)
            return self._leb(self._leb(at)[1])[1]
        return at
