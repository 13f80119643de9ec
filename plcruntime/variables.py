"""Variables of a PLC by path: read, written, forced, parsed from text."""

from __future__ import annotations

from stcore import paths, values
from stcore.paths import PathError, Place
from stcore.program import Program
from stcore.show import show


class Variables:
    """The part of PLC that knows its variables."""

    program: Program

    def place(self, path: str) -> Place:
        """Where a path leads: its full name, type and address. Raises PathError (a KeyError)."""
        place = self._places.get(path)
        if place is None:
            place = self._places[path] = paths.resolve(self.program, path)
        return place

    def __getitem__(self, path: str):
        """The value of a variable. Raises PathError: unknown, ambiguous, or behind a NULL pointer."""
        return values.read(self._machine.memory, self.place(path))

    def __setitem__(self, path: str, value) -> None:
        """Write a variable now, before the next scan. Raises PathError, TypeError, ValueError, writing nothing."""
        self._engine.write(self._pieces(self.place(path), value))

    def show(self, path: str) -> str:
        """The value as ST writes it: TRUE, T#1.5s, 'text', the name of an ENUM's value."""
        return show(self.place(path).type, self[path])

    def _pieces(self, place: Place, value) -> list[tuple[int, bytes]]:
        if place.constant:
            raise ValueError(f"{place.name} is a constant")
        if place.read_only:
            raise ValueError(f"VAR_ACCESS has {place.name} READ_ONLY; its own path may be written")
        return values.encode(self._machine.memory, place, value)

    def variables(self) -> dict[str, object]:
        """The values of all variables of the user's programs and global lists, by full path."""
        memory = self._machine.memory
        return {p.name: values.read(memory, p) for p in paths.user_places(self.program)}

    def check_value(self, path: str, value) -> None:
        """Whether a value could be written. Raises PathError, TypeError, ValueError as writing does."""
        place = self.place(path)
        try:
            self._pieces(place, value)
        except PathError:
            if not place.hops:
                raise  # behind a pointer that the program sets later: told when it is written

    def parse_value(self, path: str, text: str):
        """The Python value of an ST literal for a variable. Raises PathError, TypeError, ValueError."""
        place = self.place(path)
        node = values.plain_literal(text) or _parsed(text)
        return values.literal(self.program, self._machine.memory, node, place.type, place.name)

    def force(self, path: str, value) -> None:
        """Hold a variable at a value before and after the programs of every scan, until `unforce`."""
        place = self.place(path)
        pieces = self._pieces(place, value)
        self._engine.write(pieces)
        self._engine.change_forces(lambda forces: forces.hold(place.name, pieces, place.bit))

    def unforce(self, path: str | None = None) -> None:
        """Release a forced variable, or all. Raises PathError when the variable is not forced."""
        name = self.place(path).name if path is not None else None
        if name is not None and name not in self.forced:
            raise PathError(f"{name} is not forced; forced: {', '.join(self.forced) or 'nothing'}")

        def change(forces) -> None:
            for forced in list(forces.active):
                if name in (None, forced):
                    del forces.active[forced]

        self._engine.change_forces(change)

    @property
    def forced(self) -> list[str]:
        """The paths that are forced."""
        return list(self._engine.forces.active)


def _parsed(text: str):
    """The syntax node of a value. Raises ValueError."""
    from stcore.diagnostics import Reporter
    from stcore.parser import parse_initializer
    from stcore.source import Source

    reporter = Reporter()
    node = parse_initializer(Source(text, "<value>"), reporter)
    if reporter.failed or node is None:
        raise ValueError(f"{text} is not a value; write it as in ST: TRUE, 16#FF, 'text', T#500ms, [1,2,3], (a:=1)")
    return node
