"""The commands of the prompt: names, usage, help, and how a line is told apart from ST."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from plcruntime import layout
from plcruntime.errors import UsageError
from plcruntime.repl.looking import Looking
from plcruntime.repl.moving import Moving


@dataclass(frozen=True, slots=True)
class Command:
    """method: of Commands, takes the rest of the line. group: heading of the list that `help` prints."""

    usage: str
    text: str
    group: str
    method: str


_TABLE = [
    ("step [n]", "run n scans, 1 without n; ends a scan that waits", "Running"),
    ("run TIME", "run for a virtual time: run 2s, run 500ms, run #100 (scans)", "Running"),
    ("until EXPR [for TIME]", "run until an ST condition holds at the end of a scan; 60 s without a time", "Running"),
    ("continue", "run to the next breakpoint", "Running"),
    ("back [n]", "go back n scans; one that waits in the middle counts", "Running"),
    ("reset [warm|cold|origin]", "start anew: warm keeps RETAIN and PERSISTENT, cold PERSISTENT", "Running"),
    ("next", "to the next statement, over calls", "Statements"),
    ("into", "to the next statement, into calls, those of library blocks too", "Statements"),
    ("out", "to the end of this block or function", "Statements"),
    ("break [POU:LINE [if EXPR]]", "stop before that line (when EXPR holds there); alone: list them", "Statements"),
    ("delete [n]", "remove breakpoint n, or all", "Statements"),
    ("list [POU[:LINE]|LINE]", "the source around the current statement, a line or a POU", "Statements"),
    ("where", "scan, time, statement, instance", "Statements"),
    ("print EXPR", "the value of any ST expression; an expression alone does the same", "Variables"),
    ("vars [PATTERN]", "variables and their values: vars PLC_PRG.*", "Variables"),
    ("watch [EXPR]", "show it after every movement; without EXPR the list", "Variables"),
    ("unwatch [EXPR]", "no longer show it, or nothing any more", "Variables"),
    ("set VAR := VALUE", "write a variable, as VAR := VALUE does: set arr := [1,2,3]", "Variables"),
    ("force [VAR := VALUE]", "hold a variable at a value; without arguments the list", "Variables"),
    ("unforce [VAR]", "release it, or all", "Variables"),
    ("diff [all]", "what the last movement changed; all: inside of library blocks too", "Variables"),
    ("axes [live|TIME]", "the axes in use; live until a key is pressed, or for a time, as the PLC runs", "Variables"),
    ("plot VAR... [to FILE]", "draw the scans so far in the terminal, or into .png, .svg, .html", "Recording"),
    (
        "trace [VAR...|off|to FILE]",
        "record variables from now on, or around a trigger: trace x if x > 3 pre 50ms post 200ms; write .csv or .npz",
        "Recording",
    ),
    ("save [NAME]", "keep a snapshot by name; without NAME list them", "Recording"),
    ("load NAME", "return to a snapshot", "Recording"),
    ("help [COMMAND]", "this list, or one command", "Session"),
    ("quit", "end", "Session"),
]
COMMANDS = {u.split()[0]: Command(u, t, g, "do_" + u.split()[0]) for u, t, g in _TABLE}
ALIASES = {
    "s": "step", "n": "next", "i": "into", "o": "out", "b": "break", "c": "continue", "p": "print", "l": "list",
    "w": "watch", "d": "delete", "h": "help", "?": "help", "q": "quit", "exit": "quit", "r": "run", "u": "until",
    "finish": "out", "info": "where", "cont": "continue",
}  # fmt: skip
_NO_PREFIX = {"for"}  # begins ST, though a command begins with it
_OPERATOR = re.compile(r"\s+([-+*/=<>]|AND\b|OR\b|XOR\b|MOD\b)", re.I)


def split(line: str, is_variable: Callable[[str], bool] = lambda _: False) -> tuple[str, str]:
    """(command, rest of the line); '' for ST. What a variable is called stays the variable."""
    match = re.match(r"(\?|[A-Za-z]+)(.*)", line.strip(), re.S)
    if not match:
        return "", line
    word, rest = match[1].lower(), match[2]
    if rest[:1] not in ("", " ", "\t") or rest.lstrip().startswith(":="):
        return "", line
    if _OPERATOR.match(rest) and is_variable(word):
        return "", line
    name = _named(word)
    if not name or name != word and is_variable(word):
        return "", line
    return name, rest.strip()


def _named(word: str) -> str:
    """The command that a word stands for: its name, a short form, or a beginning that no other has; else ''."""
    if word in COMMANDS:
        return word
    if word in ALIASES:
        return ALIASES[word]
    longer = [name for name in COMMANDS if name.startswith(word)]
    return longer[0] if len(longer) == 1 and len(word) > 1 and word not in _NO_PREFIX else ""


class Commands(Moving, Looking):
    """Runs commands on a session. Each raises what its line did wrong."""

    def __init__(self, session) -> None:
        self.session = session
        self.plc = session.plc
        self.debugger = session.debugger

    def run(self, name: str, rest: str) -> None:
        if rest and COMMANDS[name].usage == name and name != "continue":
            more = f"; step {rest} runs scans" if name in ("next", "into", "out") else ""
            raise UsageError(f"{name} takes no arguments{more}")
        getattr(self, COMMANDS[name].method)(rest)

    def typed(self, line: str) -> None:
        """ST as it is: the value of an expression, or the effect of statements."""
        result = self.debugger.evaluate(line)
        if result.type is not None:
            self.session.say(result.text)

    def do_help(self, rest: str) -> None:
        say = self.session.say
        if rest:
            name = _named(rest.lower())
            if not name:
                raise UsageError(f"there is no command {rest}; help lists them")
            short = [a for a, n in ALIASES.items() if n == name]
            also = f"   (also {', '.join(short)})" if short else ""
            say(f"{COMMANDS[name].usage}{also}\n  {COMMANDS[name].text}")
            return
        room, usages = layout.width(), max(len(c.usage) for c in COMMANDS.values())
        for group in dict.fromkeys(c.group for c in COMMANDS.values()):
            say(f"{group}:")
            for command in COMMANDS.values():
                if command.group == group:
                    line = f"  {command.usage.ljust(usages)}  {command.text}"
                    self.session.show_lines(layout.broken(line, room, " " * (usages + 4)))
        say("Any ST may be typed as it is: n + 1, timer(IN := TRUE), n := 5; s, n, b, p, c, l ... stand for step, ...")
