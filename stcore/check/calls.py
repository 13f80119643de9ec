"""Calls: of functions, of instances of blocks, of programs and actions."""

from __future__ import annotations

import pickle
from dataclasses import dataclass, field
from functools import reduce

from stcore import syntax as s
from stcore import types as t
from stcore.check import builtins
from stcore.check.arguments import Arguments
from stcore.check.conversions import always_fits, common, kind_of
from stcore.check.room import room_argument
from stcore.scope import ActionOf, Builtin, MethodOf, Pou, TypeName, Var, key


@dataclass(eq=False, slots=True)
class FunctionCall:
    """values: (parameter, argument) of inputs and in-outs in the order of declaration, argument None for the
    parameter's own initial value. outputs: (parameter, place) of those that are connected."""

    pou: Pou
    values: list[tuple[Var, s.Node | None]]
    outputs: list[tuple[Var, s.Node]]
    en: s.Node | None = None
    eno: s.Node | None = None


@dataclass(eq=False, slots=True)
class BlockCall:
    """A call of an instance: what to store into its inputs before, what to copy from its outputs after."""

    pou: Pou
    instance: s.Node | None  # None: a program, whose instance is known
    inputs: list[tuple[Var, s.Node]] = field(default_factory=list)
    in_outs: list[tuple[Var, s.Node | None]] = field(default_factory=list)
    outputs: list[tuple[Var, s.Node]] = field(default_factory=list)
    en: s.Node | None = None
    eno: s.Node | None = None

    @property
    def decides(self) -> bool:
        """Whether the instance may be of a block that extends the one known here, and then runs its own body."""
        return bool(self.pou.type.number) and self.instance is not None and is_borrowed(self.instance)


