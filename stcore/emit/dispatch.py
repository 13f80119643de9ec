"""Calls of which only the instance knows the code: of a method through an interface, a pointer, a reference or THIS.

Each such method has one function that looks at the number at the head of the instance (stcore/objects.py) and calls the
method that the block of that number has. Where nothing overrides a method there is no such function and the method
itself is called.
"""

from __future__ import annotations

from collections.abc import Callable

from stcore.emit.values import wasm_type
from stcore.objects import method_key
from stcore.scope import Pou
from stcore.types import Interface, is_aggregate


def signature(pou: Pou) -> tuple[list[str], list[str]]:
    """Types of the parameters and results of the code of a function or method, without the instance."""
    params, results = [], []
    for p in pou.inputs():
        params.append("i32" if p.indirect else wasm_type(p.type))
        params += ["i32"] * (2 * getattr(p.type, "open", 0))
    outputs = [p for p in pou.parameters if p.section == "VAR_OUTPUT"]
    params += ["i32" for p in outputs if is_aggregate(p.type)]
    if pou.result is not None and is_aggregate(pou.result.type):
        params.append("i32")
    elif pou.result is not None:
        results.append(wasm_type(pou.result.type))
    results += [wasm_type(p.type) for p in outputs if not is_aggregate(p.type)]
    return params, results


class Dispatch:
    """Which code a call runs, by the block of the instance. reached: the POUs of the program. need: called for all code
    that is called; mark: gives the marker of a POU, by which a fault finds its place."""

    def __init__(self, reached: list[Pou], need: Callable[[Pou], None], mark: Callable[[Pou], str]) -> None:
        self.blocks = [p for p in reached if p.kind == "FUNCTION_BLOCK" and p.type.number]
        self.need, self.mark = need, mark
        self.functions: dict[str, str] = {}  # name -> text
        self.chosen: dict[Pou, dict[int, Pou]] = {}  # a method or block -> the number of a block -> its code

    def of_method(self, method: Pou) -> dict[int, Pou]:
        """The method that an instance of each block has in the place of this one, by number."""
        if method not in self.chosen:
            name = method_key(method.tree)
            holder = method.holder
            if isinstance(holder.type, Interface):
                blocks = [b for b in self.blocks if b.type.implements(holder.type)]
            else:
                blocks = [b for b in self.blocks if b.type.extends(holder.type)]
                blocks = [] if "PRIVATE" in method.tree.modifiers else blocks
            self.chosen[method] = {b.type.number: b.method(name) for b in blocks if b.method(name) is not None}
        return self.chosen[method]

    def of_body(self, block: Pou) -> dict[int, Pou]:
        """The block whose body an instance runs that is known as one of this block."""
        return {b.type.number: b for b in self.blocks if b.type.extends(block.type)}

    def is_only(self, code: Pou) -> bool:
        """True if nothing stands for this method, or the body of this block, in any instance."""
        if code.holder is None:
            return len(self.of_body(code)) < 2
        return not isinstance(code.holder.type, Interface) and all(m is code for m in self.of_method(code).values())

    def method(self, method: Pou) -> str:
        """The function that a call of this method has to call."""
        if self.is_only(method):
            self.need(method)
            return method.symbol
        return self._function(f"{method.symbol}.of", method.holder, self.of_method(method), *signature(method))

    def body(self, block: Pou) -> str:
        """The function that a call of an instance has to call that is known by its address only."""
        if self.is_only(block):
            self.need(block)
            return block.symbol
        return self._function(f"{block.symbol}.of", block, self.of_body(block), [], [])

    def query(self, interface: Pou) -> str:
        """The function that gives an instance back if its block implements the interface, else 0."""
        name = f"{interface.symbol}.query"
        numbers = {b.type.number for b in self.blocks if b.type.implements(interface.type)}
        wanted = ["$yes" if n in numbers else "$no" for n in range(max(numbers, default=0) + 1)]
        this = "(local.get $this)"
        self.functions[name] = (
            f"(func {name} (param $this i32) (result i32) (block $no (block $yes (br_if $no (i32.eqz {this}))\n"
            f"(br_table {' '.join(wanted)} $no (i32.load {this}))) (return {this})) (i32.const 0))"
        )
        return name

    def _function(
        self, name: str, known: Pou, chosen: dict[int, Pou], params: list[str], results: list[str]
    ) -> str:
        """The function that chooses, made once."""
        if name in self.functions:
            return name
        self.functions[name] = ""
        codes = list(dict.fromkeys(chosen.values()))
        for code in codes:
            self.need(code)
        arguments = " ".join(["(local.get $this)", *(f"(local.get $a{i})" for i in range(len(params)))])
        wanted = [f"$c{codes.index(chosen[n])}" if n in chosen else "$none" for n in range(max(chosen, default=0) + 1)]
        head = ["(param $this i32)", *(f"(param $a{i} {p})" for i, p in enumerate(params))]
        lines = [f"(func {name} {' '.join(head)} {' '.join(f'(result {r})' for r in results)}", "(block $none"]
        lines += [f"(block $c{i}" for i in reversed(range(len(codes)))]
        lines.append(f"(br_table {' '.join(wanted)} $none (i32.load (local.get $this)))")
        for code in codes:
            lines.append(f") (return (call {code.symbol} {arguments}))")
        lines.append(f") {self.mark(known)} (call $fault_pointer (local.get $this)) unreachable)")
        self.functions[name] = "\n".join(lines)
        return name
