"""Write docs/blocks and docs/compliance.md from the library and the examples: python docs/make [NAME...]

NAME: only these blocks' pages. --text: leave the charts. --check: write nothing, exit 1 where a page is out of date.
"""

from __future__ import annotations

import argparse
import sys

import compliance
import library
import pages

DOCS = library.ROOT / "docs"
BLOCKS = DOCS / "blocks"


def texts(names: list[str]) -> dict:
    """Path -> text of every page."""
    blocks = library.blocks()
    wanted = [blocks[n] for n in names] if names else list(blocks.values())
    found = {BLOCKS / f"{b.name}.md": pages.page(b) for b in wanted}
    if not names:
        found[BLOCKS / "README.md"] = pages.index(list(blocks.values()))
        found[DOCS / "compliance.md"] = compliance.page(pages.NOTE)
    return found


def out_of_date() -> list[str]:
    """What differs between docs/ and what would be written, charts that are missing or too much, gaps."""
    expected = texts([])
    wrong = [p.name for p, text in expected.items() if not p.exists() or p.read_text(encoding="utf-8") != text]
    charts = {f"{name}.png" for name in library.blocks()}
    wrong += [f"{n} is missing" for n in sorted(charts - {p.name for p in BLOCKS.glob("*.png")})]
    there = {p.name for p in BLOCKS.iterdir()}
    wrong += library.gaps()
    return wrong + [f"{n} belongs to no block" for n in sorted(there - charts - {p.name for p in expected})]


def main() -> int:
    parser = argparse.ArgumentParser(prog="python docs/make", description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="only these blocks")
    parser.add_argument("--text", action="store_true", help="leave the charts as they are")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 where a page is out of date")
    options = parser.parse_args()
    if options.check:
        wrong = out_of_date()
        if wrong:
            print("out of date (write them anew: python docs/make):\n  " + "\n  ".join(wrong))
        return bool(wrong)
    if unknown := [n for n in options.names if n not in library.blocks()]:
        print(f"no such block: {', '.join(unknown)}", file=sys.stderr)
        return 2
    BLOCKS.mkdir(exist_ok=True)
    for path, text in texts(options.names).items():
        path.write_text(text, encoding="utf-8")
    if not options.text:
        import charts

        for name in options.names or library.blocks():
            charts.draw(library.blocks()[name], BLOCKS / f"{name}.png")
            print(f"{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