class Calls(Arguments):
    """Checks calls."""

    def call(self, node: s.Call, checked: bool = False) -> s.Node:
        """checked: the arguments have been checked already."""
        if isinstance(node.callee, s.Name):
            symbol = self.lookup(node.callee.name)
            if isinstance(symbol, Builtin):
                return builtins.check(self, symbol.name, node)
            if symbol is not None and self.pou is not None and symbol is self.pou.result:
                symbol = MethodOf(self.pou) if self.pou.holder else self.pou  # it calls itself
            if symbol is None and "TO_" in key(node.callee.name):
                made = self._overloaded_conversion(node)
                if made is not None:
                    return made
                symbol = self.lookup(_short_names(node.callee.name))
            if symbol is None:
                if self.numbered_instance(node.callee) is not None:
                    return self.call(node, checked)
                meant = self.meant(node.callee, node.callee.name, self.known_names())
                if meant is None:
                    self.unknown_name(node.callee, node.callee.name, "E0404")
                    return self._skip(node)
                node.callee.name = meant
                return self.call(node, checked)
        else:
            node.callee = self.expr(node.callee)
            symbol = node.callee.symbol
        return self._call_symbol(node, symbol, checked)

    def _call_symbol(self, node: s.Call, symbol: object, checked: bool) -> s.Node:
        if isinstance(symbol, Pou) and symbol.kind == "FUNCTION":
            return self._function(node, symbol, checked)
        if isinstance(symbol, Pou | MethodOf) and isinstance(node.callee, s.Name):
            self._use(node.callee, symbol)  # not a constant of the same name
        elif isinstance(node.callee, s.Name):
            node.callee = self.expr(node.callee)
            symbol = node.callee.symbol
        if isinstance(symbol, ActionOf):
            return self._action(node, symbol)
        if isinstance(symbol, MethodOf):
            return self.method_call(node, symbol, checked)
        kind = node.callee.type
        if kind is t.ERROR:
            return self._skip(node)
        if kind.__class__ is t.Pointer and isinstance(kind.target, t.Block):
            self.error("E0307", node.callee, name="()", base=self.text(node.callee))
            return self._skip(node)
        if isinstance(kind, t.Block):
            return self._block(node, kind, checked)
        instance = self.declare_instance(node.callee, symbol) if isinstance(symbol, Pou) else None
        if instance is not None:
            node.callee = self.expr(node.callee)
            return self._block(node, instance.type, checked)
        if isinstance(symbol, TypeName) or isinstance(symbol, Pou):
            self.error("E0405", node.callee, name=self.text(node.callee))
        else:
            self.error("E0406", node.callee, name=self.text(node.callee), type=kind)
        return self._skip(node)

    def _skip(self, node: s.Call) -> s.Node:
        """Look at the arguments of a call that can't be checked, for their own errors."""
        for arg in node.args:
            if arg.value is not None and not arg.output:
                self.value(arg.value)
        return self.wrong(node)

    def _action(self, node: s.Call, symbol: ActionOf) -> s.Node:
        if node.args:
            self.error("E0401", node, name=self.text(node.callee), wanted=0, given=len(node.args))
        if self.pou is not None:
            self.pou.writes_instance = True
        node.symbol = symbol
        node.type = None
        return node

    def _overloaded_conversion(self, node: s.Call) -> s.Node | None:
        """TO_STRING(x): the library's conversion for the type of x."""
        target = key(node.callee.name).removeprefix("ANY_")[3:]
        if target not in ("STRING", "WSTRING") or len(node.args) != 1 or node.args[0].value is None:
            return None
        value = self.settle(self.value(node.args[0].value))
        if value.type is t.ERROR:
            return self.wrong(node)
        base = t.base_of(value.type)
        if isinstance(base, t.String) and base.wide == (target == "WSTRING"):
            return value
        name = f"{'W' * base.wide}STRING" if isinstance(base, t.String) else base.name
        return self.library_call(node, f"{name}_TO_{target}", [value])

    def library_call(self, node: s.Call, name: str, values: list[s.Node]) -> s.Node:
        """Call a function of the library with arguments that have been checked."""
        args = [s.Arg(v.start, v.end, None, v, False, False) for v in values]
        callee = s.Name(node.start, node.end, name)
        return self.call(s.Call(node.start, node.end, callee, args), checked=True)

    # --------------------------------------------------------------------------------------- functions

    def _function(self, node: s.Call, pou: Pou, checked: bool) -> s.Node:
        generic = bool(pou.tree.generics) and not pou.bindings
        if generic:
            pou = self._instantiate(node, pou, checked)
            if pou is None:
                return self._skip(node)
            checked = True
        if len(node.args) > len(pou.inputs()) and len(pou.inputs()) == 2 and generic:
            return self._chain(node, pou)
        bound = self.match(node, pou)
        if bound is None:
            return self._skip(node) if not checked else self.wrong(node)
        call = FunctionCall(pou, [], [])
        self.fill(node, call, bound, checked)
        self.use(pou)
        pou.calls += 1
        node.symbol = call
        node.type = pou.result.type if pou.result is not None else None
        if "real_result" in pou.attributes and node.type is t.LREAL and self._all_real(call):
            return self._wrapped(node, t.REAL)
        return node

    def fill(self, node: s.Call, call: FunctionCall, bound: dict, checked: bool) -> None:
        """The arguments and outputs of a call of a function or method."""
        pou = call.pou
        lacking = [p for p in pou.arguments() if p.section == "VAR_INPUT" and p not in bound and p.init is None]
        if lacking and not checked:
            self.warn("W0402", node, name=pou.name, missing=" and ".join(p.name for p in lacking))
        call.en, call.eno = self._enable(bound, pou)
        for parameter in pou.parameters:
            arg = bound.get(parameter)
            if parameter.section == "VAR_OUTPUT":
                if arg is not None and arg.value is not None:
                    call.outputs.append((parameter, self._output(arg, parameter)))
            elif parameter.room_of:
                call.values.append((parameter, room_argument(node, parameter, call.values)))
            else:
                call.values.append((parameter, self._argument(node, arg, parameter, pou, checked)))

    @staticmethod
    def _all_real(call: FunctionCall) -> bool:
        """True if what was given is REAL: then so is the result."""

        def origin(value: s.Node) -> t.Type:
            return value.operand.type if hasattr(value, "operand") and value.const is None else value.type

        given = [v for _, v in call.values if v is not None]
        real = [origin(v) is t.REAL for v in given]
        return any(real) and all(r or v.const is not None for r, v in zip(real, given, strict=True))

    def _chain(self, node: s.Call, pou: Pou) -> s.Node:
        """CONCAT(a, b, c): CONCAT(CONCAT(a, b), c)."""
        values = [a.value for a in node.args]
        inner = self.library_call(node, pou.name, values[:2])
        for v in values[2:]:
            inner = self.library_call(node, pou.name, [inner, v])
        return inner

    def _instantiate(self, node: s.Call, pou: Pou, checked: bool) -> Pou | None:
        """The function for the types of these arguments."""
        for arg in node.args:
            if arg.value is not None and not arg.output and not checked:
                arg.value = self.value(arg.value)
            if arg.value is not None and arg.value.type is t.ERROR:
                return None
        bindings: dict[str, t.Type] = {}
        given: dict[str, list[s.Node]] = {}
        names = {key(n): any_type for n, any_type in pou.tree.generics}
        declared = [d for x in pou.tree.sections if x.kind in ("VAR_INPUT", "VAR_IN_OUT") for d in x.decls]
        for i, arg in enumerate(node.args):
            decl = next((d for d in declared if arg.name and key(arg.name) in _names(d)), None)
            decl = decl or (declared[min(i, len(declared) - 1)] if arg.name is None else None)
            if decl is None or arg.value is None or not isinstance(decl.type, s.NamedType):
                continue
            name = key(decl.type.name)
            if name in names:
                bindings[name] = _bind(bindings.get(name), arg.value.type)
                given.setdefault(name, []).append(arg.value)
        parts = pou.attributes.get("parts")  # another function, where values of several parts or addresses are given
        if parts and any(isinstance(k, t.Array | t.Struct | t.Pointer) for k in bindings.values()):
            return self._instantiate(node, self.project.lookup(parts), True)
        for name, any_type in names.items():
            kind = bindings.get(name)
            literals = [v for v in given.get(name, ()) if v.type in _LITERALS]
            base = t.base_of(kind) if kind else None
            if literals and not (isinstance(base, t.Elementary) and all(always_fits(v, base) for v in literals)):
                kind = bindings[name] = reduce(_bind, (self.settle(v).type for v in given[name]))
            if key(any_type) == "ANY_POINTER" and _is_address(kind):
                kind = bindings[name] = t.Pointer(t.BYTE)
            elif key(any_type) == "ANY_POINTER" and isinstance(kind, t.Pointer) and isinstance(kind.target, t.Array):
                kind = bindings[name] = t.Pointer(kind.target.element)
            if kind is None or not _is_any(kind, key(any_type)):
                hint = "name one of its outputs" if parts and isinstance(kind, t.Block) else ""
                if key(any_type) == "ANY_POINTER":
                    any_type, hint = "a pointer", "give its address: ADR(...)"
                self.error("E0407", node, name=pou.name, wanted=any_type, given=kind or "nothing", hint=hint)
                return None
            if isinstance(kind, t.String):
                bindings[name] = t.String(max(kind.length, 255), kind.wide)
        return self.project.instantiate(pou, bindings)

    # -------------------------------------------------------------------------------------------- blocks

    def _block(self, node: s.Call, kind: t.Block, checked: bool) -> s.Node:
        pou = self.project.block_pous[kind]
        bound = self.match(node, pou)
        if bound is None:
            return self._skip(node)
        call = BlockCall(pou, node.callee)
        call.en, call.eno = self._enable(bound, pou)
        for parameter in pou.parameters:
            arg = bound.get(parameter)
            if parameter.section == "VAR_OUTPUT":
                if arg is not None and not arg.output and arg.name and arg.value is not None:
                    self.error("E0412", arg, parameter=parameter.name)
                elif arg is not None and arg.value is not None:
                    call.outputs.append((parameter, self._output(arg, parameter)))
            elif parameter.section == "VAR_IN_OUT":
                place = self._argument(node, arg, parameter, pou, checked)
                call.in_outs.append((parameter, place))
            elif arg is not None and arg.value is not None:
                call.inputs.append((parameter, self._argument(node, arg, parameter, pou, checked)))
        self.use(pou)
        pou.calls += 1
        self._mark(node.callee, node.callee, True, True)
        if self.pou is not None:
            self.pou.writes_instance = True
            self.pou.writes_outside |= call.decides
        node.symbol, node.type = call, None
        return node



