"""Programs for tests that try many things on each: a choice that keeps the suite quick."""

from pathlib import Path

EXAMPLES = sorted((Path(__file__).parents[1] / "examples_st").glob("*.st"))
_OF_ONE_BLOCK = ("mc_", "smc")  # examples of one motion block each, all alike


def some_examples() -> list[Path]:
    """All of examples_st, but of those that show one motion block every eighth."""
    alike = [e for e in EXAMPLES if e.name.startswith(_OF_ONE_BLOCK)]
    return [e for e in EXAMPLES if e not in alike] + alike[::8]
