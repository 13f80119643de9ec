"""Declarations of one file: syntax to variables and POUs, with their layout."""

from __future__ import annotations

from functools import partial

from stcore import objects
from stcore import syntax as s
from stcore import types as t
from stcore.declare_types import Pending, TypeDeclarer, align
from stcore.direct import place_direct
from stcore.scope import Pou, Var, key


class Declarer(TypeDeclarer):
    """Resolves the declarations of one file."""

    # ----------------------------------------------------------------------------------------- globals

    def global_variable(self, entry: Pending) -> Var:
        section, list_name = entry.extra
        decl = entry.tree
        var = self._var(decl, section, None)
        var.storage = "global"
        var.source = self.source
        self._place_static(var)
        var.name = decl.name
        var.decl = decl
        entry.symbol = var
        self.project.globals.append(var)
        if var.constant:
            self._constant(var)
        var.section = f"VAR_GLOBAL {list_name}"
        return var

    def _place_static(self, var: Var) -> None:
        address = var.decl.address
        if address and "*" not in address:
            place_direct(var, address, lambda: self.error("E0206", var.decl, address=address))
        else:
            var.address = self.project.allocate(var.type.size, max(var.type.align, 4))

    def _constant(self, var: Var) -> None:
        """Evaluate a CONSTANT, if it is one that a value can stand for."""
        if var.init is None:
            start = var.decl.start
            self.project.reporter.add("W0202", self.source, start, start + len(var.name), name=var.name)
        elif not t.is_aggregate(var.type) or isinstance(var.type, t.String):
            if not isinstance(var.init.node, s.ArrayInit | s.StructInit):
                var.const = self.project.evaluate(var, self.source, var.owner, self.library)

    def _var(self, decl: s.VarDecl, section: s.VarSection, pou: Pou | None) -> Var:
        enum_name = f"{pou.name}.{decl.name}" if pou else decl.name
        later = section.kind == "VAR_IN_OUT" and self.project.declaring and isinstance(decl.type, s.NamedType)
        later = later and self._is_open(decl.type, pou)  # an address: the block it leads to may hold this one
        kind = t.ERROR if later else self.type(decl.type, enum_name, pou)
        q = section.qualifiers
        var = Var(
            decl.name, kind, "this", section=section.kind, constant="CONSTANT" in q, retain="RETAIN" in q,
            persistent="PERSISTENT" in q, owner=pou, decl=decl, source=self.source, library=self.library,
        )  # fmt: skip
        if later:
            self.project.postponed.append(lambda: self._type_later(var, decl, pou))
        var.also = key(decl.attributes.get("also", ""))
        var.room_of = key(decl.attributes.get("room_of", "")) if self.library else ""
        var.init = self.initial(decl, pou)
        if var.constant:
            var.read_only = "it is a CONSTANT"
        if section.kind != "VAR_IN_OUT":
            self._no_abstract(decl, kind)
        if isinstance(kind, t.Array) and not kind.bounds and section.kind != "VAR_IN_OUT":
            self.error("E0207", decl, name=decl.name)
        return var

    def _type_later(self, var: Var, decl: s.VarDecl, pou: Pou) -> None:
        var.type = self.type(decl.type, pou=pou)
        field = pou.type.members.get(key(var.name)) if pou.type is not None else None
        if field is not None:
            field.type = var.type

    # -------------------------------------------------------------------------------------------- POUs

    def pou(self, entry: Pending, bindings: dict[str, t.Type] | None = None) -> Pou:
        tree: s.Pou = entry.tree
        if tree.kind == "INTERFACE":
            return objects.interface(self, entry)
        pou = Pou(tree.kind, tree.name, tree, self.source, self.library, attributes=tree.attributes)
        pou.bindings = bindings or {}
        pou.serial = len(self.project.pous)
        pou.symbol = f"${tree.name if tree.name.isascii() else 'pou'}.{pou.serial}"
        for action in tree.actions:
            pou.actions[key(action.name)] = action
        if tree.kind == "FUNCTION":
            entry.symbol = pou  # a function may call itself
            if not tree.generics or bindings is not None:
                self._variables(pou)
                if tree.result is not None:
                    kind = self.type(tree.result, pou=pou)
                    pou.result = Var(tree.name, kind, "local", section="RESULT", owner=pou, library=self.library)
        else:
            pou.type = t.Block(tree.name, tree.kind, file=self.source.path, attributes=tree.attributes)
            self.project.block_pous[pou.type] = pou
            self.project.named_types[key(tree.name)] = pou.type
            if tree.kind == "FUNCTION_BLOCK":
                objects.extend(self, pou)
            self._variables(pou)
            if tree.methods:
                objects.declare_methods(self, pou)
            self._lay_out(pou)
        self.project.pous.append(pou)
        return pou

    def method(self, pou: Pou) -> None:
        """The variables of a method, and its result."""
        self._variables(pou)
        if pou.tree.result is not None:
            kind = self.type(pou.tree.result, pou=pou)
            pou.result = Var(pou.name, kind, "local", section="RESULT", owner=pou, library=self.library)

    def kept_variables(self, pou: Pou) -> None:
        """VAR_INST of a method: they live in the instance of its block."""
        for section in pou.tree.sections:
            for decl in section.decls if section.kind == "VAR_INST" else ():
                if key(decl.name) not in pou.variables:
                    pou.variables[key(decl.name)] = self._var(decl, section, pou)

    def _variables(self, pou: Pou) -> None:
        """Constants first: bounds, and initial values above them in the text, may use them."""
        sections = sorted(pou.tree.sections, key=lambda x: "CONSTANT" not in x.qualifiers)
        made: dict[int, Var] = {id(v.decl): v for v in pou.variables.values() if v.section == "VAR_INST"}
        inherited = {n: v for n, v in pou.variables.items() if v.owner is not pou}
        for section in sections:
            for decl in section.decls if "CONSTANT" in section.qualifiers else ():
                pou.later.setdefault(key(decl.name), partial(self._declare, decl, section, pou, made))
        for section in sections:
            for decl in section.decls:
                self._declare(decl, section, pou, made)
        order = [made[id(d)] for x in pou.tree.sections for d in x.decls if id(d) in made]
        order += [v for v in pou.variables.values() if v.section == "EDGE"]
        pou.variables = inherited | {key(v.name): v for v in order}
        pou.parameters += [v for v in order if v.section in ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")]

    def _declare(self, decl: s.VarDecl, section: s.VarSection, pou: Pou, made: dict[int, Var]) -> None:
        name, given = key(decl.name), decl
        pou.later.pop(name, None)
        if id(decl) in made:
            return
        first = pou.variables.get(name)
        if first is not None:
            where = first.source or self.source
            line = where.position(first.decl.start)[0]
            line = line if where is self.source else f"{line} of {where.path}"
            self.project.reporter.add(
                "E0201", self.source, decl.start, decl.start + len(decl.name), name=decl.name, line=line
            )
            return
        if section.kind == "VAR_EXTERNAL":
            var = self.project.lookup(decl.name, self.library)
            if not isinstance(var, Var):
                self.error("E0208", decl, name=decl.name)
                var = made[id(decl)] = Var(decl.name, t.ERROR, "global", decl=decl)
            pou.variables[name] = var
            return
        if pou.kind == "PROGRAM":
            decl = self._configured(decl, pou)
        var = self._var(decl, section, pou)
        pou.variables[name] = var
        made[id(given)] = var
        if decl.address and "*" not in decl.address:
            place_direct(var, decl.address, lambda: self.error("E0206", decl, address=decl.address))
        elif var.constant and section.kind == "VAR" or section.kind == "VAR_STAT":
            var.storage = "global"
            var.address = self.project.allocate(var.type.size, max(var.type.align, 4))
        elif pou.is_called or section.kind == "VAR_TEMP":
            var.storage = "local"
        var.indirect = section.kind == "VAR_IN_OUT"
        if "edge" in decl.attributes:
            self._edge(var, decl, pou)
        if var.constant and not var.indirect:
            self._constant(var)
        if var.constant and section.kind == "VAR_INPUT":
            var.storage = "local" if pou.is_called else "this"

    def _edge(self, var: Var, decl: s.VarDecl, pou: Pou) -> None:
        """Two hidden variables for an input with an edge: what the body sees, and the input at the last call."""
        edge = decl.attributes["edge"]
        if pou.is_called or var.section != "VAR_INPUT" or var.type is not t.BOOL:
            self.error("E0210", decl, edge=edge)
            return
        seen, last = (
            Var(f"{var.name}__{x}", t.BOOL, "this", section="EDGE", owner=pou, decl=decl, source=self.source)
            for x in (edge, "last")
        )
        pou.edges[key(var.name)] = seen
        pou.variables |= {key(v.name): v for v in (seen, last)}

    def _configured(self, decl: s.VarDecl, pou: Pou) -> s.VarDecl:
        """The declaration with the address and the initial value that VAR_CONFIG has for it."""
        found, _ = self.project.configured.get(key(f"{pou.name}.{decl.name}"), (None, None))
        if found is None:
            return decl
        made = s.VarDecl(decl.start, decl.end, *(getattr(decl, f) for f in s.VarDecl.fields))
        made.address = found.address or decl.address
        made.init = found.init or decl.init
        return made

    def _lay_out(self, pou: Pou) -> None:
        """Give each variable its place in an instance."""
        block = pou.type
        block.align = max(block.align, 4)
        if block.number and block.base is None:
            block.size = 4
        own = [v for v in pou.variables.values() if v.owner is pou and v.storage != "local"]
        for var in own + [v for m in pou.methods.values() for v in m.variables.values()]:
            size, alignment = (4, 4) if var.indirect else (var.type.size, var.type.align)
            size += 8 * getattr(var.type, "open", 0)  # low and high of each dimension of ARRAY[*]
            if var.storage == "this":
                var.address = align(block.size, alignment)
                block.size = var.address + size
                block.align = max(block.align, alignment)
            section = "VAR_STAT" if var.storage == "global" else var.section
            name = var.name if var.owner is pou else f"{var.owner.name}__{var.name}"
            field = t.Field(
                name, var.type, var.address, section, var.constant, var.retain, var.persistent, var.decl.attributes
            )
            if var.storage == "area":
                continue
            block.members[key(name)] = field
            if var.init is not None and var.storage == "this":
                self.project.field_inits[field] = var.init
        block.size = align(max(block.size, 4), block.align)
