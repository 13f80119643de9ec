"""Every row of catalogue.csv against the library: names, order, types, defaults, results; values of constants.

A difference must stand in signatures.toml with its reason. Functions that the manual only names (Table 10-2) are
compared with the table of motion_facts.md, 3.5.
"""

import csv
import re
import tomllib
from functools import cache
from pathlib import Path

import pytest

import mclib
import stcore.compiler
from plcruntime import PLC, catalogue

SHARED = Path(__file__).parents[3] / "shared"
pytestmark = pytest.mark.skipif(not SHARED.is_dir(), reason="the manuals are not beside this checkout")
DECISIONS = tomllib.loads((Path(__file__).with_name("signatures.toml")).read_text(encoding="utf-8"))
ZERO = ("false", "smc_no_error", "smc3_ppd_restoring_ok", "time#0ms")  # a member's default as it would be anyway
PARAMETER = re.compile(r"(?:(?:=>|VAR_IN_OUT) )?([\w, ]+?)\s*:(?!=)\s*(.*?)(?:\s*:=\s*(.*))?")


@cache
def catalogue_rows() -> list[dict]:
    if not SHARED.is_dir():
        return []
    with (SHARED / "manuals/catalogue.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def rows(manual: str, *kinds: str) -> list:
    return [pytest.param(r, id=r["name"]) for r in catalogue_rows() if r["manual"] == manual and r["kind"] in kinds]


@pytest.fixture(scope="module")
def library() -> dict[str, catalogue.Entry]:
    return {e.name: e for e in catalogue.entries([stcore.compiler.LIBRARY, mclib.LIBRARY])}


def parameters(text: str, separator: str) -> list[str]:
    """'name: TYPE := default' of each."""
    found = []
    for part in filter(None, (p.strip() for p in text.split(separator))):
        names, declared, default = PARAMETER.fullmatch(part).groups()
        found += [f"{name.strip()}: {declared}" + (f" := {default}" if default else "") for name in names.split(",")]
    return found


def members(text: str) -> list[str]:
    """As `parameters`, of a block or structure: in small letters, 'ENUM.value' as 'value', zero the same as nothing."""
    found = []
    for member in parameters(text, ";"):
        declared, _, default = member.lower().partition(" := ")
        default = default.rpartition(".")[2] if re.match("[a-z]", default) else default.removesuffix(".0")
        found.append(declared + (f" := {default}" if default not in ("", "0", *ZERO) else ""))
    return found


def of_function(signature: str, separator: str) -> tuple[list[str], str]:
    inside, result = re.fullmatch(r"\w+(?:<.*>)?\((.*)\)(?:: (.*))?", signature).groups()
    return parameters(inside, separator), result or ""


def expected(function: str, printed: list[str]) -> list[str]:
    """What the library should have: as printed, or as decided."""
    found = []
    for p in printed:
        decided = DECISIONS["parameter"].get(f"{function}.{p}", [p])[0]
        name, _, kind = decided.partition(": ")
        found.append(f"{name}: {DECISIONS['types'].get(kind, [kind])[0]}")
    return found


@pytest.mark.parametrize("row", rows("ideabox3", "function") + rows("am600_mc", "function"))
def test_functions(row, library):
    name = row["name"]
    if name in DECISIONS["absent"]:
        assert name not in library
        return
    entry = library[name]
    if name in DECISIONS["instruction"]:
        assert "built into the compiler" in entry.summary
        return
    signature = row["signature"] if "..." not in row["signature"] else only_named()[name]
    printed, result = of_function(signature, ";" if ";" in signature else ",")
    if name in DECISIONS["standard"]:
        assert len(of_function(entry.signature, ";")[0]) == len(printed) and entry.source.startswith("IEC 61131-3")
        return
    assert of_function(entry.signature, ";") == (expected(name, printed), result)


@cache
def only_named() -> dict[str, str]:
    """name -> signature of the functions in the table of motion_facts.md, 3.5; several in a row share one or have each
    their own."""
    found = {}
    text = (SHARED / "reference/motion_facts.md").read_text(encoding="utf-8")
    for line in text.partition("### 3.5")[2].splitlines():
        cells = [c.strip() for c in line.split("|")[1:-1]]
        if len(cells) == 3 and cells[0].startswith("GT_"):
            names = cells[0].split(", ")
            inputs = re.findall(r"\(([^()]*:[^()]*)\)", cells[1])
            for k, name in enumerate(names):
                found[name] = f"{name}({inputs[k if len(inputs) == len(names) else 0]}): INT"
    return found


SECTIONS = {"VAR_INPUT": "", "VAR_IN_OUT": "VAR_IN_OUT ", "VAR_OUTPUT": "=> "}


@pytest.mark.parametrize("row", rows("am600_mc", "function_block"))
def test_blocks(row, library):
    """What the manual prints is there, in its order; CODESYS has more inputs and outputs than the AM600 manual."""
    parts = [p.strip() for p in re.fullmatch(r"\w+\((.*)\)", library[row["name"]].signature)[1].split(";")]
    for section, arrow in SECTIONS.items():
        printed = members("; ".join(re.findall(rf"{section} (.*?)\s*END_VAR", row["signature"])))
        mine = [p for p in parts if (p.startswith(arrow) if arrow else not p.startswith(("VAR_IN_OUT", "=>")))]
        have, wanted = members(";".join(mine)), expected(row["name"], printed)
        found = [p for p in have if p in wanted]
        assert (sorted(found) if row["name"] in DECISIONS["order"] else found) == (
            sorted(wanted) if row["name"] in DECISIONS["order"] else wanted
        )


CONSTANTS = rows("ideabox3", "constant") + [
    r
    for r in rows("guc_ecat_advanced", "constant")
    if r.values[0]["name"] in ("MC_ALARM", "MC_HOME", "MC_GPI", "MC_ARRIVE")
]
STRUCTURES = rows("ideabox3", "struct")


@pytest.fixture(scope="module")
def loaded() -> PLC:
    """A program that uses every constant and every structure."""
    constants = "\n".join(f"c_{p.values[0]['name']} : INT := {p.values[0]['name']};" for p in CONSTANTS)
    structures = "\n".join(f"s_{p.values[0]['name']} : {p.values[0]['name']};" for p in STRUCTURES)
    return PLC.load(f"PROGRAM PLC_PRG VAR {constants} {structures} END_VAR c_MC_GPO := c_MC_GPO; END_PROGRAM")


@pytest.mark.parametrize("row", CONSTANTS)
def test_constants(row, loaded):
    value = loaded[f"PLC_PRG.c_{row['name']}"]
    printed = re.search(r":= (-?\d+)", row["signature"])
    assert printed is None or value == int(printed[1])


@pytest.mark.parametrize("row", STRUCTURES)
def test_structures(row, loaded):
    have = [
        f"{m.name}: {m.type}".replace("STRING(80)", "STRING")
        for m in loaded.place(f"PLC_PRG.s_{row['name']}").type.members.values()
    ]
    assert have
    if "not printed" not in row["signature"]:
        assert have == parameters(re.search(r"STRUCT (.*?) END_STRUCT", row["signature"])[1], ";")


def test_every_decision_is_needed(library):
    used = set()
    for row in catalogue_rows():
        if row["kind"] == "function" and "..." not in row["signature"]:
            used |= {f"{row['name']}.{p}" for p in re.findall(r"\w+: [\w :=]+", row["signature"].partition("(")[2])}
    assert set(DECISIONS["parameter"]) <= used
    names = {r["name"] for r in catalogue_rows()}
    assert {name for table in ("absent", "instruction", "standard", "order") for name in DECISIONS[table]} <= names