def is_borrowed(node: s.Node) -> bool:
    """Whether an instance is reached by its address alone, so that it may be of another block than the one declared."""
    match node:
        case s.Deref():
            return node.base.symbol != "super"
        case s.Index():
            return isinstance(node.base.type, t.Pointer)
        case s.Name() | s.Member() if isinstance(node.symbol, Var):
            return node.symbol.indirect
        case s.Member() if isinstance(node.symbol, t.Field):
            return node.symbol.by_reference
        case s.Call():
            return False
    return False


def _names(decl: s.VarDecl) -> set[str]:
    """A parameter's name, and the one it has in the standard where CODESYS has another."""
    return {key(decl.name), key(decl.attributes.get("also", decl.name))}


def _short_names(name: str) -> str:
    """TIME_OF_DAY_TO_STRING -> TOD_TO_STRING."""
    source, separator, target = key(name).partition("_TO_")
    return t.ALIASES.get(source, source) + separator + t.ALIASES.get(target, target)


def _bind(known: t.Type | None, kind: t.Type) -> t.Type:
    """The type that a generic name stands for, after one more argument."""
    if known is None:
        return kind
    if isinstance(known, t.Enum) and known is kind:
        return known
    if isinstance(known, t.String) and isinstance(kind, t.String):
        return t.String(max(known.length, kind.length), known.wide or kind.wide)
    return common(known, kind) or known


def _is_address(kind: t.Type | None) -> bool:
    """True for numbers that an address may be kept in, and for 0, which is NULL."""
    return kind is t.NULL or isinstance(kind, t.Elementary) and kind.kind in ("int", "bits") and kind.size >= 4


_LITERALS = (t.INT_LITERAL, t.REAL_LITERAL)
_ANY = {
    "ANY": None,
    "ANY_POINTER": ("pointer",),
    "ANY_STRING": ("string",),
    "ANY_NUM": ("int", "bits", "real"),
    "ANY_INT": ("int", "bits"),
    "ANY_REAL": ("real",),
    "ANY_BIT": ("bits", "bool"),
    "ANY_DATE": ("date",),
    "ANY_TIME": ("time",),
    "ANY_ELEMENTARY": ("int", "bits", "real", "bool", "time", "date", "string", "char"),
}


def _is_any(kind: t.Type, any_type: str) -> bool:
    wanted = _ANY.get(any_type)
    return wanted is None or kind_of(kind) in wanted


def copy_tree(tree: s.Node) -> s.Node:
    """A tree without annotations: each instance of a generic function is checked on its own copy."""
    return pickle.loads(pickle.dumps(tree))
