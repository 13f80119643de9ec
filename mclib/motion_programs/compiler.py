"""The compiler of motion programs: the manual's C subset (iDEABOX 3, 10.4) to one command for each statement.

An expression has at most two operands of one type; conditions are variables; functions call GT_ commands only, with
every parameter. Printed listings have lost blanks (intsum, gotolbl_end, returnsum): such words are taken apart where
nothing of that name is declared.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from mclib.motion_programs.commands import COMMANDS, NUMBER, POINTERS

MOST = 1024  # variables of a function, global variables
MOST_COMMANDS = 4096
MOST_FUNCTIONS = 32
ONE = 1 << 16  # 1.0 in fixed point
CONSTANT, GLOBAL, LOCAL = 0, 1, 2  # mode of an operand
MOVE, TO_DOUBLE, TO_INT, NEG, NOT, BIT_NOT = 1, 2, 3, 4, 5, 6
ARITHMETIC = {"+": 10, "-": 11, "*": 12, "/": 13, "%": 14}  # of int; 10 more for double
LOGIC = {"&&": 30, "||": 31}
COMPARE = {">": 32, "<": 33, "==": 34, ">=": 35, "<=": 36, "!=": 37}
BITS = {"&": 40, "|": 41, "^": 42, "<<": 43, ">>": 44}
GOTO, IF_GOTO, RETURN, IF_RETURN, CALL, ARG = 50, 51, 52, 53, 60, 61
TYPES = {"int": "int", "short": "int", "long": "int", "double": "double", "void": "void"}
_SPLIT = re.compile(r"(int|short|long|double|void)([A-Za-z_]\w*)$")
_TOKEN = re.compile(
    r"(?P<blank>[ \t\r\f]+|…+|\.{3,})|(?P<line>\n)|(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<define>\#[ \t]*define\b[^\n]*)"
    r"|(?P<number>0[xX][0-9a-fA-F]+|\d+\.\d*|\.\d+|\d+)|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<sign>&&|\|\||==|>=|<=|!=|<<|>>|[-+*/%<>=!~&|^(){}\[\];:,])",
    re.S | re.A,
)


class MotionError(Exception):
    """A mistake in a motion program. line: from 1."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(message)
        self.line, self.message = line, message


@dataclass(slots=True)
class Operand:
    """A constant (value), a variable (index), or an element that another variable (by, at) chooses of `length`."""

    mode: int = CONSTANT
    index: int = 0
    by: int = 0
    at: int = 0
    length: int = 0
    value: int = 0


@dataclass(slots=True)
class Command:
    op: int
    line: int
    dst: Operand = field(default_factory=Operand)
    a: Operand = field(default_factory=Operand)
    b: Operand = field(default_factory=Operand)


@dataclass(slots=True)
class Variable:
    name: str
    type: str
    mode: int
    index: int
    length: int = 0  # 0: no array


@dataclass(slots=True)
class Function:
    name: str
    type: str
    entry: int
    variables: dict[str, Variable] = field(default_factory=dict)
    size: int = 0


@dataclass(slots=True)
class Unit:
    """What a file has become. variables: the global ones."""

    commands: list[Command] = field(default_factory=list)
    functions: dict[str, Function] = field(default_factory=dict)
    variables: dict[str, Variable] = field(default_factory=dict)
    size: int = 0


@dataclass(slots=True)
class _Token:
    kind: str
    text: str
    line: int


def compile_motion(text: str) -> Unit:
    """Compile the text of a *.c file. Raises MotionError."""
    return _Compiler(text).unit()


