"""The compiler of motion programs: the manual's C subset (iDEABOX 3, 10.4) to one command for each statement.

An expression has at most two operands of one type; conditions are variables; functions call GT_ commands only, with
every parameter. Printed listings have lost blanks (intsum, gotolbl_end, returnsum): such words are taken apart where
nothing of that name is declared.
"""

from __future__ import annotations

from mclib.motion_programs.code import (
    CONSTANT,
    GLOBAL,
    GOTO,
    IF_GOTO,
    IF_RETURN,
    LOCAL,
    LONGEST_NAME,
    MOST,
    MOST_COMMANDS,
    MOST_NAMES,
    RETURN,
    Function,
    MotionError,
    Operand,
    Unit,
    Variable,
)
from mclib.motion_programs.expressions import Expressions
from mclib.motion_programs.words import TYPES, Token


def compile_motion(text: str) -> Unit:
    """Compile the text of a *.c file. Raises MotionError."""
    return _Compiler(text).unit()


class _Compiler(Expressions):
    """Compiles a file: declarations, functions, statements."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.labels: dict[str, int] = {}
        self.jumps: list[tuple[Operand, str, int]] = []
        self.names = 0

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
        self._count(name, line)
        self.function = Function(name, kind, len(self.result.commands))
        self.result.functions[name] = self.function
        self.labels, self.jumps = {}, []
        return self.function

    def _function(self, kind: str, name: Token) -> None:
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

    def _declare(self, name: Token, kind: str, length: int, function: Function | None) -> None:
        owner = function or self.result
        if name.text in owner.variables or (function is None and name.text in self.result.functions):
            raise MotionError(name.line, f"{name.text} is declared twice")
        variable = Variable(name.text, kind, LOCAL if function else GLOBAL, owner.size, length)
        owner.variables[name.text] = variable
        owner.size += max(length, 1)
        if owner.size > MOST:
            raise MotionError(name.line, f"more than {MOST} {'local' if function else 'global'} variables")
        self._count(name.text, name.line)

    def _count(self, name: str, line: int) -> None:
        """One more name for the symbol file, where GT_GetFunId and GT_GetVarId look for it."""
        self.names += 1
        if len(name) > LONGEST_NAME:
            raise MotionError(line, f"{name}: a name has at most {LONGEST_NAME} characters")
        if self.names > MOST_NAMES:
            raise MotionError(line, f"more than {MOST_NAMES} functions and variables together")

    # ------------------------------------------------------------------------------------------ statements

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

    def _jump(self, token: Token) -> str:
        """The label of a goto, of one that has lost its blank too; '' when it is none."""
        if token.text == "goto":
            return self.name("a label").text
        if token.text.startswith("goto") and self.token.text == ";" and token.text not in self._known():
            return token.text[4:]
        return ""

    def _is_return(self, token: Token) -> bool:
        if token.text == "return":
            return True
        if not token.text.startswith("return") or self.token.text != ";" or token.text in self._known():
            return False
        self.at -= 1
        rest = token.text[6:]
        kind = "number" if rest.isdigit() else "word"
        self.tokens[self.at] = Token(kind, rest, token.line)
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

    def _assignment(self, name: Token) -> None:
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
