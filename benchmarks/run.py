"""Our generated code beside hand-written C, in one process: python benchmarks/run.py [--rounds N] [--quick]

Rounds of both are interleaved and each keeps its best, so that what else the machine does falls on both alike.
Prints the ratios and writes benchmarks/RESULTS.md.
"""

from __future__ import annotations

import argparse
import ctypes
import datetime
import importlib.metadata
import json
import math
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from plcruntime import PLC

HERE = Path(__file__).resolve().parent
PROGRAMS = HERE / "programs"
EXAMPLE = HERE.parent / "examples_st" / "gt_two_moves.st"
LISTING = HERE.parent.parent / "shared" / "manuals" / "listings" / "ideabox3" / "14_trap_move.st"

# scans a round: about 0.1 s of C each. The matiec ratios were measured with matiec + gcc -O2 on the same programs.
SCANS = {"B1": 400_000, "B2": 400_000, "B3": 4_000, "B4": 200_000}
WHAT = {
    "B1": "logic: CASE, IF, integers, 10 TON",
    "B2": "LREAL: profiles of 8 axes, SQRT, SIN",
    "B3": "arrays and a pointer: bubble sort",
    "B4": "50 instances of a function block",
}
MATIEC = {"B1": 1.53, "B2": 1.57, "B3": 0.58, "B4": 1.43}
# what hand.c's results() leaves at which place, and the variable that must equal it
SUMS = {
    "B1": {"sum": 0, "runs": 1},
    "B2": {"sum": 2, "sumc": 3, "dones": 4},
    "B3": {"sum": 5, "swaps": 6},
    "B4": {"sum": 7, "dones": 8, "aborts": 9},
}

AXES = """PROGRAM PLC_PRG
VAR
  axis: ARRAY[1..{axes}] OF AXIS_REF_SM3;
  power: ARRAY[1..{axes}] OF MC_Power;
  move: ARRAY[1..{axes}] OF {move};
  state: ARRAY[1..{axes}] OF MC_ReadStatus;
  i: INT;
  inMotion: DINT;
END_VAR
FOR i := 1 TO {axes} DO
  power[i](Axis := axis[i], Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);
  {call}
  state[i](Axis := axis[i], Enable := TRUE);
  IF state[i].DiscreteMotion OR state[i].ContinuousMotion THEN
    inMotion := inMotion + 1;
  END_IF
END_FOR
END_PROGRAM
"""
MOTIONS = {
    "MC_MoveVelocity": "move[i](Axis := axis[i], Execute := power[i].Status, Velocity := 10 * i, Acceleration := 100,"
    " Deceleration := 100, Jerk := 1000);",
    "MC_MoveAbsolute": "move[i](Axis := axis[i], Execute := power[i].Status AND NOT move[i].Done,"
    " Position := SEL(move[i].Position > 50, 100 * i, 10), Velocity := 100, Acceleration := 1000,"
    " Deceleration := 1000, Jerk := 20000);",
}


class C:
    """hand.c, compiled with gcc -O2."""

    def __init__(self, folder: str) -> None:
        library = os.path.join(folder, "hand.so")
        source = PROGRAMS / "hand.c"
        subprocess.run(["gcc", "-O2", "-w", "-shared", "-fPIC", "-o", library, str(source), "-lm"], check=True)
        self.library = ctypes.CDLL(library)
        self.library.reset()

    def scan(self, name: str, n: int) -> float:
        run = getattr(self.library, f"run_{name.lower()}")
        start = time.perf_counter()
        run(ctypes.c_int64(n), ctypes.c_int64(1_000_000))
        return time.perf_counter() - start

    def results(self) -> list[float]:
        out = (ctypes.c_double * 10)()
        self.library.results(out)
        return list(out)


def generated_code(c: C | None, rounds: int, quick: bool) -> list[dict]:
    """One row a program: nanoseconds a scan of ours and of C, and their ratio."""
    plcs = {name: PLC.load(str(PROGRAMS / f"{name}.st"), interval="1ms") for name in SCANS}
    times: dict[str, tuple[list, list]] = {name: ([], []) for name in SCANS}
    for _ in range(rounds):
        for name, n in SCANS.items():
            n = n // 20 if quick else n
            start = time.perf_counter()
            plcs[name].scan(n)
            times[name][0].append((time.perf_counter() - start) / n * 1e9)
            if c:
                times[name][1].append(c.scan(name, n) / n * 1e9)
    rows = []
    for name, (ours, theirs) in times.items():
        row = {"name": name, "ours": min(ours), "median": statistics.median(ours)}
        if c:
            row |= {"c": min(theirs), "ratio": min(ours) / min(theirs), "differs": different(name, c)}
            row["median_ratio"] = statistics.median(a / b for a, b in zip(ours, theirs, strict=True))
        rows.append(row)
    return rows


