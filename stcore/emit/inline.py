"""Code that is taken in: a small function or block, or one with a single call, becomes part of its caller.

A call costs some nanoseconds, as much as a short block itself. The code stands between the caller's own lines, with
locals of its own; its sites name the call that they lie within, so a fault shows the same path as with a call. A
probed build calls everything: a debugger stops where the source says. What needs a stack frame is called, too.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from stcore.emit.statements import Statements
from stcore.scope import Pou, Var

SMALL = 120  # characters of the body's text: taken in wherever it is called
ONCE = 4000  # the same, where there is one call
ROOM = 15_000  # so many characters at most into one function: its compilation must stay quick


class NeedsFrame(Exception):
    """This code can't be taken in: it needs a stack frame."""


@dataclass(slots=True)
class Inlinable:
    """Which POUs of a module can be taken in. called: those that can't. taken: those that were, in order."""

    called: set[Pou] = field(default_factory=set)
    taken: dict[Pou, None] = field(default_factory=dict)

    @staticmethod
    def size(pou: Pou) -> int:
        body = pou.tree.body
        return body[-1].end - body[0].start if body else 0

    def suits(self, pou: Pou) -> bool:
        if pou in self.called or self.size(pou) > (ONCE if pou.calls == 1 else SMALL):
            return False
        open_array = any(getattr(p.type, "open", 0) for p in pou.parameters)
        if pou.kind == "PROGRAM" or pou.external or open_array or not pou.checked:
            self.called.add(pou)
            return False
        return True


class Inlining(Statements):
    """Emits calls by what they call."""

    def inlining_suits(self, pou: Pou) -> bool:
        """True if this block may be taken in here."""
        known = self.module.inlining
        return known is not None and known.suits(pou)

    def inline_block(self, pou: Pou, base: str, offset: int, places: dict[Var, str], given: dict[Var, str]) -> bool:
        """A block's code for the instance at this place. places: locals with the addresses of its in-outs; given:
        locals with its inputs. False: it has to be called."""
        inner = self._inner(pou)
        if inner is None:
            return False
        inner.this = (base, offset)
        inner.in_out_locals = places
        inner.recent, inner.homes = given, dict(given)
        if self._emit(inner) is None:
            return False
        self.lines += self._code(inner)
        return True

    def inline_function(self, pou: Pou, args: list[str], this: tuple[str, int] | None = None) -> str | None:
        """The code of a function, or of a method for the instance at `this`, with these arguments, as an expression;
        None: it has to be called."""
        inner = self._inner(pou)
        first = []
        if inner is not None and this is not None:
            base, offset = this
            if base not in ("", "(local.get $this)", "(local.get $fp)"):
                name = self.keep("i32")
                first, base = [f"(local.set {name} {base})"], f"(local.get {name})"
            inner.this = (base, offset)
        signature = inner and self._emit(inner)
        if signature is None:
            return None
        params, results = signature
        self.declared += [p.replace("(param", "(local", 1) for p in params]
        given = [f"(local.set {p.split()[1]} {a})" for p, a in zip(params, args, strict=True)]
        result = "".join(f" (result {r})" for r in results)
        return "\n".join([f"(block{result}", *first, *given, *self._code(inner), *inner._results(), ")"])

    def _emit(self, inner) -> tuple[list[str], list[str]] | None:
        """Let it emit its body. The parameters and results of a function; None: the body has to be called."""
        pou = inner.pou
        try:
            signature = inner._parameters() if pou.is_called else ([], [])
            inner._own_variables()
            inner._in_outs()
            inner.body(pou.tree.body)
        except NeedsFrame:
            inner.release()
            self.module.inlining.called.add(pou)
            return None
        if "hidden" not in pou.attributes:
            self.module.inlining.taken[pou] = None
            # what a typed statement can name stays callable; of the library's functions it can have a copy of its own
            if not pou.library or pou.kind != "FUNCTION":
                self.module.need(pou)
        return signature

    def _code(self, inner) -> list[str]:
        """The body as a block that RETURN leaves; what follows it is again part of the calling statement."""
        inner.release()
        return [f"(block {inner.exit_label}", *inner.lines, ")", f"(drop (i32.const {self.here}))"]

    def _inner(self, pou: Pou):
        """An emitter for code between the lines of this one; None where the code has to be called."""
        known = self.module.inlining
        if known is None or not known.suits(pou):
            return None
        size = known.size(pou)
        callers = self._chain()
        if any(x.pou is pou or x.room < size for x in callers):
            return None
        for x in callers:
            x.room -= size
        if size > SMALL:
            known.called.add(pou)  # from here on: its one call may be met again where its caller is taken in elsewhere
        inner = type(self)(self.module, pou, pou.source, caller=self)
        inner.take_free(self)
        inner.exit_label = self.label("return")
        inner.room = SMALL if size <= SMALL else ROOM
        return inner

    def _chain(self) -> list[Inlining]:
        """This emitter and those that take it in."""
        chain = [self]
        while chain[-1].caller:
            chain.append(chain[-1].caller)
        return chain
