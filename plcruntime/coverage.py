"""Coverage of ST: how often each statement ran, and which ways IF, CASE and loops took, counted by a probed build."""

from __future__ import annotations

import os
import struct
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as Xml

from plcruntime.errors import UsageError
from stcore.program import Program

Place = tuple[int, int]  # line, column


@dataclass(slots=True)
class Way:
    """A way of an IF, CASE or LOOP: its kind, label and line, and how often it was taken."""

    kind: str
    label: str
    line: int
    count: int = 0


@dataclass(slots=True)
class FileCoverage:
    """statements: place -> times run. decisions: place of the IF, CASE or loop -> its ways by number."""

    statements: dict[Place, int] = field(default_factory=dict)
    decisions: dict[Place, dict[int, Way]] = field(default_factory=lambda: defaultdict(dict))

    def lines(self) -> dict[int, int]:
        """Line -> how often its statements ran: the least of them, so that half a line is not a covered one."""
        counts: dict[int, int] = {}
        for (line, _), count in sorted(self.statements.items()):
            counts[line] = min(count, counts.get(line, count))
        return counts

    def ways(self, kind: str | None = None) -> Iterator[tuple[Place, int, Way]]:
        """(place of the decision, number, way) in the order of the text."""
        for place, ways in sorted(self.decisions.items()):
            for number, way in sorted(ways.items()):
                if kind in (None, way.kind):
                    yield place, number, way


class Coverage:
    """Counts of several runs, added up. files: path -> FileCoverage."""

    def __init__(self) -> None:
        self.files: dict[str, FileCoverage] = defaultdict(FileCoverage)

    def add(self, program: Program, memory) -> None:
        """Take the counts of a probed build out of its memory, and set them to 0. Library and tests do not count."""
        counts = struct.unpack_from(f"<{len(program.sites)}I", memory, program.probes)
        start = program.probes + 4 * len(program.sites)
        taken = struct.unpack_from(f"<{len(program.branches)}I", memory, start)
        memory[program.probes : program.flags] = bytes(program.flags - program.probes)
        left_out = self._left_out(program)
        for number in program.probed:
            site = program.sites[number]
            if site.pou in left_out:
                continue
            statements = self.files[site.file].statements
            place = (site.line, site.column)
            statements[place] = statements.get(place, 0) + counts[number]
        numbers: dict[int, int] = defaultdict(int)
        for branch, count in zip(program.branches, taken, strict=True):
            site = program.sites[branch.site]
            if site.pou in left_out:
                continue
            number = numbers[branch.site]
            numbers[branch.site] += 1
            ways = self.files[site.file].decisions[site.line, site.column]
            way = ways.setdefault(number, Way(branch.kind, branch.label, branch.line))
            way.count += count

    def data(self) -> dict:
        """The counts as lists and dictionaries of plain values, for `merge` in another process."""
        return {
            path: {
                "statements": [[*place, count] for place, count in file.statements.items()],
                "ways": [[*place, number, w.kind, w.label, w.line, w.count] for place, number, w in file.ways()],
            }
            for path, file in self.files.items()
        }

    def merge(self, data: dict) -> None:
        """Add the counts that `data` of another one gave."""
        for path, counted in data.items():
            file = self.files[path]
            for line, column, count in counted["statements"]:
                file.statements[line, column] = file.statements.get((line, column), 0) + count
            for line, column, number, kind, label, of_way, count in counted["ways"]:
                way = file.decisions[line, column].setdefault(number, Way(kind, label, of_way))
                way.count += count

    @staticmethod
    def _left_out(program: Program) -> set[str]:
        """Names of POUs of the library, and of those that are tests."""
        names = {b.pou for b in program.bodies if b.library}
        return names | {r.name for r in program.routines.values() if "test" in r.attributes}

    def table(self) -> list[tuple[str, ...]]:
        """A row a file for the terminal, under HEADS."""
        rows = []
        for path, file in sorted(self.files.items()):
            ran = [c > 0 for c in file.statements.values()]
            cells = [_short(path), *_part(ran)]
            for kind in ("IF", "CASE", "LOOP"):
                cells.append(_part([w.count > 0 for _, _, w in file.ways(kind)])[1])
            cells.append(_ranges([line for line, count in file.lines().items() if not count]))
            rows.append(tuple(cells))
        return rows

    def write(self, lcov: str | None, cobertura: str | None) -> None:
        """Write the files that are wanted. Raises OSError."""
        if lcov:
            self.write_lcov(Path(lcov))
        if cobertura:
            self.write_cobertura(Path(cobertura))

    def write_lcov(self, path: Path) -> None:
        """Raises OSError."""
        lines = []
        for name, file in sorted(self.files.items()):
            lines += ["TN:", f"SF:{name}"]
            ways = list(file.ways())
            for (line, column), number, way in ways:
                ran = any(w.count for w in file.decisions[line, column].values())
                lines.append(f"BRDA:{line},{column},{number},{way.count if ran else '-'}")
            lines += [f"BRF:{len(ways)}", f"BRH:{sum(w.count > 0 for _, _, w in ways)}"]
            counts = file.lines()
            lines += [f"DA:{line},{count}" for line, count in counts.items()]
            lines += [f"LF:{len(counts)}", f"LH:{sum(c > 0 for c in counts.values())}", "end_of_record"]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")

    def write_cobertura(self, path: Path) -> None:
        """Raises OSError."""
        lines = [c for f in self.files.values() for c in f.lines().values()]
        ways = [w.count for f in self.files.values() for _, _, w in f.ways()]
        root = Xml.Element("coverage", version="1", timestamp="0", complexity="0", **_rates(lines, ways))
        root.set("lines-covered", str(sum(c > 0 for c in lines)))
        root.set("lines-valid", str(len(lines)))
        root.set("branches-covered", str(sum(c > 0 for c in ways)))
        root.set("branches-valid", str(len(ways)))
        Xml.SubElement(Xml.SubElement(root, "sources"), "source").text = "."
        package = Xml.SubElement(Xml.SubElement(root, "packages"), "package", name=".", complexity="0")
        for name, value in _rates(lines, ways).items():
            package.set(name, value)
        classes = Xml.SubElement(package, "classes")
        for name, file in sorted(self.files.items()):
            self._cobertura_file(classes, name, file)
        Xml.indent(root)
        Xml.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)

    @staticmethod
    def _cobertura_file(classes: Xml.Element, name: str, file: FileCoverage) -> None:
        counts = file.lines()
        rates = _rates(list(counts.values()), [w.count for _, _, w in file.ways()])
        made = Xml.SubElement(classes, "class", name=Path(name).stem, filename=name, complexity="0", **rates)
        Xml.SubElement(made, "methods")
        listed = Xml.SubElement(made, "lines")
        by_line: dict[int, list[Way]] = defaultdict(list)
        for (line, _), _, way in file.ways():
            by_line[line].append(way)
        for line, count in counts.items():
            entry = Xml.SubElement(listed, "line", number=str(line), hits=str(count), branch="false")
            if line in by_line:
                taken = sum(w.count > 0 for w in by_line[line])
                percent = 100 * taken // len(by_line[line])
                entry.set("branch", "true")
                entry.set("condition-coverage", f"{percent}% ({taken}/{len(by_line[line])})")


