"""The arguments of a call, matched to parameters."""

from __future__ import annotations

from stcore import syntax as s
from stcore import types as t
from stcore.check.conversions import same
from stcore.check.expressions import Expressions
from stcore.near import near
from stcore.scope import Pou, Var, key


class Arguments(Expressions):
    """Checks what a call gives and takes."""

    def match(self, node: s.Call, pou: Pou) -> dict | None:
        """Parameter -> Arg ('EN' and 'ENO' by name). None when there are too many or unknown ones."""
        inputs, bound, failed = pou.arguments(), {}, False
        parameters = [p for p in pou.parameters if not p.room_of]
        named = {key(p.name): p for p in parameters}
        named |= {p.also: p for p in parameters if p.also}
        position = 0
        args = self._without_core_number(node, pou, len(inputs))
        for arg in args:
            if arg.name is None:
                if position >= len(inputs):
                    self.error("E0401", node, name=pou.name, wanted=len(inputs), given=len(node.args))
                    return None
                parameter = inputs[position]
                position += 1
            else:
                parameter = named.get(key(arg.name)) or (key(arg.name) if key(arg.name) in ("EN", "ENO") else None)
                if parameter is None and (meant := self.meant(arg, arg.name, [p.name for p in parameters])):
                    parameter = named[key(meant)]
            if parameter is None:
                known = [p.name for p in parameters]
                hint = near(arg.name, known) or (f"it has {', '.join(known)}" if known else "it has none")
                self.error("E0408", arg, hint=hint, name=pou.name, parameter=arg.name)
                failed = True
            elif parameter in bound:
                self.error("E0409", arg, name=pou.name, parameter=arg.name or parameter.name)
            else:
                bound[parameter] = arg
        return None if failed else bound

    def _without_core_number(self, node: s.Call, pou: Pou, wanted: int) -> list[s.Arg]:
        """GT_GetSts(1, 1, ADR(sts), 1, 0): a listing of the multi-core controllers."""
        args = node.args
        if len(args) != wanted + 1 or not self.project.takes_core_number(pou.name):
            return args
        if args[0].name is None and isinstance(args[0].value, s.Literal):
            self.report("W0133", args[0], name=pou.name, wanted=wanted, given=len(args))
            return args[1:]
        return args

    def _enable(self, bound: dict, pou: Pou) -> tuple[s.Node | None, s.Node | None]:
        """EN := condition and ENO => place, which every POU has without declaring them."""
        given = {name: bound[name].value for name in ("EN", "ENO") if name in bound and bound[name].value is not None}
        en = self.boolean(given["EN"], "EN") if "EN" in given else None
        eno = self.place(given["ENO"], write=True) if "ENO" in given else None
        return en, eno

    def _argument(self, node: s.Call, arg: s.Arg | None, parameter: Var, pou: Pou, checked: bool) -> s.Node | None:
        """The value of an input, or the place of an in-out."""
        if arg is None or arg.value is None:
            if parameter.section == "VAR_IN_OUT" and arg is None:
                self.error("E0410", node, name=pou.name, parameter=parameter.name)
            return None
        what = f"{parameter.name} of {pou.name}"
        if parameter.section == "VAR_IN_OUT":
            return self._in_out(arg, parameter, what)
        value = arg.value if checked else self.value(arg.value)
        if parameter.indirect and isinstance(value.type, t.String) and value.type.wide == parameter.type.wide:
            return value
        return self.convert(value, parameter.type, what)

    def _in_out(self, arg: s.Arg, parameter: Var, what: str) -> s.Node:
        constant = parameter.constant
        place = self.value(arg.value) if constant else self.place(arg.value, write=True, addressed=True)
        if constant and not isinstance(place, s.Literal):
            place = self.place(place, write=False, addressed=True) if not isinstance(place, s.Call) else place
        given, wanted = place.type, parameter.type
        if t.ERROR in (given, wanted):
            return place
        strings = isinstance(given, t.String) and isinstance(wanted, t.String) and given.wide == wanted.wide
        arrays = isinstance(given, t.Array) and isinstance(wanted, t.Array)
        dimensions = arrays and (len(given.bounds) or given.open)
        open_array = arrays and wanted.open == dimensions and same(given.element, wanted.element)
        if strings and given.length < wanted.length and not constant:
            self.warn("W0401", arg, given=given, wanted=wanted, what=what)
        elif not (same(given, wanted) or strings or open_array or _is_one(given, wanted)):
            equal = arrays and wanted.bounds and self._compatible_aggregates(place, given, wanted)
            if not equal:
                self.error("E0411", arg, what=what, given=given, wanted=wanted)
        if isinstance(place, s.Part) or isinstance(place.symbol, Var) and place.symbol.bit is not None:
            self.error("E0402", arg, name=self.text(arg.value))
        return place

    def _output(self, arg: s.Arg, parameter: Var) -> s.Node:
        place = self.place(arg.value, write=True)
        if place.type is not t.ERROR:
            probe = s.Name(arg.start, arg.end, parameter.name)
            probe.type = parameter.type
            self.convert(probe, place.type, f"output {parameter.name}")
        return place


def _is_one(given: t.Type, wanted: t.Type) -> bool:
    """An instance of a block is also one of the blocks that its block extends, a value of an ENUM one of its base."""
    return t.base_of(given) is t.base_of(wanted) or isinstance(given, t.Block) and given.extends(wanted)
