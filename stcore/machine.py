"""The machine: a compiled program in wasmtime. The only file that knows wasmtime."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import os
import struct
import threading
from collections.abc import Callable, Mapping
from itertools import takewhile

import wasmtime

from stcore import cache
from stcore import types as t
from stcore.faults import Fault, calls_under_way, locate
from stcore.program import HOST_FAILED, INTERRUPT, INTERVAL, TASK_RATIOS, UNTIL, External, Program, Site
from stcore.recent import Recent

# What a trap of wasmtime is to a PLC programmer; 'unreachable' is a check of ours, whose site names the fault.
_TRAPS = {
    wasmtime.TrapCode.INTEGER_DIVISION_BY_ZERO: "F0102",
    wasmtime.TrapCode.MEMORY_OUT_OF_BOUNDS: "F0104",
    wasmtime.TrapCode.STACK_OVERFLOW: "F0105",
}
_PAGE = 65536
SIDE = "side"  # the name that side modules carry


def _engine() -> wasmtime.Engine:
    config = wasmtime.Config()
    config.cranelift_opt_level = "speed"
    config.max_wasm_stack = 1 << 20
    config.wasm_threads = True
    return wasmtime.Engine(config)


_ENGINE: wasmtime.Engine | None = None


def engine() -> wasmtime.Engine:
    global _ENGINE
    if _ENGINE is None:
        _ENGINE = _engine()
    return _ENGINE


def assemble(text: str) -> bytes:
    """WebAssembly text to its binary form."""
    return bytes(wasmtime.wat2wasm(text))


class _Ahead(threading.Thread):
    """Makes the machine code of a module while other work goes on: the compiler of wasmtime needs no interpreter."""

    def __init__(self, wasm: bytes) -> None:
        super().__init__(name="machine code", daemon=True)
        self.wasm = wasm
        self.module: wasmtime.Module | None = None

    def run(self) -> None:
        with contextlib.suppress(wasmtime.WasmtimeError):  # raised again by load_module
            self.module = _load(self.wasm)


_ahead: _Ahead | None = None
_modules: Recent[bytes, wasmtime.Module] = Recent(8)  # that this process has loaded


def _wait() -> None:
    """A child has none of the threads that it was forked amid: it takes over what is finished."""
    if _ahead is not None:
        _ahead.join()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_wait)


def load_ahead(wasm: bytes) -> None:
    """Begin with what load_module will be asked for next."""
    global _ahead
    if wasm in _modules:
        return
    engine()  # made by this thread, so that there is one
    _ahead = _Ahead(wasm)
    _ahead.start()


def load_module(wasm: bytes) -> wasmtime.Module:
    """The module's machine code: of this process, from the cache, or compiled and kept there."""
    return _modules.get(wasm) or _modules.keep(wasm, _from_ahead(wasm) or _load(wasm))


def _from_ahead(wasm: bytes) -> wasmtime.Module | None:
    global _ahead
    begun, _ahead = _ahead, None
    if begun is None or begun.wasm != wasm:
        return None
    begun.join()
    return begun.module


def _load(wasm: bytes) -> wasmtime.Module:
    key = cache.digest(wasm)
    kept = cache.load("native", key)
    if kept is not None:
        try:
            return wasmtime.Module.deserialize(engine(), kept)
        except wasmtime.WasmtimeError:
            kept = None  # made on another processor or by another wasmtime: compile again
    module = wasmtime.Module(engine(), wasm)
    cache.store("native", key, bytes(module.serialize()))
    return module


@functools.lru_cache(maxsize=64)
def _side_module(wasm: bytes) -> wasmtime.Module:
    return wasmtime.Module(engine(), wasm)


class HostError(Exception):
    """A function of the host failed or is missing."""