def check_output(option: str, file: str) -> None:
    """Before anything runs: can the file be written? Raises UsageError."""
    path = Path(file)
    if not path.parent.is_dir():
        raise UsageError(f"{option} {path}: there is no folder {path.parent}")
    if path.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
        raise UsageError(f"{option} {path}: can't be written")


HEADS = ("file", "statements", "covered", "branches", "CASE states", "loops", "lines that never ran")


def _short(path: str) -> str:
    """Without the folder where we are."""
    inside = Path(path).is_relative_to(Path.cwd())
    return str(Path(path).relative_to(Path.cwd())) if inside else path


def _part(ran: list[bool]) -> tuple[str, str]:
    """('12', '75 % 9/12'); nothing to cover is '-'."""
    if not ran:
        return "0", "-"
    return str(len(ran)), f"{100 * sum(ran) / len(ran):.0f} % {sum(ran)}/{len(ran)}"


def _rates(lines: list[int], ways: list[int]) -> dict[str, str]:
    def rate(counts: list[int]) -> str:
        return f"{sum(c > 0 for c in counts) / len(counts):.4f}" if counts else "1"

    return {"line-rate": rate(lines), "branch-rate": rate(ways)}


def _ranges(lines: list[int]) -> str:
    """3-5, 9"""
    parts: list[list[int]] = []
    for line in lines:
        if parts and parts[-1][1] == line - 1:
            parts[-1][1] = line
        else:
            parts.append([line, line])
    return ", ".join(f"{a}-{b}" if b > a else str(a) for a, b in parts)
