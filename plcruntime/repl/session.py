"""What a session at the prompt remembers, and how it shows where the PLC stands."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from plcruntime import layout
from plcruntime.debugger import Debugger, Outcome, Stop
from plcruntime.plc import PLC
from plcruntime.trace import Trace
from plcruntime.warnings import RunWarning
from stcore import paths, values
from stcore.diagnostics import CompileError
from stcore.diagnostics import text as shown
from stcore.faults import Fault
from stcore.paths import PathError, Place
from stcore.program import NULL_PAGE
from stcore.show import show
from stcore.side import summary
from stcore.source import read

LONG = 100  # characters of a value that are shown


class Session:
    """A PLC at the prompt: its debugger, watch list, traces, and the image of the stop before."""

    def __init__(self, plc: PLC) -> None:
        self.plc = plc
        self.debugger = Debugger(plc)
        self.watched: list[str] = []
        self.trace: Trace | None = None
        self.interactive = False
        self.baseline = self.image()
        self._sources: dict[str, list[str]] = {}
        self._warned: list[RunWarning] = []

    # -------------------------------------------------------------------------------------------- output

    def say(self, text: str = "") -> None:
        """Something to read: broken between words where the terminal is narrower."""
        for line in layout.broken(text, layout.width()):
            print(line, flush=True)

    def show_lines(self, lines: Iterable[str]) -> None:
        """Lines whose form matters: source, pictures, tables."""
        for line in lines:
            print(line, flush=True)

    def table(self, heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> None:
        self.show_lines(layout.table(heads, rows, layout.width()))

    def greet(self) -> None:
        names = ", ".join(v.path for v in self.plc.program.programs())
        self.say(f"{names}: loaded, before the first scan of {self.plc.interval * 1000:g} ms; help lists the commands")

    def close(self) -> None:
        """Undo a scan that waits; the retain file, where there is one, is written."""
        self.debugger.abandon()
        self.plc.close()

    # ------------------------------------------------------------------------------------------ the stop

    def image(self) -> bytes:
        return bytes(self.plc._machine.memory[NULL_PAGE : self.plc.program.image_end])

    def begin(self) -> None:
        """The PLC is about to move: what `diff` compares with."""
        self.baseline = self.image()

    def show(self, outcome: Outcome, word: str = "") -> None:
        """After a movement."""
        if outcome.stop is None:
            self.debugger.detach()
            self.stopped(word)
            return
        stop = outcome.stop
        what = f"breakpoint {stop.breakpoint}: " if stop.breakpoint else ""
        place = stop.instance if stop.instance == stop.site.pou else f"{stop.instance} ({stop.site.pou})"
        self.say(f"{what}{place}, in scan {self.plc.scans}, {self.time()}")
        if stop.note:
            self.say(f"  {stop.note}")
        self.show_lines([self.source_line(stop.site.file, stop.site.line, ">")])
        self.show_watched()

    def stopped(self, word: str = "") -> None:
        """Between two scans."""
        self.show_warnings()
        self.say(f"{word + ': ' if word else ''}{self.progress()}")
        self.show_watched()

    def show_warnings(self) -> None:
        """What the program did wrong with its motion blocks since the last look."""
        warnings = self.plc.warnings
        for warning in warnings:
            if warning not in self._warned:
                self.say(shown(warning))
        self._warned = warnings  # after going back they may come again

    def faulted(self, fault: Fault, text) -> None:
        """The program failed, or what was typed did."""
        if self.plc.fault is fault:
            self.say(text(fault, self.plc.time))
            self.say("the PLC is in its exception state; look around, then: back, reset or load")
        else:
            place = f" ({fault.file}:{fault.line})" if Path(fault.file).is_file() else ""
            self.say(f"fault {fault.code}: {fault.message}{place}")

    def progress(self) -> str:
        """How far the PLC is: 5 scans, 0.005 s."""
        return f"{counted(self.plc.scans)}, {self.time()}"

    def time(self) -> str:
        return f"{self.plc.time:.9g} s"

    def show_watched(self) -> None:
        for text in self.watched:
            self.say(f"  {text} = {self.value_text(text)}")

    def value_text(self, text: str) -> str:
        """The value of a path or an expression, or why there is none."""
        try:
            return self.short(self.evaluate_text(text))
        except CompileError as error:
            return f"<{summary(error.diagnostics)}>"
        except Fault as fault:
            return f"<{fault.message}>"
        except Exception as error:  # a watch that fails must not keep the others from being shown
            return f"<{str(error).splitlines()[0]}>"

    def evaluate_text(self, text: str) -> str:
        """A path is read at once; anything else is compiled."""
        if self.debugger.stop is None:
            try:
                return self.plc.show(text)
            except PathError:
                pass  # not the path of a variable: an expression
        result = self.debugger.evaluate(text)
        return result.text if result.type is not None else "done"

    @staticmethod
    def short(text: str) -> str:
        return text if len(text) <= LONG else text[: LONG - 3] + "..."

    # ------------------------------------------------------------------------------------------- sources

    def lines_of(self, file: str) -> list[str]:
        """The lines of a source file; [] for a text without file."""
        if file not in self._sources:
            self._sources[file] = read(Path(file)).text.splitlines() if Path(file).is_file() else []
        return self._sources[file]

    def source_line(self, file: str, line: int, mark: str = " ") -> str:
        lines = self.lines_of(file)
        text = lines[line - 1] if 0 < line <= len(lines) else f"({file}:{line})"
        return f"{mark}{line:5} | {text}"

    # ------------------------------------------------------------------------------------------- changes

    def changes(self, inner: bool) -> list[tuple[str, str, str]]:
        """(path, before, after) of every variable of the user that differs from the stop before. inner: the inner
        variables of the library's blocks too."""
        libraries = [Path(folder) for folder in self.plc.program.libraries]
        own = (lambda _: True) if inner else lambda block: not any(x in Path(block.file).parents for x in libraries)
        before = bytes(NULL_PAGE) + self.baseline
        now = bytes(NULL_PAGE) + self.image()
        found: list[tuple[str, str, str]] = []
        for place in paths.user_places(self.plc.program):
            found += self._differing(place, before, now, own)
        return found

    @staticmethod
    def _differing(place: Place, before: bytes, now: bytes, own) -> list[tuple[str, str, str]]:
        if place.hops or before[place.address : place.address + max(place.size, 1)] == now[
            place.address : place.address + max(place.size, 1)
        ]:
            return []
        found = []
        for leaf in paths.leaves(place, own):
            old, new = values.read(before, leaf), values.read(now, leaf)
            if old != new and (old == old or new == new):
                found.append((leaf.name, show(leaf.type, old), show(leaf.type, new)))
        return found

    # --------------------------------------------------------------------------------------------- names

    def place(self, path: str) -> Place:
        """Where a path leads; the names of the POU that a scan waits in come first. Raises PathError."""
        if self.debugger.stop is not None:
            try:
                return self.plc.place(f"{self.debugger.stop.instance}.{path}")
            except PathError:
                pass  # no name of that POU
        return self.plc.place(path)

    def is_variable(self, name: str) -> bool:
        """Whether a word is a variable here; it then wins over a command's abbreviation."""
        stop = self.debugger.stop
        if stop is not None and name.upper() in _own_names(stop):
            return True
        try:
            self.plc.place(name)
        except PathError:
            return False
        return True


def _own_names(stop: Stop) -> set[str]:
    members = set(stop.body.block.members) if stop.body.block is not None else set()
    return members | {name.upper() for name, *_ in stop.body.locals}


def counted(scans: int) -> str:
    """1 scan, 2 scans."""
    return f"{scans} scan{'s' if scans != 1 else ''}"
