"""Calls: arguments stored or passed, results and outputs taken."""

from __future__ import annotations

from collections.abc import Callable

from stcore import syntax as s
from stcore import types as t
from stcore.check.calls import BlockCall, FunctionCall
from stcore.check.methods import MethodCall
from stcore.emit import values
from stcore.emit.changes import acts, may_hold
from stcore.emit.dispatch import signature
from stcore.emit.expressions import Expressions
from stcore.emit.image import InitCall
from stcore.emit.values import address, constant, load, store, wasm_type
from stcore.program import HOST_FAILED
from stcore.scope import ActionOf, Pou, Var, key


def scalar_outputs(pou: Pou) -> list[Var]:
    """The outputs of a function that it returns beside its result; the others go through their address."""
    return [p for p in pou.parameters if p.section == "VAR_OUTPUT" and not t.is_aggregate(p.type)]


def aggregate_outputs(pou: Pou) -> list[Var]:
    return [p for p in pou.parameters if p.section == "VAR_OUTPUT" and t.is_aggregate(p.type)]


def abstract(pou: Pou) -> bool:
    """True for a method without code of its own."""
    return pou.holder.kind == "INTERFACE" or "ABSTRACT" in pou.tree.modifiers


class Calls(Expressions):
    """Emits calls."""

    def address_of(self, node: s.Node) -> str:
        return address(*self.place(node))

    def _default(self, var: Var) -> str:
        """An input that is not given: its declared initial value."""
        init = self.module.initial_value(var)
        if t.is_aggregate(var.type):
            return f"(i32.const {self.module.template(var) or self.module.zeros(var.type.size)})"
        return constant(init, var.type)

    def function_call(self, node: s.Call, call: FunctionCall) -> str:
        """The result of a function; its outputs are stored on the way."""
        pou = call.pou
        return self._called(node, call, lambda args: self.inline_function(pou, args) or self._plain_call(pou, args))

    def method_call(self, node: s.Call, call: MethodCall) -> str:
        """The result of a method. A fault in it tells the call by the name that it has here."""
        base, offset = self._instance_of(call)
        here = self.here
        site = self.module.site(self.source, node, self.pou.full_name, "", call.note, self.within)

        again = f"(drop (i32.const {here}))"  # the statement goes on: what else it calls is no part of the method

        def emit(args: list[str]) -> str:
            pou = call.pou
            results = "".join(f" (result {r})" for r in signature(pou)[1])
            if call.bound or self.module.dispatch.is_only(pou):
                self.here = site
                text = self.inline_function(pou, args, (base, offset))
                self.here = here
                if text is not None:
                    return f"(block{results} {text} {again})"
                self.module.need(pou)
                name = pou.symbol
            else:
                name = self.module.dispatch.method(pou)
            given = " ".join([address(base, offset), *args])
            return f"(block{results} {given} (drop (i32.const {site})) (call {name}) {again})"

        return self._called(node, call, emit)

    def init_call(self, init: InitCall, instance: str) -> None:
        """FB_init for an instance: bInitRetains is TRUE, bInCopyCode FALSE, since memory begins anew."""
        pou = init.method
        args = []
        for p in pou.inputs():
            value = init.given.get(key(p.name))
            args.append("(i32.const 1)" if key(p.name) == "BINITRETAINS" else self._argument(p, value))
        args += [self._aggregate_output(p, None) for p in aggregate_outputs(pou)]
        if pou.result is not None and t.is_aggregate(pou.result.type):
            args.append(address("(local.get $fp)", self.frame(pou.result.type.size, pou.result.type.align)))
        self.module.need(pou)
        self.line(f"(call {pou.symbol} {instance} {' '.join(args)})" + " drop" * len(signature(pou)[1]))

    def _instance_of(self, call: MethodCall) -> tuple[str, int]:
        """Where the instance of a method call is."""
        if call.base is None:
            return self.this_place()
        if isinstance(call.base.type, t.Interface):
            return self.deref_check(call.base), 0
        return self.place(call.base)

    def _called(self, node: s.Call, call: FunctionCall, emit: Callable[[list[str]], str]) -> str:
        """A call with its arguments, and what becomes of its result and outputs."""
        pou = call.pou
        enabled = self.value(call.en) if call.en is not None else ""
        args = [self._argument(p, v) + self._open_bounds(p, v) for p, v in call.values]
        outputs = dict((p, v) for p, v in call.outputs)
        args += [self._aggregate_output(p, outputs.get(p)) for p in aggregate_outputs(pou)]
        result = pou.result.type if pou.result is not None else None
        prefix = where = ""
        if result is not None and t.is_aggregate(result):
            where = address("(local.get $fp)", self.frame(result.size, result.align))
            args.append(where)
        text = emit(args)
        returned = "" if result is None else wasm_type(result)
        if pou.external:
            text = self._external(node, text, returned)
        stores = []
        for p in reversed(scalar_outputs(pou)):
            if p in outputs:
                temp = self.temp(wasm_type(p.type))
                stores.insert(0, (p, outputs[p], temp))
                prefix += f" (local.set {temp})"
            else:
                prefix += " drop"
        for p, place, temp in stores:
            prefix += " " + self._store_output(p, place, f"(local.get {temp})")
        prefix += f" {where}" if where else ""
        head = f"(block (result {returned})" if returned else "(block"
        if call.en is not None:
            return self._enabled(call, enabled, result, f"{text}{prefix}")
        return text if not prefix else f"{head} {text}{prefix})"

    def _plain_call(self, pou: Pou, args: list[str]) -> str:
        self.module.need(pou)
        return f"(call {pou.symbol} {' '.join(args)})"

    def _external(self, node: s.Call, text: str, returned: str) -> str:
        """A call of the host; when that fails, the fault is here."""
        fault = f"{self.marker(node, 'F0106')} (call $fault) unreachable"
        failed = f"(if (i32.load (i32.const {HOST_FAILED})) (then {fault}))"
        if not returned:
            return f"(block {text} {failed})"
        temp = self.temp(returned)
        return f"(block (result {returned}) (local.set {temp} {text}) {failed} (local.get {temp}))"

    def _enabled(self, call: FunctionCall, enabled: str, result: t.Type | None, text: str) -> str:
        """EN FALSE: the function is not called, its result is the initial value."""
        eno = self._eno(call.eno)
        if result is None:
            return f"(if {enabled} (then {text} {eno[0]}) (else {eno[1]}))"
        wasm = wasm_type(result)
        blank = constant(0, result) if not t.is_aggregate(result) else f"(i32.const {self.module.string('', False)})"
        return f"(if (result {wasm}) {enabled} (then {text} {eno[0]}) (else {eno[1]} {blank}))"

    def _eno(self, place: s.Node | None) -> tuple[str, str]:
        if place is None:
            return "", ""
        return tuple(self.store_text(place, f"(i32.const {x})") for x in (1, 0))

    def _argument(self, parameter: Var, node: s.Node | None) -> str:
        if parameter.section == "VAR_IN_OUT":
            if node is None:
                return "(i32.const 0)"
            return self.value(node) if isinstance(node.const, str) else self.address_of(node)
        return self._default(parameter) if node is None else self.narrow(node)

    def _open_bounds(self, parameter: Var, node: s.Node | None) -> str:
        """ARRAY[*]: the bounds go with the address."""
        dimensions = getattr(parameter.type, "open", 0)
        if not dimensions:
            return ""
        pairs = self.bounds_of(node) if node is not None else [("(i32.const 0)", "(i32.const -1)")] * dimensions
        return " " + " ".join(x for pair in pairs for x in pair)

    def _aggregate_output(self, parameter: Var, place: s.Node | None) -> str:
        if place is not None:
            return self.address_of(place)
        return address("(local.get $fp)", self.frame(parameter.type.size, parameter.type.align))

    def _store_output(self, parameter: Var, place: s.Node, value: str) -> str:
        base, goal = t.base_of(parameter.type), t.base_of(place.type)
        if isinstance(base, t.Elementary) and isinstance(goal, t.Elementary):
            value = values.convert(base, goal, value)
        return self.store_text(place, value)

    # -------------------------------------------------------------------------------------------- blocks

    def call_statement(self, node: s.ExprStmt) -> None:
        expr = node.expr
        symbol = getattr(expr, "symbol", None)
        self.mark(node)
        if isinstance(symbol, BlockCall):
            self.forget(expr)
            self.block_call(expr, symbol)
        elif isinstance(symbol, ActionOf):
            self.forget(expr)
            self.action_call(symbol)
        else:
            text = self.value(expr)
            self.line(text if expr.type is None else f"(drop {text})")

    def block_call(self, node: s.Call, call: BlockCall) -> None:
        """Inputs into the instance, its code, outputs out of it."""
        if call.en is not None:
            self.line(f"(if {self.value(call.en)} (then")
        base, offset = self._instance(call)
        given = self._store_inputs(call, base, offset)
        places: dict[Var, str] = {}
        for parameter, place in call.in_outs:
            text = self._argument(parameter, place)
            if place is not None:
                places[parameter] = name = self.keep("i32")
                self.line(f"(local.set {name} {text})")
                text = f"(local.get {name})"
            self.line(store(t.DWORD, base, offset + parameter.address, text))
            if getattr(parameter.type, "open", 0) and place is not None:
                for i, bound in enumerate(x for pair in self.bounds_of(place) for x in pair):
                    self.line(store(t.DINT, base, offset + parameter.address + 4 + 4 * i, bound))
        self.mark(node, note=self.source.text[node.callee.start : node.callee.end])
        decides = self._decides(call)
        if call.pou.kind == "PROGRAM" or decides or may_hold(call.instance):
            self.forget(node)
        if call.pou.kind == "PROGRAM":
            self.line(f"(call {self.module.need_instance(call.pou, None, offset)})")
        elif decides:
            name = self.module.dispatch.body(call.pou)
            self.line(f"(call {name} {address(base, offset)})")
        elif not self.inline_block(call.pou, base, offset, places, given):
            self.forget(node)
            self.module.need(call.pou)
            self.line(f"(call {call.pou.symbol} {address(base, offset)})")
        for parameter, place in call.outputs:
            self._take_output(parameter, place, base, offset)
        if call.en is not None:
            eno = self._eno(call.eno)
            self.line(f"{eno[0]}) (else {eno[1]}))")

    def _decides(self, call: BlockCall) -> bool:
        """Whether the instance may be of a block that extends the one known here, whose body is to run then."""
        return call.decides and not self.module.dispatch.is_only(call.pou)

    def _instance(self, call: BlockCall) -> tuple[str, int]:
        """Where the instance is, worked out once."""
        base, offset = self.place(call.instance)
        if base in ("", "(local.get $this)", "(local.get $fp)") or base.startswith("(local.get $v"):
            return base, offset
        temp = self.keep("i32")
        self.line(f"(local.set {temp} {base})")
        return f"(local.get {temp})", offset

    def _store_inputs(self, call: BlockCall, base: str, offset: int) -> dict[Var, str]:
        """The inputs of a block into its instance; the locals that hold them as well, for code that is taken in."""
        given: dict[Var, str] = {}
        for parameter, value in call.inputs:
            at = offset + parameter.address
            if t.is_aggregate(parameter.type):
                self.line(self.copy_text(parameter.type, address(base, at), value))
            elif self.inlining_suits(call.pou) and not parameter.addressed:
                given[parameter] = name = self.borrow(wasm_type(parameter.type))
                self.line(store(parameter.type, base, at, f"(local.tee {name} {self.narrow(value)})"))
            else:
                self.line(store(parameter.type, base, at, self.value(value)))
            if acts(value):
                given = {}  # it may have changed the inputs before it
        return {} if acts([place for _, place in call.in_outs]) else given

    def _take_output(self, parameter: Var, place: s.Node, base: str, offset: int) -> None:
        offset += parameter.address
        source = s.Name(place.start, place.end, parameter.name)
        source.type = parameter.type
        if t.is_aggregate(parameter.type):
            self.line(self.copy_bytes(place.type, self.address_of(place), address(base, offset)))
        else:
            self.line(self._store_output(parameter, place, load(parameter.type, base, offset)))

    def action_call(self, symbol: ActionOf) -> None:
        """An action runs on the instance of its POU."""
        if symbol.pou.kind == "PROGRAM":
            own = symbol.pou.address if self.static_base is None else self.static_base
            address = own if symbol.base is None else self.place(symbol.base)[1]
            self.line(f"(call {self.module.need_instance(symbol.pou, symbol.action, address)})")
            return
        name = self.module.need_action(symbol.pou, symbol.action)
        if symbol.base is None:
            self.line(f"(call {name} {self.this_address()})")
        else:
            self.line(f"(call {name} {self.address_of(symbol.base)})")