def different(name: str, c: C, scans: int = 20_000) -> list[str]:
    """The checksums that are not those of C after the same number of scans. SIN is ours in one, libm's in the other."""
    plc = PLC.load(str(PROGRAMS / f"{name}.st"), interval="1ms")
    plc.scan(scans)
    c.library.reset()  # its clock serves all four programs
    c.scan(name, scans)
    results = c.results()
    found = []
    for variable, place in SUMS[name].items():
        ours, theirs = plc[f"{name}.{variable}"], results[place]
        if not math.isclose(ours, theirs, rel_tol=1e-9 if variable == "sumc" else 0):
            found.append(f"{variable} {ours}, C {theirs}")
    return found


def motion(rounds: int, quick: bool) -> list[dict]:
    """8 and 32 axes with 3 blocks each at 1 ms: multiples of real time."""
    rows = []
    for axes, scans in ((8, 50_000), (32, 12_500)):
        for block, call in MOTIONS.items():
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "axes.st"
                file.write_text(AXES.format(axes=axes, move=block, call=call))
                plc = PLC.load(str(file), interval="1ms")
            plc.scan(100)
            n = scans // 25 if quick else scans
            best = math.inf
            for _ in range(rounds):
                start = time.perf_counter()
                plc.scan(n)
                best = min(best, time.perf_counter() - start)
            moving = plc["PLC_PRG.inMotion"] / (axes * (100 + rounds * n))
            rows.append(
                {"axes": axes, "block": block, "scan": best / n * 1e9, "times": n * 1e-3 / best, "moving": moving}
            )
    return rows


def tracing(rounds: int, quick: bool) -> list[dict]:
    """A scan with a trace of every variable beside the same scan without; in turns, and each at its best."""
    rows = []
    for name, n in SCANS.items():
        n = n // (400 if quick else 50)  # short, so that a round is rarely disturbed; it keeps some 5 MB
        plain, traced = (PLC.load(str(PROGRAMS / f"{name}.st"), interval="1ms") for _ in range(2))
        best = [math.inf, math.inf]
        for _ in range(10 * rounds):
            trace = traced.trace("*")
            for k, plc in enumerate((plain, traced)):
                start = time.perf_counter()
                plc.scan(n)
                best[k] = min(best[k], time.perf_counter() - start)
            traced.stop_trace(trace)
        a, b = (x / n * 1e9 for x in best)
        rows.append({"name": name, "plain": a, "traced": b, "variables": len(trace.names)})
    return rows


def timed(code: str, cache: str, *arguments: str) -> dict:
    """Run Python code in a process of its own, which prints a JSON object; with the cache folder given."""
    env = {**os.environ, "SCANCYCLE_CACHE": cache}
    done = subprocess.run([sys.executable, "-c", code, *arguments], env=env, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"the measurement failed:\n{done.stderr}")
    return json.loads(done.stdout)


COMPILE = """
import json, sys, time
import plcruntime, stcore
from stcore.machine import Machine
from stcore.program import TaskSpec
file, *programs = sys.argv[1:]
start = time.perf_counter()
program = stcore.compile([file], tasks=[TaskSpec("main", programs)])
compiled = time.perf_counter()
machine = Machine(program)
print(json.dumps({"compile": compiled - start, "load": time.perf_counter() - compiled}))
"""

PARSE = """
import json, sys, time
from stcore.parser import parse
from stcore.source import Source
parse(Source("PROGRAM p\\nVAR x: INT; END_VAR\\nx := x + 1;\\nEND_PROGRAM\\n"))
text = open(sys.argv[1], encoding="utf-8").read()
start = time.perf_counter()
parse(Source(text, sys.argv[1]))
print(json.dumps({"lines": text.count("\\n"), "seconds": time.perf_counter() - start}))
"""


def compiling(rounds: int) -> dict:
    """big.st, 8,799 lines: nothing cached; its tree cached but the build not; everything cached."""
    big = str(PROGRAMS / "big.st")
    programs = [f"B{k}_{i}" for i in range(11) for k in (1, 2, 3, 4)]
    cold, trees, built, parses = [], [], [], []
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as cache:
            cold.append(timed(COMPILE, cache, big, *programs))
            built.append(timed(COMPILE, cache, big, *programs))
            # another order of the programs is another build of the same tree
            trees.append(timed(COMPILE, cache, big, *reversed(programs)))
            parses.append(timed(PARSE, cache, big))
    parse = min(parses, key=lambda p: p["seconds"])
    return {
        "cold": min(c["compile"] + c["load"] for c in cold),
        "trees": min(c["compile"] + c["load"] for c in trees),
        "built": min(c["compile"] + c["load"] for c in built),
        "parse": parse["seconds"],
        "lines": parse["lines"] / parse["seconds"],
    }


def cold_start(rounds: int) -> tuple[str, float]:
    """From the start of the command to its result, library and program cached."""
    if LISTING.exists():
        name, file, options = "Example 7-1 of the iDEABOX 3 manual", LISTING, ["--set", "xStart=TRUE@10ms"]
    else:
        name, file, options = "examples_st/gt_two_moves.st", EXAMPLE, ["--set", "start=TRUE@10ms"]
    command = [str(Path(sys.executable).with_name("scancycle")), "run", str(file), *options, "--for", "2s", "--json"]
    times = []
    for _ in range(rounds + 1):
        start = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - start)
    return name, min(times[1:])


def processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def machine_description() -> str:
    load = f"load {os.getloadavg()[0]:.1f} at the start" if hasattr(os, "getloadavg") else "load unknown"
    gcc = "no gcc"
    if shutil.which("gcc"):
        gcc = subprocess.run(["gcc", "--version"], capture_output=True, text=True).stdout.splitlines()[0]
    return ", ".join(
        [
            f"{processor()}, {os.cpu_count()} cores, {load}",
            f"{platform.system()} {platform.machine()}",
            f"Python {platform.python_version()}",
            f"wasmtime {importlib.metadata.version('wasmtime')}",
            gcc,
        ]
    )


def report(
    rows: list[dict], traces: list[dict], moves: list[dict], big: dict, start: tuple[str, float], machine: str
) -> str:
    lines = [
        "# Results",
        "",
        f"Written by `make bench` on {datetime.date.today()}.",
        f"{machine}.",
        "",
        "Ratios carry over to other machines, absolute times do not. Both columns of a row were measured in turns in",
        "one process; each is the best of its rounds.",
        "",
        "## Generated code beside hand-written C",
        "",
        "All checks on (index, pointer, division, loop) in ours, none in C; the same checksums from both.",
        "",
        "| program | what | ours, ns a scan | gcc -O2 | ratio | median ratio | matiec + gcc |",
        "|---|---|--:|--:|--:|--:|--:|",
    ]
    for row in rows:
        c, ratio, middle = (
            (f"{row['c']:,.0f}", f"{row['ratio']:.2f}", f"{row['median_ratio']:.2f}") if "c" in row else "---"
        )
        name = row["name"]
        lines.append(f"| {name} | {WHAT[name]} | {row['ours']:,.0f} | {c} | {ratio} | {middle} | {MATIEC[name]:.2f} |")
    if all("ratio" in row for row in rows):
        best, middle = (geometric(row[key] for row in rows) for key in ("ratio", "median_ratio"))
        lines.append(f"| geometric mean | | | | {best:.2f} | {middle:.2f} | {geometric(MATIEC.values()):.2f} |")
    lines += [
        "",
        "matiec's ratios were measured elsewhere, without checks. gcc compiles the bubble sort of hand.c to branches",
        "that are guessed wrong; that is why a compiler can be faster there.",
        "",
        "## A trace of every variable in every scan",
        "",
        "Beside the same scan without a trace. Rows are copied in the scan and searched for changes 16 at a time; what",
        "changes is kept. A program that changes much more than it computes (B2: 80 LREAL in each scan) pays for that.",
        "",
        "| program | variables | ns a scan | with the trace | ratio |",
        "|---|--:|--:|--:|--:|",
        *(
            f"| {t['name']} | {t['variables']:,} | {t['plain']:,.0f} | {t['traced']:,.0f} |"
            f" {t['traced'] / t['plain']:.2f} |"
            for t in traces
        ),
        "",
        "## Motion: three blocks an axis, 1 ms",
        "",
        "| axes | MC_Power, MC_ReadStatus and | ns a scan | times real time | axes in motion |",
        "|--:|---|--:|--:|--:|",
        *(
            f"| {m['axes']} | {m['block']} | {m['scan']:,.0f} | {m['times']:,.0f} | {m['moving']:.0%} |" for m in moves
        ),
        "",
        "## Compiling and starting",
        "",
        "| what | seconds |",
        "|---|--:|",
        f"| big.st, 8,799 lines, nothing cached | {big['cold']:.2f} |",
        f"| big.st, its tree cached, the build not | {big['trees']:.2f} |",
        f"| big.st unchanged | {big['built']:.2f} |",
        f"| parsing big.st alone: {big['lines']:,.0f} lines a second | {big['parse']:.2f} |",
        f"| {start[0]}, from the start of the command to its result, cached | {start[1]:.2f} |",
        "",
    ]
    return "\n".join(lines)


def geometric(values) -> float:
    return math.exp(statistics.fmean(math.log(v) for v in values))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7, help="rounds of each program (default 7)")
    parser.add_argument("--quick", action="store_true", help="a twentieth of the work: to see that everything runs")
    parser.add_argument("--output", type=Path, default=HERE / "RESULTS.md", help="default: benchmarks/RESULTS.md")
    options = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        machine = machine_description()
        c = C(folder) if shutil.which("gcc") else None
        if c is None:
            print("gcc is not installed: the comparison with C is left out", file=sys.stderr)
        rows = generated_code(c, options.rounds, options.quick)
    text = report(
        rows,
        tracing(options.rounds, options.quick),
        motion(options.rounds, options.quick),
        compiling(1 if options.quick else 3),
        cold_start(1 if options.quick else 5),
        machine,
    )
    print(text)
    wrong = [f"{row['name']}: {what}" for row in rows for what in row.get("differs", [])]
    if wrong:
        print("checksums differ from C; nothing written:\n" + "\n".join(wrong), file=sys.stderr)
        return 1
    options.output.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
