"""The names of one compilation, each resolved when something first needs it.

A name is looked for among the user's files, then among the sibling files, then in the library, whose files are read
only when a program uses them. Code of the library sees the library only: a user's own TON does not reach into it.
"""

from __future__ import annotations

from collections.abc import Callable
from fnmatch import fnmatchcase
from pathlib import Path

from stcore import syntax as s
from stcore import types as t
from stcore.cache import parse_cached
from stcore.declare import Declarer
from stcore.declare_types import Pending, align
from stcore.diagnostics import Reporter
from stcore.library import index, listed
from stcore.program import NULL_PAGE
from stcore.scope import Builtin, EnumValue, GlobalList, Init, Pou, TypeName, Var, key
from stcore.source import Source, read


class Project:
    """All names, types and storage of one compilation.

    evaluate: set by the checker; evaluates a constant expression of a declaration.
    """

    def __init__(self, reporter: Reporter, libraries: list[Path], siblings: list[Path] | None = None) -> None:
        self.reporter = reporter
        self.libraries = libraries
        self._listing_tables: list[dict] | None = None
        self.user: dict[str, Pending] = {}
        self.library: dict[str, Pending] = {}
        found = index(siblings or [], recursive=False)
        self.sibling_index = {name: path for name, path in found.items() if "<" not in name}
        self.sibling_extensions = [name.split("<") for name in found if "<" in name]  # (block, the one that it extends)
        self.library_index = index(libraries, recursive=True)
        self.loaded: dict[str, Source] = {}  # path -> source of every file read
        self.pous: list[Pou] = []  # declared, in order
        self.globals: list[Var] = []  # with storage, in order
        self.configured: dict[str, tuple[s.VarDecl, Source]] = {}  # VAR_CONFIG, by upper-case path
        self.access_paths: list[tuple[s.VarDecl, Source]] = []  # VAR_ACCESS
        self.configurations: list[tuple[s.Configuration, Source]] = []
        self.type_inits: dict[str, Init] = {}
        self.field_inits: dict[t.Field, Init] = {}
        self.array_inits: dict[t.Array, Init] = {}  # of a named array type
        self.element_inits: dict[t.Array, Init] = {}  # of elements whose named type has an initial value
        self.block_pous: dict[t.Block, Pou] = {}
        self.classes: list[t.Block] = []  # blocks whose instances begin with their number, by number from 1
        self.unknown: dict[Pou, set[str]] = {}  # upper-case names that mean nothing in a POU, and have been reported
        self.extensions: dict[str, list[s.Pou]] = {}  # upper-case name of a block -> those that extend it
        self.named_types: dict[str, t.Type] = {}
        self.declaring = 0  # declarations that are being resolved
        self.postponed: list[Callable[[], None]] = []  # to do when none is: the targets of pointers
        self.needs: list[str] = []  # library programs that a global list or a type brings along
        self.top = NULL_PAGE  # next free address of the image
        self.evaluate: Callable[[s.Node, Source, Pou | None, bool], object] = lambda *_: None
        self.is_builtin: Callable[[str], bool] = lambda _: False

    # ------------------------------------------------------------------------------------------- files

    def add_file(self, source: Source, *, library: bool = False, tree: s.File | None = None) -> s.File:
        """Read the declarations of a file. Its errors go to the reporter."""
        tree = tree or parse_cached(source, self.reporter)
        self.loaded[source.path] = source
        table = self.library if library else self.user
        for unit in tree.units:
            self._add_unit(unit, source, library, table)
        if "needs" in tree.attributes:
            self.needs.append(tree.attributes["needs"])
        return tree

    def _add_unit(self, unit: s.Node, source: Source, library: bool, table: dict[str, Pending]) -> None:
        match unit:
            case s.Pou():
                if unit.extends is not None:
                    self.extensions.setdefault(key(unit.extends.rpartition(".")[2]), []).append(unit)
                self._add(table, unit.name, Pending("pou", unit, source, library, at=unit.name_start))
            case s.TypeDecl():
                if "needs" in unit.attributes:
                    self.needs.append(unit.attributes["needs"])
                self._add(table, unit.name, Pending("type", unit, source, library, at=unit.name_start))
                if isinstance(unit.type, s.EnumDef) and "qualified_only" not in unit.attributes:
                    for name, at, _ in unit.type.items:
                        self._add(table, name, Pending("enum value", unit, source, library, unit.name, at=at))
            case s.VarSection():
                self._add_globals(unit, source, library, table)
            case s.Configuration():
                self.configurations.append((unit, source))
                for section in unit.sections:
                    self._add_globals(section, source, library, table)

    def _add_globals(self, section: s.VarSection, source: Source, library: bool, table: dict[str, Pending]) -> None:
        if section.kind == "VAR_CONFIG":
            self.configured |= {key(d.name): (d, source) for d in section.decls}
            return
        if section.kind == "VAR_ACCESS":
            self.access_paths += [(d, source) for d in section.decls]
            return
        name = section.name or Path(source.path).stem
        qualified = "qualified_only" in section.attributes
        if "needs" in section.attributes:
            self.needs.append(section.attributes["needs"])
        existing = table.get(key(name))
        if existing and existing.kind == "list":
            listed = existing.extra
        else:
            listed = GlobalList(name, set())
            if existing is None:
                table[key(name)] = Pending("list", section, source, library, listed, listed)
        for decl in section.decls:
            listed.variables.add(key(decl.name))
            entry = Pending("global", decl, source, library, (section, name), at=decl.start)
            table[key(f"{name}.{decl.name}")] = entry
            if isinstance(decl.type, s.EnumDef):
                for item, at, _ in decl.type.items:
                    self._add(table, item, Pending("enum value", decl, source, library, decl.name, at=at))
            if not qualified:
                self._add(table, decl.name, entry)

    def _add(self, table: dict[str, Pending], name: str, entry: Pending) -> None:
        first = table.get(key(name))
        if first is not None and first.kind == "list":
            first = None
        if first is not None and not entry.library:
            line = first.source.position(first.at)[0]
            where = "" if first.source.path == entry.source.path else f" of {first.source.path}"
            self.reporter.add("E0201", entry.source, entry.at, entry.at + len(name), name=name, line=f"{line}{where}")
            return
        if first is None:
            table[key(name)] = entry
        elif entry.library and entry.kind == "pou" and first.kind != "pou":
            table[listed(key(name))], table[key(name)] = first, entry
        elif entry.library and first.kind == "pou" and entry.kind != "pou":
            table[listed(key(name))] = entry

    # ------------------------------------------------------------------------------------------- names

    def lookup(self, name: str, library: bool = False) -> object | None:
        """The symbol of a global name, or None. library: asked by code of the library."""
        upper = key(name)
        if not library:
            entry = self.user.get(upper)
            if entry is None and upper in self.sibling_index and not self.is_builtin(upper):
                entry = self._load_sibling(upper)
            if entry is not None:
                return self._resolve(entry)
        if self.is_builtin(upper):
            return Builtin(upper)
        entry = self.library.get(upper)
        if upper in self.library_index and (
            entry is None or (entry.kind in ("global", "enum value") and listed(upper) in self.library_index)
        ):
            entry = self._load(upper)
        return None if entry is None else self._resolve(entry)

    def constant_beside(self, pou: Pou) -> object | None:
        """The constant of a library list that has the name of a library block: a value is meant, not the block."""
        name = listed(key(pou.name))
        if not pou.library or name not in self.library_index:
            return None
        entry = self.library.get(name) or self._load(name)
        return None if entry is None else self._resolve(entry)

    def _load(self, name: str) -> Pending | None:
        """Read the file of the library that the index names."""
        path = self.library_index[name]
        if path not in self.loaded:
            self.add_file(read(path), library=True)
        return self.library.get(name)

    def extensions_of(self, name: str) -> list[s.Pou]:
        """The blocks of the user that extend the one of this upper-case name, those of the sibling files too."""
        for block, base in self.sibling_extensions:
            if base == name and block not in self.user and block in self.sibling_index:
                self._load_sibling(block)
        return self.extensions.get(name, [])

    def _load_sibling(self, name: str) -> Pending | None:
        """Take what is asked for from the sibling that the index names, and nothing else."""
        path = self.sibling_index[name]
        source = self.loaded[path] = self.loaded.get(path) or read(path)
        wanted: dict[str, Pending] = {}
        quiet = Reporter()  # what is wrong elsewhere in a sibling is not this program's concern
        for unit in parse_cached(source, quiet).units:
            if not (isinstance(unit, s.Pou) and unit.kind == "PROGRAM"):
                self._add_unit(unit, source, False, wanted)
        for found, pending in wanted.items():
            self.user.setdefault(found, pending)
        return self.user.get(name)

    def spellings(self) -> dict[str, str]:
        """Misprints of names in the manuals of the libraries: printed -> meant, '*' for the rest of a name."""
        return {p: m for table in self._listings() for p, m in table.get("spellings", {}).items()}

    def takes_core_number(self, name: str) -> bool:
        """True for functions that other controllers of the family call with a core number in front."""
        return any(fnmatchcase(name.upper(), p.upper()) for x in self._listings() for p in x.get("core_number", []))

    def _listings(self) -> list[dict]:
        if self._listing_tables is None:
            import tomllib  # only printed listings need it

            files = [folder / "listings.toml" for folder in self.libraries]
            self._listing_tables = [tomllib.loads(f.read_text(encoding="utf-8")) for f in files if f.exists()]
        return self._listing_tables

    def known_names(self, library: bool = False) -> list[str]:
        """Every global name there is, for 'did you mean'."""
        names = list(self.library_index.names)
        if not library:
            for n, p in self.user.items():
                names.append(getattr(p.tree, "name", None) or n)
            names += self.sibling_index
        return names

    def _resolve(self, entry: Pending) -> object | None:
        if entry.symbol is not None:
            return entry.symbol
        if entry.busy:
            name = getattr(entry.tree, "name", "?")
            self.reporter.add("E0203", entry.source, entry.at, entry.at + len(name), name=name)
            return None
        entry.busy = True
        self.declaring += 1
        self._declare(entry)
        self.declaring -= 1
        entry.busy = False
        while self.postponed and not self.declaring:
            self.postponed.pop()()
        return entry.symbol

    def _declare(self, entry: Pending) -> None:
        match entry.kind:
            case "pou":
                entry.symbol = Declarer(self, entry.source, entry.library).pou(entry)
            case "type":
                entry.symbol = TypeName(self._type_decl(entry))
            case "enum value":
                holder = (self.library if entry.library else self.user)[key(entry.extra)]
                symbol = holder.early if holder.busy else self._resolve(holder)
                name = key(next(n for n, at, _ in entry.tree.type.items if at == entry.at))
                if symbol is not None:
                    number = {key(n): v for n, v in symbol.type.values.items()}.get(name)
                    entry.symbol = None if number is None else EnumValue(symbol.type, number)
            case "global":
                entry.symbol = Declarer(self, entry.source, entry.library).global_variable(entry)

    def _type_decl(self, entry: Pending) -> t.Type:
        tree = entry.tree
        made = Declarer(self, entry.source, entry.library).type(tree.type, tree.name)
        if isinstance(made, t.Enum) and isinstance(tree.init, s.Name):  # its own values need no name in front
            owner = s.Name(tree.init.start, tree.init.start, tree.name)
            tree.init = s.Member(tree.init.start, tree.init.end, owner, tree.init.name, tree.init.start)
        if tree.init is not None:
            self.type_inits[key(tree.name)] = Init(tree.init, entry.source, None, entry.library)
            if isinstance(made, t.Array) and not isinstance(tree.type, s.NamedType):
                self.array_inits[made] = self.type_inits[key(tree.name)]
        elif isinstance(tree.type, s.NamedType) and key(tree.type.name) in self.type_inits:
            self.type_inits[key(tree.name)] = self.type_inits[key(tree.type.name)]
        self.named_types[key(tree.name)] = made
        return made

    # ----------------------------------------------------------------------------------------- storage

    def allocate(self, size: int, alignment: int) -> int:
        """Room in the image."""
        address = align(self.top, max(alignment, 1))
        self.top = address + size
        return address

    def instance(self, pou: Pou) -> int:
        """The address of a program's one instance, given out when it is first asked for."""
        if pou.address is None:
            pou.address = self.allocate(pou.type.size, 8)
        return pou.address