class _Compiler:
    def __init__(self, text: str) -> None:
        self.macros: dict[str, list[_Token]] = {}
        self.tokens = self._tokens(text.replace("；", ";").replace("，", ","))
        self.at = 0
        self.result = Unit()
        self.function: Function | None = None
        self.labels: dict[str, int] = {}
        self.jumps: list[tuple[Operand, str, int]] = []

    # ------------------------------------------------------------------------------------------- words

    def _tokens(self, text: str) -> list[_Token]:
        tokens, line, at = [], 1, 0
        while at < len(text):
            found = _TOKEN.match(text, at)
            if found is None:
                end = text.find("\n", at)
                rest = text[at : end if end >= 0 else None]
                if not rest.isascii() and not re.search("[;{}]", rest):
                    at += len(rest)  # a comment that was printed on two lines
                    continue
                raise MotionError(line, f"'{text[at]}' has no meaning here")
            at = found.end()
            kind = found.lastgroup
            if kind == "define":
                self._define(found.group().split("//")[0], line)
            elif kind in ("number", "word", "sign"):
                tokens += self.macros.get(found.group()) or [_Token(kind, found.group(), line)]
                tokens[-1] = _Token(tokens[-1].kind, tokens[-1].text, line)
            line += found.group().count("\n")
        return [*tokens, _Token("end", "end of the file", line)]

    def _define(self, text: str, line: int) -> None:
        words = re.match(r"#\s*define\s+([A-Za-z_]\w*)\s+(-?\s*[\w.]+)\s*$", text)
        if words is None:
            raise MotionError(line, "a macro is written '#define NAME number'")
        name, value = words.groups()
        found = [_Token(m.lastgroup or "", m.group(), line) for m in _TOKEN.finditer(value) if m.lastgroup != "blank"]
        if found[0].text == "-" and len(found) == 2:
            found = [_Token("number", "-" + found[1].text, line)]
        self.macros[name] = found[:1]

    @property
    def token(self) -> _Token:
        return self.tokens[self.at]

    def take(self) -> _Token:
        token = self.token
        self.at += 1
        return token

    def accept(self, text: str) -> bool:
        if self.token.text == text and self.token.kind != "end":
            self.at += 1
            return True
        return False

    def expect(self, text: str, after: str) -> None:
        if not self.accept(text):
            line = self.tokens[max(self.at - 1, 0)].line
            raise MotionError(line, f"{text} is missing {after}")

    def name(self, what: str) -> _Token:
        token = self.take()
        if token.kind != "word":
            raise MotionError(token.line, f"{what} is missing before '{token.text}'")
        return token

    def split(self, *, but: set[str]) -> None:
        """Take a word apart that has lost the blank behind its type: intsum."""
        token = self.token
        found = _SPLIT.match(token.text) if token.kind == "word" and token.text not in but else None
        if found:
            self.tokens[self.at : self.at + 1] = [_Token("word", x, token.line) for x in found.groups()]

    # ------------------------------------------------------------------------------------------- the file

    def unit(self) -> Unit:
        while self.token.kind != "end":
            if self.accept(";"):
                continue
            self.split(but=set(self.result.variables))
            if self.token.text not in TYPES:
                self._implicit_main()
                break
            self._declaration()
        if not self.result.functions:
            raise MotionError(self.token.line, "there is no function")
        if len(self.result.commands) > MOST_COMMANDS:
            raise MotionError(self.token.line, f"more than {MOST_COMMANDS} commands")
        return self.result

    def _declaration(self) -> None:
        kind = self.take().text
        name = self.name("a name")
        if self.accept("("):
            self._function(TYPES[kind], name)
        else:
            self.at -= 1
            self._variables(TYPES[kind], None)

    def _begin(self, name: str, kind: str, line: int) -> Function:
        if name in self.result.functions or name in self.result.variables:
            raise MotionError(line, f"{name} is declared twice")
        if name.upper().startswith("GT_"):
            raise MotionError(line, f"{name}: names of commands can't be declared")
        self.function = Function(name, kind, len(self.result.commands))
        self.result.functions[name] = self.function
        self.labels, self.jumps = {}, []
        return self.function

    def _function(self, kind: str, name: _Token) -> None:
        function = self._begin(name.text, kind, name.line)
        while not self.accept(")"):
            self.split(but=set())
            if self.accept("void") and self.token.text == ")":
                continue
            kind_token = self.take()
            if kind_token.text not in TYPES or kind_token.text == "void":
                raise MotionError(kind_token.line, f"a parameter is written 'int name', not '{kind_token.text}'")
            parameter = self.name("the name of a parameter")
            self._declare(parameter, TYPES[kind_token.text], 0, function)
            if self.token.text != ")":
                self.expect(",", "between parameters")
        self.expect("{", f"after the head of {function.name}")
        while not self.accept("}"):
            if self.token.kind == "end":
                raise MotionError(self.token.line, f"}} is missing at the end of {function.name}")
            self._statement()
        self._end(self.tokens[self.at - 1].line)

    def _implicit_main(self) -> None:
        """Statements outside any function, as fragments are printed: the function main."""
        self._begin("main", "void", self.token.line)
        while self.token.kind != "end":
            self._statement()
        self._end(self.token.line)

    def _end(self, line: int) -> None:
        self._add(RETURN, line, dst=Operand(index=-1))
        for operand, label, at in self.jumps:
            if label not in self.labels:
                raise MotionError(at, f"there is no label {label}")
            operand.index = self.labels[label]
        self.function = None

    def _variables(self, kind: str, function: Function | None) -> None:
        if kind == "void":
            raise MotionError(self.token.line, "a variable can't be void")
        while True:
            name = self.name("the name of a variable")
            length = 0
            if self.accept("["):
                length = self._number("the length of an array", "int")
                if not 1 <= length <= MOST:
                    raise MotionError(name.line, f"the array {name.text} has 1 to {MOST} elements")
                self.expect("]", "after the length of an array")
                if self.token.text == "[":
                    raise MotionError(name.line, "arrays have one dimension")
            if self.token.text == "=":
                raise MotionError(name.line, f"{name.text} can't be set where it is declared: write {name.text} = ...;")
            self._declare(name, kind, length, function)
            if not self.accept(","):
                break
        self.expect(";", "after a declaration")

    def _declare(self, name: _Token, kind: str, length: int, function: Function | None) -> None:
        owner = function or self.result
        if name.text in owner.variables or (function is None and name.text in self.result.functions):
            raise MotionError(name.line, f"{name.text} is declared twice")
        variable = Variable(name.text, kind, LOCAL if function else GLOBAL, owner.size, length)
        owner.variables[name.text] = variable
        owner.size += max(length, 1)
        if owner.size > MOST:
            raise MotionError(name.line, f"more than {MOST} {'local' if function else 'global'} variables")

    # ------------------------------------------------------------------------------------------- statements

    def _add(self, op: int, line: int, dst: Operand | None = None, a: Operand | None = None, b: Operand | None = None):
        command = Command(op, line, dst or Operand(), a or Operand(), b or Operand())
        self.result.commands.append(command)
        return command

    def _known(self) -> set[str]:
        return set(self.result.variables) | set(self.function.variables)

    def _statement(self) -> None:
        if self.accept(";"):
            return
        self.split(but=self._known())
        token = self.take()
        line, following = token.line, self.token.text
        if token.kind != "word":
            raise MotionError(line, f"a statement can't begin with '{token.text}'")
        if token.text in TYPES:
            self._variables(TYPES[token.text], self.function)
        elif token.text == "if":
            self._if(line)
        elif token.text in ("while", "for", "do", "switch", "case", "else", "break", "continue", "struct"):
            raise MotionError(line, f"'{token.text}' is not known in motion programs: use if(var) goto label;")
        elif following == ":":
            self.at += 1
            if token.text in self.labels:
                raise MotionError(line, f"the label {token.text} stands twice")
            self.labels[token.text] = len(self.result.commands)
        elif label := self._jump(token):
            self._goto(GOTO, line, label, Operand())
        elif self._is_return(token):
            self._return(RETURN, line, Operand())
        elif token.text.upper().startswith("GT_") and following == "(":
            self._call(token, Operand())
            self.expect(";", f"after {token.text}(...)")
        elif following == "(":
            raise MotionError(line, f"{token.text} is no GT_ command, and functions can't call functions")
        else:
            self._assignment(token)

    def _jump(self, token: _Token) -> str:
        """The label of a goto, of one that has lost its blank too; '' when it is none."""
        if token.text == "goto":
            return self.name("a label").text
        if token.text.startswith("goto") and self.token.text == ";" and token.text not in self._known():
            return token.text[4:]
        return ""

    def _is_return(self, token: _Token) -> bool:
        if token.text == "return":
            return True
        if not token.text.startswith("return") or self.token.text != ";" or token.text in self._known():
            return False
        self.at -= 1
        rest = token.text[6:]
        kind = "number" if rest.isdigit() else "word"
        self.tokens[self.at] = _Token(kind, rest, token.line)
        return True

    def _goto(self, op: int, line: int, label: str, condition: Operand) -> None:
        command = self._add(op, line, a=condition)
        self.jumps.append((command.b, label, line))
        self.expect(";", f"after goto {label}")

    def _return(self, op: int, line: int, condition: Operand) -> None:
        if self.accept(";"):
            self._add(op, line, Operand(index=-1), b=condition)
            return
        value, kind = self._operand(self.function.type if self.function.type != "void" else "int")
        if self.token.text != ";":
            raise MotionError(line, "return gives one variable or number back, no expression")
        self.at += 1
        if self.function.type == "void":
            raise MotionError(line, f"{self.function.name} is void and can't return a value")
        if kind != self.function.type:
            raise MotionError(line, f"{self.function.name} returns {self.function.type}, not {kind}: write a cast")
        self._add(op, line, Operand(index=int(kind == "double")), value, condition)

    def _if(self, line: int) -> None:
        self.expect("(", "after if")
        condition, kind = self._operand("int")
        if not self.accept(")"):
            raise MotionError(line, "the condition is a variable, no expression: write cc = ...; if(cc) goto label;")
        if kind != "int" or condition.mode == CONSTANT:
            raise MotionError(line, "the condition is a variable of type int")
        token = self.take()
        if label := self._jump(token):
            self._goto(IF_GOTO, line, label, condition)
        elif self._is_return(token):
            self._return(IF_RETURN, line, condition)
        else:
            raise MotionError(line, "after if(var) stands goto or return")

    def _assignment(self, name: _Token) -> None:
        target, kind = self._variable(name)
        if not self.accept("="):
            raise MotionError(name.line, f"= is missing after {name.text}")
        token = self.token
        if token.kind == "word" and token.text.upper().startswith("GT_"):
            self._call(self.take(), target)
            if kind != "int":
                raise MotionError(name.line, f"{token.text} returns int, {name.text} is double")
        else:
            self._expression(name, target, kind)
        if self.token.kind == "sign" and self.token.text not in (";", "}"):
            raise MotionError(name.line, "an expression has at most two operands")
        self.expect(";", "at the end of the statement")

    def _expression(self, name: _Token, target: Operand, kind: str) -> None:
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

    # ------------------------------------------------------------------------------------------- operands

    def _operand(self, wanted: str) -> tuple[Operand, str]:
        """A variable or a number. wanted: the type that a whole number takes."""
        token = self.take()
        if token.text == "-" and self.token.kind == "number":
            token = _Token("number", "-" + self.take().text, token.line)
        if token.kind == "number":
            kind = "double" if "." in token.text or wanted == "double" else "int"
            return Operand(value=self._value(token, kind)), kind
        if token.kind != "word":
            raise MotionError(token.line, f"a variable or a number is missing before '{token.text}'")
        return self._variable(token)

    def _value(self, token: _Token, kind: str) -> int:
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

    def _find(self, name: _Token) -> Variable:
        found = self.function.variables.get(name.text) or self.result.variables.get(name.text)
        if found is None:
            raise MotionError(name.line, f"{name.text} is not declared")
        return found

    def _variable(self, name: _Token) -> tuple[Operand, str]:
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

    # ------------------------------------------------------------------------------------------- commands

    def _call(self, name: _Token, target: Operand) -> None:
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

    def _argument(self, name: _Token, call: Command, word: str, number: int) -> None:
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