class Machine:
    """Runs a Program. The image can be read and written between runs, also after a fault.

    host: name of an external -> Python function. An external that is missing is a fault (F0106) when it is called.
    on_probe: called by a probed build where it stops, with (site, body, address of the instance, of the stack frame).
    """

    def __init__(self, program: Program, host: Mapping[str, Callable] | None = None) -> None:
        self.program = program
        self._store = wasmtime.Store(engine())
        module = load_module(program.wasm)
        imports = [self._import(e, (host or {}).get(e.name)) for e in program.externals]
        self.on_probe: Callable[[int, int, int, int], None] | None = None
        if program.probes:
            imports.insert(0, self._probe())
        self._instance = wasmtime.Instance(self._store, module, imports)
        exports = self._instance.exports(self._store)
        self._exports = exports
        self._memory: wasmtime.Memory = exports["memory"]
        self._hooks: wasmtime.Table = exports["hooks"]
        self._run: wasmtime.Func = exports["run"]
        self._init: wasmtime.Func = exports["init"]
        self._search_rows: wasmtime.Func = exports["search_rows"]
        self._sp: wasmtime.Global = exports["sp"]
        self._top = exports["stack_top"].value(self._store)
        self._host_error: BaseException | None = None
        self._trapped = True  # the first call sets the stack up
        self._used = program.limit
        self._conditions: dict[bytes, wasmtime.Func] = {}
        self._look: wasmtime.Func | None = None
        self._always: wasmtime.Func | None = None
        self._stacks: dict[tuple, list[Site]] = {}
        self._view: memoryview | None = None
        self._grow_to(program.limit + 64)
        self.initialise()

    # ------------------------------------------------------------------------------------------- memory

    @property
    def memory(self) -> memoryview:
        """The whole linear memory, writable. Take it anew after allocate()."""
        if self._view is None:
            size = self._memory.data_len(self._store)
            pointer = ctypes.addressof(self._memory.data_ptr(self._store).contents)
            self._view = memoryview((ctypes.c_ubyte * size).from_address(pointer)).cast("B")
        return self._view

    def allocate(self, size: int) -> int:
        """Room for the host beyond the program's memory; an address that is a multiple of 8."""
        address = (self._used + 7) // 8 * 8
        self._used = address + size
        self._grow_to(self._used)
        return address

    def _grow_to(self, size: int) -> None:
        have = self._memory.size(self._store) * _PAGE
        if size > have:
            self._memory.grow(self._store, (size - have + _PAGE - 1) // _PAGE)
            self._view = None

    # ---------------------------------------------------------------------------------------------- run

    def initialise(self) -> None:
        """The first image, then the initial values that the program works out itself."""
        program = self.program
        memory = self.memory
        interval = bytes(memory[INTERVAL : INTERVAL + 8])
        ratios = bytes(memory[TASK_RATIOS : TASK_RATIOS + 4 * len(program.timed)])
        memory[: program.image_end] = program.image
        memory[INTERVAL : INTERVAL + 8] = interval if any(interval) else struct.pack("<q", 10**6)
        default = struct.pack("<I", 1) * len(program.timed)
        memory[TASK_RATIOS : TASK_RATIOS + len(default)] = ratios if any(ratios) else default
        end = program.stack_top  # the counts of a probed build are not the program's
        memory[program.image_end : end] = bytes(end - program.image_end)
        self._conditions.clear()
        self._call(self._init)

    def run(self, scans: int) -> int:
        """Run up to `scans` scans in one call; the number done. Raises Fault; the image is as the fault left it."""
        return self._call(self._run, scans)

    def search_rows(self) -> None:
        """Have the recorded rows searched for changes that wait for more of them."""
        self._search_rows(self._store)

    def _call(self, function: wasmtime.Func, *args: int) -> int:
        if self._trapped:  # what trapped has not given its stack back
            self._sp.set_value(self._store, wasmtime.Val.i32(self._top))
            struct.pack_into("<i", self.memory, HOST_FAILED, 0)
            self._host_error = None
            self._trapped = False
        try:
            return function(self._store, *args)
        except wasmtime.Trap as trap:
            raise self._fault(trap) from None
        except BaseException:  # of a probe: the scan is given up in the middle
            self._trapped = True
            raise

    def _fault(self, trap: wasmtime.Trap, side=None) -> Fault:
        self._trapped = True
        # what the user typed runs in a module of its own: the program's part of the stack tells the place
        frames = [(f.func_index, f.module_offset) for f in trap.frames if f.module_name != SIDE]
        where = self.program
        if side is not None:  # a suspended run may lie below it on the stack
            frames = [(f.func_index, f.module_offset) for f in takewhile(lambda f: f.module_name != SIDE, trap.frames)]
            if not frames:
                where, frames = side, [(f.func_index, f.module_offset) for f in trap.frames if f.module_name == SIDE]
        return locate(where, self.memory, _TRAPS.get(trap.trap_code, ""), frames, str(self._host_error or ""))

    def interrupt(self) -> None:
        """Stop a run that is under way, from another thread: it ends with fault F0108 or after the scan."""
        struct.pack_into("<i", self.memory, INTERRUPT, 1)

    def clear_interrupt(self) -> None:
        struct.pack_into("<i", self.memory, INTERRUPT, 0)

    def set_until(self, *conditions: bytes | None) -> None:
        """End a run after the scan in which one of the conditions (compile_condition) holds; None: no condition."""
        wanted = [c for c in conditions if c is not None]
        if any(c not in self._conditions for c in wanted):
            # linking writes the constants of a condition, maybe over those of one that is not wanted any more
            self._conditions = {c: self._link(c)["side"] for c in wanted}
        for slot, condition in enumerate(wanted):
            self._hooks.set(self._store, slot, self._conditions[condition])
        struct.pack_into("<i", self.memory, UNTIL, len(wanted))

    def end_after_scan(self) -> None:
        """End the run that is under way after its present scan; set_until takes that back."""
        if self._always is None:
            module = wasmtime.Module(engine(), '(module (func (export "always") (result i32) (i32.const 1)))')
            self._always = wasmtime.Instance(self._store, module, []).exports(self._store)["always"]
        slot = struct.unpack_from("<i", self.memory, UNTIL)[0]
        self._hooks.set(self._store, slot, self._always)
        struct.pack_into("<i", self.memory, UNTIL, slot + 1)

    def until_holds(self, slot: int = 0) -> bool:
        """Whether a condition of set_until, by its place there, holds now: a run does not tell which one ended it."""
        return bool(self._hooks.get(self._store, slot)(self._store))

    # ------------------------------------------------------------------------------------- side modules

    def _link(self, wasm: bytes):
        """The exports of a side module (stcore/side.py), which shares this machine's memory, stack and functions."""
        module = _side_module(wasm)
        imports = [self._exports[i.name] for i in module.imports]
        exports = wasmtime.Instance(self._store, module, imports).exports(self._store)
        exports["init"](self._store)
        return exports

    def side(self, side) -> Callable[..., int]:
        """The function of a side module. It raises Fault like `run`, and may be called while a probe stops."""
        function = self._link(side.wasm)["side"]
        return lambda *args: self._nested(function, args, side)

    def hook(self, slot: int, side) -> int:
        """Put the function of a side module into one of HOOK_SLOTS, where the module itself can call it; the slot."""
        self._hooks.set(self._store, slot, self._link(side.wasm)["side"])
        return slot

    def call(self, export: str) -> object:
        """Call a function of the module that takes nothing (program.routines names it). Raises Fault."""
        return self._nested(self._exports[export], ())

    def _nested(self, function: wasmtime.Func, args: tuple, side=None) -> object:
        """A call that leaves the stack of a suspended run as it is. side: the module that the function is of."""
        before = self._sp.value(self._store)
        if not self.program.image_end < before <= self._top:
            self._sp.set_value(self._store, wasmtime.Val.i32(self._top))
        self._host_error = None
        struct.pack_into("<i", self.memory, HOST_FAILED, 0)
        try:
            return function(self._store, *args)
        except wasmtime.Trap as trap:
            raise self._fault(trap, side) from None
        finally:
            self._sp.set_value(self._store, wasmtime.Val.i32(before))
            struct.pack_into("<i", self.memory, HOST_FAILED, 0)

    # --------------------------------------------------------------------------------------------- host

    def calls_under_way(self) -> list[Site]:
        """For a function of the host that the module has called: the sites on the stack, innermost first.

        A trap in a call of our own tells the frames of the suspended run below it."""
        if self._look is None:
            module = wasmtime.Module(engine(), f'(module ${SIDE} (func (export "look") unreachable))')
            self._look = wasmtime.Instance(self._store, module, []).exports(self._store)["look"]
        try:
            self._look(self._store)
        except wasmtime.Trap as trap:
            frames = tuple((f.func_index, f.module_offset) for f in trap.frames if f.module_name != SIDE)
        if frames not in self._stacks:
            self._stacks[frames] = calls_under_way(self.program, list(frames))
        return self._stacks[frames]

    def _probe(self) -> wasmtime.Func:
        kinds = [wasmtime.ValType.i32()] * 4

        def stop(site: int, body: int, this: int, frame: int) -> None:
            if self.on_probe is not None:
                self.on_probe(site, body, this, frame)

        return wasmtime.Func(self._store, wasmtime.FuncType(kinds, []), stop)

    def _import(self, external: External, function: Callable | None) -> wasmtime.Func:
        kinds = [_value_type(k) for _, k in external.parameters]
        results = [_value_type(external.result)] if external.result is not None else []

        def call(*args):
            try:
                if function is None:
                    raise HostError(f"nothing provides the external function {external.name}")
                result = function(*args)
                return None if external.result is None else _as_result(result, external)
            except Exception as error:  # becomes the fault F0106 at the place of the call
                self._host_error = error
                struct.pack_into("<i", self.memory, HOST_FAILED, 1)
                return None if external.result is None else _as_result(0, external)

        return wasmtime.Func(self._store, wasmtime.FuncType(kinds, results), call)


def _value_type(kind: t.Type) -> wasmtime.ValType:
    base = t.base_of(kind)
    name = base.wasm if isinstance(base, t.Elementary) else "i32"
    return getattr(wasmtime.ValType, name)()


def _as_result(result: object, external: External) -> int | float:
    base = t.base_of(external.result)
    if not isinstance(result, int | float):
        raise HostError(f"{external.name} returned {result!r}, which is no {external.result}")
    if isinstance(base, t.Elementary) and base.kind == "real":
        return float(result)
    bits = 64 if isinstance(base, t.Elementary) and base.size == 8 else 32
    value = int(result) & ((1 << bits) - 1)
    return value - (1 << bits) if value >> (bits - 1) else value
