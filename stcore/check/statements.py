"""Statements, and whole POUs."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.conversions import INTEGER, kind_of
from stcore.check.methods import Methods
from stcore.scope import ActionOf, Convert, MethodOf, Pou, PropertyOf, key, place_node


class Statements(Methods):
    """Checks the statements of a body."""

    def body(self, statements: list[s.Node]) -> None:
        """JMP reaches the labels of its own list of statements and of those around it."""
        outer = self.labels
        self.labels = outer | {key(n.name) for n in statements if isinstance(n, s.Label)}
        for i, node in enumerate(statements):
            statements[i] = self.statement(node) or node
        self.labels = outer

    def statement(self, node: s.Node) -> s.Node | None:
        """Check a statement; what is to stand in its place, if it is something else."""
        return self.STATEMENTS[type(node)](self, node)

    def assign(self, node: s.Assign) -> s.Node | None:
        if node.op == "REF=":
            return self._bind_reference(node)
        self.target = node.target
        target = self.expr(node.target)
        self.target = None
        if isinstance(target.symbol, PropertyOf) and target is node.target and node.op == ":=":
            return self.write_property(node, target.symbol)
        node.target = target = self.placed(target, write=True)
        if node.op in ("S=", "R="):
            node.value = self.boolean(node.value, f"the value of {node.op}")
            if target.type not in (t.BOOL, t.ERROR):
                self.error("E0304", target, what=f"the target of {node.op}", type=target.type)
            return None
        value = self.value(node.value)
        if target.type is t.ERROR:
            node.value = value
            return None
        node.value = self.convert(value, target.type, f"assigned to {self.text(target)}")
        return None

    def _bind_reference(self, node: s.Assign) -> None:
        """r REF= x: the target is the reference itself, not what it refers to."""
        target = self.value(node.target)
        if not isinstance(target, s.Deref) or not getattr(target.base.type, "reference", False):
            if target.type is not t.ERROR:
                self.error("E0501", node.target, name=self.text(node.target))
            return
        node.target = target.base
        self._mark(target.base, target.base, True, False)
        value = self.value(node.value)
        if value.type is t.NULL or value.const == 0 and value.type is t.INT_LITERAL:
            node.value = self.convert(value, t.DWORD)
            return
        node.value = value
        self._mark(value, value, True, True)
        wanted = target.base.type.target
        derived = isinstance(value.type, t.Block) and value.type.extends(wanted)
        if value.type is not t.ERROR and value.type is not wanted and value.type.size != wanted.size and not derived:
            self.error("E0302", node.value, source=value.type, target=wanted, what="")

    def call_statement(self, node: s.ExprStmt) -> None:
        """A call; a bare name that calls an action, a program or a function without arguments (CoDeSys V2.3)."""
        expr = node.expr
        if not isinstance(expr, s.Call) and isinstance(expr, s.Name | s.Member):
            expr = s.Call(expr.start, expr.end, expr, [])
            symbol = self.lookup(expr.callee.name) if isinstance(expr.callee, s.Name) else None
            is_call = isinstance(symbol, ActionOf | MethodOf)
            is_call |= isinstance(symbol, Pou) and symbol.kind != "FUNCTION_BLOCK"
            if isinstance(expr.callee, s.Member):
                expr.callee = self.expr(expr.callee)
                is_call = isinstance(expr.callee.symbol, ActionOf | MethodOf) or isinstance(expr.callee.type, t.Block)
                if is_call:
                    node.expr = self._call_symbol(expr, expr.callee.symbol, False)
                    return
            elif symbol is None:
                self.unknown_name(expr.callee, expr.callee.name)
                return
            if not is_call:
                if expr.callee.type is not t.ERROR:
                    self.error("E0502", node, text=self.text(node.expr))
                return
        elif not isinstance(expr, s.Call):
            if self.value(expr).type is not t.ERROR:
                hint = ""
                if isinstance(expr, s.Binary) and expr.op == "=":
                    hint = f"write := to assign: {self.text(expr.left)} := {self.text(expr.right)};"
                self.error("E0502", node, hint=hint, text=self.text(expr))
            return
        node.expr = self.call(expr)

    def if_(self, node: s.If) -> None:
        checked = []
        for condition, body in node.branches:
            checked.append((self.boolean(condition, "the condition of IF"), body))
            self.body(body)
        node.branches = checked
        if node.orelse is not None:
            self.body(node.orelse)

    def case(self, node: s.Case) -> None:
        node.selector = selector = self.settle(self.value(node.selector))
        kind = selector.type
        if kind_of(kind) not in (*INTEGER, "enum", "subrangetype") and kind is not t.ERROR:
            if not isinstance(t.base_of(kind), t.Elementary) or t.base_of(kind).kind not in ("bool", "char", "time"):
                self.error("E0503", selector, type=kind)
        if isinstance(kind, t.Enum):
            made = Convert(selector.start, selector.end, selector)
            made.type = t.base_of(kind)
            node.selector = made
        seen: dict[int, s.Node] = {}
        for i, (labels, body) in enumerate(node.branches):
            node.branches[i] = ([self._label(x, kind, seen) for x in labels], body)
            self.body(body)
        if node.orelse is not None:
            self.body(node.orelse)

    def _label(self, label: s.Node, kind: t.Type, seen: dict[int, s.Node]) -> s.Node:
        if isinstance(label, s.Range):
            label.low, label.high = (self._label(x, kind, {}) for x in (label.low, label.high))
            if isinstance(label.low.const, int) and isinstance(label.high.const, int):
                if label.high.const < label.low.const:
                    self.error("E0205", label, low=label.low.const, high=label.high.const)
            return label
        label = self.value(label)
        if label.type is t.ERROR:
            label.const = None
            return label
        if kind_of(kind) == "char":
            label = self.convert(label, kind)
        if label.const is None or isinstance(label.const, float | str):
            self.error("E0504", label, text=self.text(label))
            return label
        if label.const in seen:
            self.warn("W0501", label, value=self.text(label), line=self.source.position(seen[label.const].start)[0])
        seen.setdefault(label.const, label)
        return label

    def for_(self, node: s.For) -> None:
        node.var = var = self.place(node.var, write=True)
        if kind_of(var.type) not in INTEGER and not isinstance(var.type, t.SubrangeType | t.Enum):
            if var.type is not t.ERROR:
                self.error("E0505", var, type=var.type)
            var.type = t.ERROR
        kind = t.base_of(var.type)
        for part in ("first", "last", "step"):
            value = getattr(node, part)
            if value is None:
                continue
            value = self.value(value)
            if part == "step" and value.const is not None:
                if value.const == 0:
                    self.error("E0506", value)
                # a step down is legal for an unsigned variable too
            elif part == "step" and kind_of(value.type) in INTEGER:
                pass  # as it is: a signed step may lead an unsigned variable down
            elif t.ERROR not in (kind, value.type):
                value = self.convert(value, kind, f"{part} value of FOR")
            setattr(node, part, value)
        self.loops += 1
        self.body(node.body)
        self.loops -= 1

    def while_(self, node: s.While) -> None:
        node.condition = self.boolean(node.condition, "the condition of WHILE")
        self.loops += 1
        self.body(node.body)
        self.loops -= 1

    def repeat(self, node: s.Repeat) -> None:
        self.loops += 1
        self.body(node.body)
        self.loops -= 1
        node.condition = self.boolean(node.condition, "the condition of UNTIL")

    def leave(self, node: s.Node) -> None:
        if self.loops == 0:
            self.error("E0507", node, word=type(node).__name__.upper())

    def nothing(self, node: s.Node) -> None:
        pass

    def jump(self, node: s.Jump) -> None:
        if key(node.name) not in self.labels:
            self.error("E0508", node, name=node.name)

    STATEMENTS = {
        s.Assign: assign, s.ExprStmt: call_statement, s.If: if_, s.Case: case, s.For: for_, s.While: while_,
        s.Repeat: repeat, s.Exit: leave, s.Continue: leave, s.Return: nothing, s.Label: nothing, s.Jump: jump,
    }  # fmt: skip

    # ---------------------------------------------------------------------------------------------- POUs

    def check_pou(self) -> None:
        """The body and the actions of the POU; of a block also that it has the methods that it has to have."""
        pou = self.pou
        if pou.base is not None or pou.interfaces or pou.methods:
            self.check_members()
        bodies = [pou.tree.body, *(a.body for a in pou.actions.values())]
        for body in bodies:
            self.body(body)
        pou.tree.body[:0] = [node for name in pou.edges for node in self._edge(pou, name)]

    @staticmethod
    def _edge(pou: Pou, name: str) -> list[s.Node]:
        """What an input with R_EDGE or F_EDGE does before the body: seen := input AND NOT last; last := input."""
        var, seen = pou.variables[name], pou.edges[name]
        at, falls = var.decl, var.decl.attributes["edge"] == "F_EDGE"
        last = pou.variables[key(f"{var.name}__last")]
        now, before, edge = (place_node(at, x) for x in (var, last, seen))
        negated = s.Unary(at.start, at.end, "NOT", now if falls else before)
        rises = s.Binary(at.start, at.end, "AND", before if falls else now, negated)
        negated.type = rises.type = t.BOOL
        return [s.Assign(at.start, at.end, edge, ":=", rises), s.Assign(at.start, at.end, before, ":=", now)]
