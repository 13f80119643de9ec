"""The prompt: ``scancycle repl FILE...``. Commands of gdb and of the PLC, and any ST as it is."""

from __future__ import annotations

import re
import sys
import traceback

from plcruntime.errors import ConditionTimeout, UsageError
from plcruntime.repl.commands import COMMANDS, Commands, split
from plcruntime.repl.entry import OPENING, incomplete
from plcruntime.repl.session import Session
from plcruntime.report import fault_text
from stcore.diagnostics import CompileError
from stcore.faults import Fault
from stcore.near import near
from stcore.paths import PathError
from stcore.side import SideError, summary


class Repl:
    """Reads lines until `quit` or the end of the input; a line that is wrong gets one sentence."""

    def __init__(self, plc) -> None:
        self.session = Session(plc)
        self.commands = Commands(self.session)
        self.last = ""

    def loop(self) -> None:
        """On a terminal with completion and history, else from the standard input as it comes."""
        self.session.greet()
        self.session.debugger.prepare()
        if sys.stdin.isatty() and sys.stdout.isatty():
            from plcruntime.repl.terminal import lines
        else:
            lines = _piped
        for line in lines(self.session):
            if self.handle(line) is False:
                break
        self.session.close()

    def handle(self, line: str) -> bool:
        """One line; False when the session is to end. Nothing that a line does wrong leaves this function."""
        line = line.strip()
        if not line:
            # Enter repeats a step, as in gdb
            line = self.last
            if not line:
                return True
        name, rest = split(line, self.session.is_variable)
        self.last = line if name in ("step", "next", "into", "out", "back") else ""
        if name == "quit":
            return False
        try:
            if name in COMMANDS:
                self.commands.run(name, rest)
            else:
                self.commands.typed(line)
        except CompileError as error:
            self.session.say(summary(error.diagnostics) + ("" if name in COMMANDS else _meant(line)))
        except Fault as fault:
            self.session.faulted(fault, fault_text)
        except KeyboardInterrupt:
            self.session.stopped("interrupted")
        except (UsageError, PathError, SideError, ConditionTimeout, ValueError, TypeError) as error:
            self.session.say(str(error))
        except OSError as error:
            self.session.say(f"{error.filename or 'file'}: {error.strerror or error}")
        except RecursionError:
            self.session.say("that is nested too deeply")
        except Exception as error:  # a mistake of ours: the user's session is worth more than its place
            traceback.print_exc()
            self.session.say(f"scancycle itself failed here ({error}); please report the lines above")
        return True


def _meant(line: str) -> str:
    """The command that a line that is no ST may have been meant as."""
    word = re.match(r"([A-Za-z]{3,})(\s|$)", line)
    hint = near(word[1].lower(), list(COMMANDS)) if word and word[1].upper() not in OPENING else ""
    return f"; {hint.removesuffix('?')}, the command?" if hint else ""


def _piped(_session):
    text = ""
    for line in sys.stdin:
        if not text and line.lstrip().startswith("#"):
            continue
        text += line
        if not line.strip() or not incomplete(text.rstrip()):
            yield text
            text = ""
    if text:
        yield text
