"""The names of a compiled program, for what is typed beside it: a project made from a Program instead of from text."""

from __future__ import annotations

import functools
import struct
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stcore import syntax as s
from stcore import types as t
from stcore.check import CheckedProject
from stcore.declare_types import Pending
from stcore.diagnostics import Reporter
from stcore.library import Index, index
from stcore.paths import PathError, resolve
from stcore.program import Parameter, Program, Routine, Variable
from stcore.scope import EnumValue, GlobalList, Pou, TypeName, Var, key
from stcore.source import Source
from stcore.values import FORMATS, decode

NOWHERE = Source("")


def _placed(name: str, kind: t.Type, storage: str, address: int, **more) -> Var:
    """A variable of the program. It may have other names here, and its pointers are not known: no local may hold it."""
    return Var(name, kind, storage, address, addressed=True, **more)


@dataclass(slots=True)
class Scene:
    """Where a probe stopped: names of the POU's own variables are known there.

    block: of the instance, None in a function. locals: (name, type, offset in the frame, the frame holds its address).
    """

    pou: str
    block: t.Block | None
    locals: Sequence[tuple[str, t.Type, int, bool]] = ()


class Names:
    """The names of a Program, gathered once for all that is typed."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.exact: dict[str, object] = {}  # upper-case path of a variable or program -> symbol
        self.others: dict[str, object] = {}  # upper-case name of a type, a value of an enumeration, a function
        self.library: dict[str, object] = {}  # the same for the eyes of library code
        self.short: dict[str, dict[str, Var]] = defaultdict(dict)  # name without its program -> full path -> variable
        self.library_short: dict[str, dict[str, Var]] = defaultdict(dict)
        self.block_pous: dict[t.Block, Pou] = {}
        self.exports: dict[Pou, str] = {}
        self.choosers: dict[Pou, str] = {}  # exports that find out whose method or body an instance has
        self.defaults: dict[Var, bytes] = {}
        self._types()
        self._routines()
        self._variables()
        self._accesses()

    def _types(self) -> None:
        for name, kind in self.program.types.items():
            if isinstance(kind, t.Block):
                pou = self._block(kind)
                self.others.setdefault(name, TypeName(kind, pou))
                self.library.setdefault(name, TypeName(kind, pou))
                continue
            self.others.setdefault(name, TypeName(kind))
            self.library.setdefault(name, TypeName(kind))
            if isinstance(kind, t.Interface):
                pou = Pou("INTERFACE", kind.name, _tree("INTERFACE", kind.name), NOWHERE, type=kind, checked=True)
                self.block_pous[kind.target] = pou
            if isinstance(kind, t.Enum):
                for label, number in kind.values.items():
                    self.others.setdefault(key(label), EnumValue(kind, number))
        for kind, pou in self.block_pous.items():
            pou.base = self.block_pous.get(kind.base)
            if isinstance(pou.type, t.Interface):
                pou.interfaces = [self.block_pous[b.target] for b in pou.type.bases]

    def _block(self, kind: t.Block) -> Pou:
        """The POU of a block whose tree is not at hand."""
        pou = Pou(kind.kind, kind.name, _tree(kind.kind, kind.name), NOWHERE, type=kind, checked=True)
        for name, field in kind.members.items():
            static = field.section == "VAR_STAT"
            var = _placed(field.name, field.type, "global" if static else "this", field.offset, section=field.section)
            var.indirect = field.by_reference
            var.constant = field.constant
            if field.constant:
                var.read_only = "it is a CONSTANT"
                var.const = self.constant_at(field.type, field.offset) if static else None
            pou.variables[name] = var
        parameters = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")
        pou.parameters = [v for v in pou.variables.values() if v.section in parameters]
        self.block_pous[kind] = pou
        return pou

    def constant_at(self, kind: t.Type, address: int) -> object:
        """The value of a constant of the image, if it is one that an expression can be worked out with."""
        base = t.base_of(kind)
        if not isinstance(base, t.Elementary) or base.kind not in ("bool", "int", "bits", "real"):
            return None
        return decode(self.program.image, base, address)

    def _routines(self) -> None:
        for name, routine in self.program.routines.items():
            if not routine.export and not routine.chooser:
                continue
            if routine.kind in s.WRITTEN:
                pou = self._method(name, routine)
            else:
                pou = self._function(routine) if routine.kind == "FUNCTION" else self._code(routine)
            if pou is None:
                continue
            self.exports[pou] = routine.export
            if routine.chooser:
                self.choosers[pou] = routine.chooser
            if routine.kind == "FUNCTION":
                self.others[name] = pou
                if routine.library:
                    self.library[name] = pou

    def _function(self, routine: Routine) -> Pou:
        pou = Pou("FUNCTION", routine.name, _tree("FUNCTION", routine.name), NOWHERE, routine.library, checked=True)
        pou.symbol = f"$plc.{routine.export or routine.chooser}"
        pou.attributes = routine.attributes
        pou.writes_outside = True
        for p in routine.parameters:
            var = self._parameter(p, pou)
            pou.variables[key(p.name)] = var
            pou.parameters.append(var)
        if routine.result is not None:
            pou.result = Var(routine.name, routine.result, "local", section="RESULT", owner=pou)
        return pou

    def _method(self, path: str, routine: Routine) -> Pou | None:
        """A method of a block or interface that is known; path: Block.Method."""
        holder, _, name = path.partition(".")
        kind = self.program.types.get(holder)
        kind = kind.target if isinstance(kind, t.Interface) else kind
        pou = self._function(routine)
        pou.name = routine.name.split(".")[1]
        pou.kind, pou.tree, pou.holder = routine.kind, _tree(routine.kind, pou.name), self.block_pous.get(kind)
        if pou.holder is None:
            return None
        pou.type = pou.holder.type
        pou.holder.methods[name] = pou
        return pou

    def _parameter(self, parameter: Parameter, pou: Pou) -> Var:
        var = Var(parameter.name, parameter.type, "local", section=parameter.section, owner=pou)
        var.constant = parameter.constant
        var.room_of = parameter.room_of
        var.indirect = parameter.section == "VAR_IN_OUT"
        self.defaults[var] = parameter.default
        return var

    def _code(self, routine: Routine) -> Pou | None:
        """The POU of a block or program: its type is known already."""
        kind = self.program.types.get(key(routine.name))
        pou = self.block_pous.get(kind) if isinstance(kind, t.Block) else None
        if pou is None:
            return None
        pou.symbol = f"$plc.{routine.export}"
        pou.library = routine.library
        pou.attributes = routine.attributes
        for name, export in routine.actions.items():
            pou.actions[name] = s.Action(0, 0, export.rpartition(".")[2], 0, export)
        return pou

    def _variables(self) -> None:
        for path, variable in self.program.variables.items():
            if isinstance(variable.type, t.Block) and variable.type.kind == "PROGRAM":
                self._program(path, variable)
                continue
            var = self._global(variable)
            self.exact[path] = var
            head, _, name = path.rpartition(".")
            if head:
                self._list(self.exact, variable, head).variables.add(name)
                (self.library_short if variable.library else self.short)[name][variable.path] = var
            if variable.library:
                self.library[path] = var
                self.library.setdefault(name, var)
                if head:
                    self._list(self.library, variable, head).variables.add(name)

    @staticmethod
    def _list(table: dict[str, object], variable: Variable, head: str) -> GlobalList:
        found = table.get(head)
        if not isinstance(found, GlobalList):
            found = GlobalList(variable.path.rpartition(".")[0], set())
            table.setdefault(head, found)
        return found

    def _global(self, variable: Variable) -> Var:
        var = _placed(variable.name, variable.type, "global", variable.address, bit=variable.bit)
        var.library = variable.library
        if variable.constant:
            var.constant, var.read_only = True, "it is a CONSTANT"
            var.const = self.constant_at(variable.type, variable.address)
        return var

    def _program(self, path: str, variable: Variable) -> None:
        pou = self.block_pous.get(variable.type)
        if pou is None:
            return
        if pou.address is None:
            pou.address, pou.library = variable.address, variable.library
            self.exact[path] = pou
        else:  # one more instance of the program
            self.exact[path] = self._global(variable)
        if variable.library:
            self.library[path] = pou
            return
        for name, field in variable.type.members.items():
            if field.section == "VAR_TEMP":
                continue
            static = field.section == "VAR_STAT"
            address = field.offset if static else variable.address + field.offset
            var = _placed(field.name, field.type, "global", address, indirect=field.by_reference)
            original = pou.variables[name]
            var.constant, var.read_only, var.const = original.constant, original.read_only, original.const
            self.short[name][f"{variable.path}.{field.name}"] = var

    def _accesses(self) -> None:
        """The names that VAR_ACCESS gives to variables."""
        for name, (path, read_only) in self.program.accesses.items():
            place = resolve(self.program, path)
            if place.hops:  # behind a pointer, which may change: reached by its path only
                continue
            var = _placed(name, place.type, "global", place.address, bit=place.bit)
            if read_only or place.constant:
                var.read_only = "VAR_ACCESS has it READ_ONLY" if read_only else "it is a CONSTANT"
            self.exact.setdefault(name, var)

    @functools.cached_property
    def index(self) -> Index:
        """Which file of the library defines a name: looked up when a name is nowhere else."""
        return index(map(Path, self.program.libraries), recursive=True)


class Known(CheckedProject):
    """The project of one side module. top: where its own constants may begin."""

    def __init__(self, names: Names, reporter: Reporter, top: int) -> None:
        super().__init__(reporter, [])
        self.names = names
        self.top = top
        self.block_pous.update(names.block_pous)
        self.exports, self.defaults = names.exports, names.defaults
        self.frame: dict[Var, tuple[int, bool]] = {}
        self.local_names: dict[Var, str] = {}
        for name, symbol in names.library.items():
            self.library[name] = Pending("known", None, NOWHERE, True, symbol=symbol)

    def lookup(self, name: str, library: bool = False) -> object | None:
        if library:
            return super().lookup(name, True)
        upper = key(name)
        found = self.names.exact.get(upper)
        if found is None and "." not in upper:
            found = self._unique(name, self.names.short)
        if found is None:
            found = self.names.others.get(upper)
        if found is None:
            self.library_index = self.names.index
            found = super().lookup(name)
        if found is None and "." not in upper:
            found = self._unique(name, self.names.library_short)
        return found

    @staticmethod
    def _unique(name: str, table: dict[str, dict[str, Var]]) -> Var | None:
        found = table.get(key(name))
        if not found:
            return None
        if len(found) > 1:
            raise PathError(f"'{name}' is ambiguous: {', '.join(found)}")
        return next(iter(found.values()))

    def known_names(self, library: bool = False) -> list[str]:
        symbols = [*self.names.exact.items(), *self.names.others.items()]
        names = [p.name if isinstance(p, Pou) else n for n, p in symbols]
        shorts = [next(iter(v.values())).name for v in self.names.short.values()]
        self.library_index = self.names.index
        return [*shorts, *names, *super().known_names(library)]

    def scene_pou(self, scene: Scene | None) -> Pou:
        """The POU in which the text is understood."""
        pou = Pou("PROGRAM", "<input>", _tree("PROGRAM", "<input>"), NOWHERE, checked=True)
        if scene is None:
            return pou
        if scene.block is not None:
            known = self.block_pous[scene.block]
            pou.type = scene.block
            pou.base, pou.methods, pou.actions = known.base, known.methods, known.actions
            pou.variables.update({n: v for n, v in known.variables.items() if v.section != "VAR_TEMP"})
        for i, (name, kind, offset, by_reference) in enumerate(scene.locals):
            var = Var(name, kind, "local", indirect=True)
            self.frame[var] = (offset, by_reference)
            self.local_names[var] = f"$seen{i}"
            pou.variables[key(name)] = var
        return pou

    def check_reached(self) -> None:
        """Check the library code that the text needs. Raises PathError when it needs parts that the program lacks."""
        super().check_reached()
        errors = [d for d in self.reporter.diagnostics if d.severity == "error"]
        folders = tuple(str(folder) for folder in self.names.program.libraries)
        if errors and all(d.file.startswith(folders) for d in errors):
            raise PathError(
                f"that needs more of the library than this program uses ({errors[0].message}); call it there"
            )

    def check_addresses(self) -> None:
        """Raises PathError for a direct address outside its area, or a library name that needs more than itself."""
        program = self.names.program
        for area, (_, size) in zip("IQM", (program.inputs, program.outputs, program.markers), strict=True):
            if self.areas[area] > size:
                raise PathError(f"%{area} has {size} bytes in this program; the address lies outside")
        state = [v.name for v in self.globals if not v.constant]
        state += [p.name for p in self.pous if p.kind == "PROGRAM"]
        if state:
            raise PathError(f"that needs {state[0]} of the library, which this program does not use; call it there")
        self.areas = dict.fromkeys(self.areas, 0)

    @staticmethod
    def constant_of(kind: t.Type, data: bytes) -> object:
        """The number that the initial bytes of a parameter stand for."""
        base = t.base_of(kind)
        if not isinstance(base, t.Elementary):
            return int.from_bytes(data, "little")
        return struct.unpack("<" + FORMATS[base.name], data or bytes(base.size))[0]


def _tree(kind: str, name: str) -> s.Pou:
    """An empty POU: what is known of it is in its symbol."""
    return s.Pou(0, 0, kind, name, 0, None, [], [], [], [], {}, None, [], frozenset())
