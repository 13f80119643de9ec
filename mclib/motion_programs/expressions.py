"""Expressions, their operands, and calls of GT_ commands in motion programs."""

from __future__ import annotations

from mclib.motion_programs.code import (
    ARG,
    ARITHMETIC,
    BIT_NOT,
    BITS,
    CALL,
    COMPARE,
    CONSTANT,
    LOGIC,
    MOVE,
    NEG,
    NOT,
    ONE,
    TO_DOUBLE,
    TO_INT,
    Command,
    Function,
    MotionError,
    Operand,
    Unit,
    Variable,
)
from mclib.motion_programs.commands import COMMANDS, NUMBER, POINTERS
from mclib.motion_programs.words import FOREIGN_TYPES, TYPES, Token, Words


class Expressions(Words):
    """Compiles what stands in one statement. function: the one that is being read; result: what has been compiled."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.result = Unit()
        self.function: Function | None = None

    def _add(self, op: int, line: int, dst: Operand | None = None, a: Operand | None = None, b: Operand | None = None):
        command = Command(op, line, dst or Operand(), a or Operand(), b or Operand())
        self.result.commands.append(command)
        return command

    def _expression(self, name: Token, target: Operand, kind: str) -> None:
        line = name.line
        if self.token.text == "(" and self.tokens[self.at + 1].text in TYPES:
            self.at += 1
            cast = TYPES[self.take().text]
            self.expect(")", "after the type of a cast")
            value, given = self._operand(cast)
            op = MOVE if given == cast else TO_DOUBLE if cast == "double" else TO_INT
            self._same(line, name.text, kind, cast)
            self._add(op, line, target, value)
        elif self.token.text in ("!", "~", "-") and self.tokens[self.at + 1].kind != "number":
            sign = self.take().text
            value, given = self._operand(kind)
            self._same(line, name.text, kind, given)
            if sign != "-" and given != "int":
                raise MotionError(line, f"{sign} needs an int")
            self._add({"!": NOT, "~": BIT_NOT, "-": NEG}[sign], line, target, value)
        else:
            value, given = self._operand(kind)
            sign = self.token.text
            if sign not in ARITHMETIC and sign not in LOGIC and sign not in COMPARE and sign not in BITS:
                self._same(line, name.text, kind, given)
                self._add(MOVE, line, target, value)
                return
            self.at += 1
            literal = self.tokens[self.at - 2].kind == "number"
            other, second = self._operand(given)
            if literal and given != second:
                value, given = self._literal(value, second), second
            if given != second:
                raise MotionError(line, f"the operands of {sign} are {given} and {second}: write a cast first")
            self._binary(line, sign, given, name.text, kind, target, value, other)

    def _binary(self, line, sign, given, name, kind, target, a, b) -> None:
        if sign in ARITHMETIC:
            op, result = ARITHMETIC[sign] + (10 if given == "double" else 0), given
        elif sign in COMPARE:
            op, result = COMPARE[sign], "int"
        else:
            op, result = (LOGIC.get(sign) or BITS[sign]), "int"
            if given != "int":
                raise MotionError(line, f"{sign} needs int operands")
        self._same(line, name, kind, result)
        self._add(op, line, target, a, b)

    def _same(self, line: int, name: str, wanted: str, given: str) -> None:
        if wanted != given:
            raise MotionError(line, f"{name} is {wanted}, the value is {given}: write a cast, ({wanted})")

    # ------------------------------------------------------------------------------------------ operands

    def _operand(self, wanted: str) -> tuple[Operand, str]:
        """A variable or a number. wanted: the type that a whole number takes."""
        token = self.take()
        if token.text == "-" and self.token.kind == "number":
            token = Token("number", "-" + self.take().text, token.line)
        if token.kind == "number":
            kind = "double" if "." in token.text or wanted == "double" else "int"
            return Operand(value=self._value(token, kind)), kind
        if token.kind != "word":
            raise MotionError(token.line, f"a variable or a number is missing before '{token.text}'")
        return self._variable(token)

    def _value(self, token: Token, kind: str) -> int:
        if "." in token.text:
            number = float(token.text)
        else:
            number = int(token.text, 16 if "x" in token.text.lower() else 10)
        if not -(1 << 31) <= number < (1 << 32 if "x" in token.text.lower() else 1 << 31):
            raise MotionError(token.line, f"{token.text} is beyond -2147483648..2147483647")
        if kind == "double":
            return round(number * ONE)
        return number - (1 << 32) if number >= 1 << 31 else number

    def _literal(self, value: Operand, kind: str) -> Operand:
        """A whole number beside a double."""
        return Operand(value=value.value * ONE) if kind == "double" and value.mode == CONSTANT else value

    def _number(self, what: str, kind: str) -> int:
        token = self.take()
        if token.kind != "number" or "." in token.text:
            raise MotionError(token.line, f"{what} is a whole number")
        return self._value(token, kind)

    def _find(self, name: Token) -> Variable:
        found = self.function.variables.get(name.text) or self.result.variables.get(name.text)
        if found is None:
            raise MotionError(name.line, self._unknown(name.text))
        return found

    def _unknown(self, name: str) -> str:
        if name in self.result.functions:
            return f"{name} is a function: functions can't call functions, only GT_ commands"
        if name in FOREIGN_TYPES:
            return f"{name} is no type of motion programs: int or double"
        if name.isupper():  # as GT_ macros are written (10.4.3 (4))
            return f"{name} is not declared; macros of the PLC are not known here: write #define {name} and its number"
        return f"{name} is not declared"

    def _variable(self, name: Token) -> tuple[Operand, str]:
        variable = self._find(name)
        if not self.accept("["):
            if variable.length:
                raise MotionError(name.line, f"{name.text} is an array: write {name.text}[index]")
            return Operand(variable.mode, variable.index), variable.type
        if not variable.length:
            raise MotionError(name.line, f"{name.text} is no array")
        if self.token.kind == "number":
            index = self._number("an index", "int")
            if not 0 <= index < variable.length:
                raise MotionError(name.line, f"{name.text} has the indices 0 to {variable.length - 1}")
            operand = Operand(variable.mode, variable.index + index)
        else:
            chooser = self._find(self.name("an index"))
            if chooser.length or self.token.text == "[":
                raise MotionError(name.line, "an array element can't be an index")
            if chooser.type != "int":
                raise MotionError(name.line, "an index is an int")
            operand = Operand(variable.mode, variable.index, chooser.mode, chooser.index, variable.length)
        self.expect("]", "after an index")
        return operand, variable.type

    # ------------------------------------------------------------------------------------------ commands

    def _call(self, name: Token, target: Operand) -> None:
        if name.text not in COMMANDS:
            raise MotionError(name.line, f"{name.text} is not known in motion programs (Table 10-2)")
        words = COMMANDS[name.text].split()
        call = self._add(CALL, name.line, target, Operand(index=NUMBER[name.text]), Operand(index=len(words)))
        self.expect("(", f"after {name.text}")
        given = 0
        while not self.accept(")"):
            if given >= len(words):
                raise MotionError(name.line, f"{name.text} has {len(words)} parameters")
            self._argument(name, call, words[given], given + 1)
            given += 1
            if self.token.text != ")":
                self.expect(",", f"between the arguments of {name.text}")
        if given < len(words):
            raise MotionError(name.line, f"{name.text} needs all its {len(words)} parameters, {given} are given")

    def _argument(self, name: Token, call: Command, word: str, number: int) -> None:
        line = self.token.line
        what = f"argument {number} of {name.text}"
        if word in ("int", "double"):
            if self.token.text.upper() in ("&", "NULL"):
                raise MotionError(line, f"{what} is a value")
            value, kind = self._operand(word)
            if kind != word:
                raise MotionError(line, f"{what} is {word}, not {kind}: write a cast first")
            self._add(ARG, line, Operand(index=int(word == "double")), value)
            return
        if self.accept("NULL") or (self.token.text == "0" and self.accept("0")):
            raise MotionError(line, f"{what} must be written: the address of a variable")
        address = self.accept("&")
        variable = self._find(self.name(f"a variable as {what}"))
        operand, length = Operand(variable.mode, variable.index), max(variable.length, 1)
        if self.token.text == "[":
            self.at -= 1
            operand, _ = self._variable(self.take())
            length = variable.index + length - operand.index if not operand.by else 1
        elif not address and not variable.length:
            raise MotionError(line, f"{what} is the address of a variable: write &{variable.name}")
        kind = Operand(index=2, at=POINTERS[word], length=int(variable.type == "double"), value=min(length, 16))
        self._add(ARG, line, kind, operand)
