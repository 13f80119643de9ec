"""Motion programs in threads (iDEABOX 3, 10.2, 10.3): speed, interleaving, pages, arithmetic, return codes."""

import random
from pathlib import Path

import pytest

from mclib.motion_programs import files
from mclib.motion_programs.compiler import compile_motion
from plcruntime import PLC

CALLS = (
    "GT_Compile(ADR(name), ADR(info))", "GT_Download(ADR(name))", "GT_GetFunId(ADR(name), ADR(i))",
    "GT_GetVarId(ADR(owner), ADR(name), ADR(item))", "GT_GetVarId(0, ADR(name), ADR(item))", "GT_Bind(i, j, k)",
    "GT_RunThread(i)", "GT_StopThread(i)", "GT_PauseThread(i)", "GT_GetThreadSts(i, ADR(sts))",
    "GT_SetVarValue(k, ADR(item), ADR(r), j)", "GT_GetVarValue(k, ADR(item), ADR(r), j)",
    "GT_GetVarValue(k, ADR(item), ADR(d), j)", "GT_SetVarValue(k, ADR(item), ADR(d), j)", "GT_SetDataPage(i, j)",
    "GT_GetVarValue(k, ADR(item), ADR(few), j)", "GT_SetVarValue(k, ADR(item), ADR(few), j)",
    "GT_GetVarValue(k, ADR(item), ADR(pair), j)", "GT_GetVarValue(k, ADR(item), ADR(pair[0]), j)",
    "GT_GetVarValue(k, ADR(item), ADR(long), j)",
    "GT_Delay(10)", "GT_DelayHighPrecision(10)",
)  # fmt: skip
PROGRAM = f"""
PROGRAM PLC_PRG
VAR
    job, rtn, i, j, k : INT; name : STRING(200); owner : STRING(31); info : TCompileInfo; item : TVarInfo;
    sts : TThreadSts; r : ARRAY[0..7] OF LREAL; d : DINT; few : ARRAY[0..2] OF DINT;
    pair : ARRAY[0..1] OF LREAL; long : ARRAY[0..7] OF DINT;
    text, message : STRING(200); line : INT;
END_VAR
CASE job OF
{"".join(f"    {n}: rtn := {c};" + chr(10) for n, c in enumerate(CALLS, 1))}
    99: text := info.pFileName^; message := info.pMessage^; line := info.pLineNo^;
END_CASE
job := 0;
END_PROGRAM
"""


class Threads:
    def __init__(self, program: Path, folder: Path) -> None:
        self.program, self.folder = program, folder
        self.plc = PLC.load(program, interval="1ms")

    def __call__(self, call: str | int, **values) -> int:
        for name, value in values.items():
            if isinstance(value, list):
                value = value + self[name][len(value) :]
            self.plc[f"PLC_PRG.{name}"] = value
        self.plc["PLC_PRG.job"] = call if isinstance(call, int) else 1 + next(
            n for n, c in enumerate(CALLS) if c.startswith(call)
        )  # fmt: skip
        self.plc.scan()
        return self["rtn"]

    def __getitem__(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]

    def load(self, text: str) -> None:
        files.write(compile_motion(text), self.folder / "program.c")
        assert self("GT_Download", name="program.bin") == 0

    def start(self, function: str, thread: int = 0, page: int | None = None) -> None:
        assert self("GT_GetFunId", name=function) == 0
        assert self("GT_Bind", i=thread, j=self["i"], k=thread if page is None else page) == 0
        assert self("GT_RunThread", i=thread) == 0

    def status(self, thread: int = 0) -> dict:
        assert self("GT_GetThreadSts", i=thread) == 0
        return self["sts"]

    def value(self, name: str, owner: str = "", page: int = -1, count: int = 1):
        if owner:
            assert self("GT_GetVarId(ADR", name=name, owner=owner) == 0
        else:
            assert self("GT_GetVarId(0", name=name) == 0
        assert self("GT_GetVarValue(k, ADR(item), ADR(r)", k=page, j=count) == 0
        return self["r"][0] if count == 1 else self["r"][:count]

    def run(self, body: str, names: str, declarations: str) -> list[float]:
        """The values of global variables after the function main with this body."""
        self.load(f"{declarations}\nvoid main()\n{{\n{body}\n}}\n")
        self.start("main")
        for _ in range(100):
            if self.status()["run"] == 0:
                break
        return [self.value(n) for n in names.split()]


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """One file for all tests, in a folder where nothing changes: it is compiled once."""
    file = tmp_path_factory.mktemp("motion") / "main.st"
    file.write_text(PROGRAM, encoding="utf-8")
    return file


@pytest.fixture
def threads(program, tmp_path, monkeypatch):
    """The motion programs are in the working folder."""
    monkeypatch.chdir(tmp_path)
    return Threads(program, tmp_path)


LOOP = "int n;\nint count(int to)\n{\nint cc;\nloop:\nn = n + 1;\ncc = n < to;\nif(cc) goto loop;\nreturn n;\n}\n"


def test_100_commands_a_millisecond_shared_by_the_threads(threads):
    threads.load("int a, b; void fa() { loop: a = a + 1; goto loop; } void fb() { loop: b = b + 1; goto loop; }")
    threads.start("fa", 0)
    before = threads.plc["GtMotion.globals[0]"]
    threads.plc.scan(100)
    assert threads.plc["GtMotion.globals[0]"] - before == 100 * 100 / 2  # two commands a turn
    threads.start("fb", 7)
    before = threads.plc["GtMotion.globals"][:2]
    threads.plc.scan(100)
    after = threads.plc["GtMotion.globals"][:2]
    assert [y - x for x, y in zip(before, after, strict=True)] == [2500, 2500]


@pytest.mark.parametrize(("interval", "scans"), [("250us", 400), ("10ms", 10)])
def test_the_rate_does_not_depend_on_the_interval(threads, interval, scans):
    threads.plc = PLC.load(threads.program, interval=interval)
    threads.load("int a;\nvoid f()\n{\nloop:\na = a + 1;\ngoto loop;\n}")
    threads.start("f")
    before = threads.plc["GtMotion.globals[0]"]
    threads.plc.scan(scans)
    assert threads.plc["GtMotion.globals[0]"] - before == 5000


def test_one_function_in_many_threads_each_with_its_page(threads):
    threads.load("int f(int x)\n{\nint i;\nint cc;\nloop:\ni = i + x;\ncc = i < 1000;\nif(cc) goto loop;\nreturn i;\n}")
    assert threads("GT_GetFunId", name="f") == 0
    fun = threads["i"]
    assert threads("GT_GetVarId(ADR", name="x", owner="f") == 0
    for n in range(32):
        assert threads("GT_Bind", i=n, j=fun, k=31 - n) == 0
        assert threads("GT_SetVarValue(k, ADR(item), ADR(r)", k=31 - n, j=1, r=[float(n + 1)]) == 0
    for n in range(32):
        assert threads("GT_RunThread", i=n) == 0
    threads.plc.scan(300)
    for n in range(32):
        assert threads.status(n)["run"] == 0 and threads.status(n)["result"] == -(-1000 // (n + 1)) * (n + 1)


def test_pause_stop_and_start_again(threads):
    threads.load(LOOP)
    threads.start("count")
    assert threads("GT_GetVarId(ADR", name="to", owner="count") == 0
    assert threads("GT_SetVarValue(k, ADR(item), ADR(d)", k=0, j=1, d=100000) == 0
    assert threads("GT_RunThread", i=0) == 0  # its first run was over at once, 'to' was 0
    threads.plc.scan(5)
    assert threads("GT_PauseThread", i=0) == 0 and threads.status()["run"] == 2
    n = threads.value("n")
    threads.plc.scan(5)
    assert threads.value("n") == n
    assert threads("GT_RunThread", i=0) == 0 and threads.status()["run"] == 1
    assert threads("GT_RunThread", i=0) == 1 and threads("GT_Bind", i=0, j=0, k=0) == 1
    assert threads("GT_StopThread", i=0) == 0 and threads.status()["run"] == 0
    assert threads("GT_PauseThread", i=0) == 1
    assert threads.value("n") > n


def test_int_arithmetic_is_that_of_c(threads):
    rng = random.Random(3)
    values = [0, 1, -1, 7, -7, 65536, 2**31 - 1, -(2**31), *(rng.randrange(-(2**31), 2**31) for _ in range(4))]
    signs = "+ - * / % && || > < == >= <= != & | ^ << >>".split()
    pairs = [(a, b, s) for a in values for b in values for s in signs if b or s not in "/ %".split()]
    pairs = [(a, b % 32 if s in ("<<", ">>") else b, s) for a, b, s in rng.sample(pairs, 150)]

    def c(a, b, s):
        if s in ("/", "%"):
            q = abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)
            x = q if s == "/" else a - b * q
        elif s in ("&&", "||"):
            x = int(bool(a) and bool(b)) if s == "&&" else int(bool(a) or bool(b))
        else:
            x = int(eval(f"({a}) {s} ({b})"))
        return (x + 2**31) % 2**32 - 2**31

    for start in range(0, 150, 50):
        part = pairs[start : start + 50]
        body = "\n".join(f"x = {a}; y = {b}; r[{n}] = x {s} y;" for n, (a, b, s) in enumerate(part))
        threads.run(body, "", "int x, y, r[50];")
        seen = threads.plc["GtMotion.globals"][2:52]
        for (a, b, s), x in zip(part, seen, strict=True):
            assert x == c(a, b, s), f"{a} {s} {b}"


def test_double_is_fixed_point(threads):
    rng = random.Random(4)
    pairs = [(rng.uniform(-100, 100), rng.uniform(-100, 100)) for _ in range(12)]
    pairs += [(1e6, 1e-2), (30000.5, -30000.25), (-0.0000152587890625, 0.5)]
    for start in range(0, 15, 5):
        part = pairs[start : start + 5]
        body = "".join(
            f"x = {a:.6f}; y = {b:.6f}; r[{4 * n}] = x + y; r[{4 * n + 1}] = x - y; r[{4 * n + 2}] = x * y;"
            f" r[{4 * n + 3}] = x / y;\n"
            for n, (a, b) in enumerate(part)
        )
        threads.run(body, "", "double x, y, r[20];")
        seen = [v / 65536 for v in threads.plc["GtMotion.globals"][2:22]]
        for n, (a, b) in enumerate(part):
            a, b = round(float(f"{a:.6f}") * 65536) / 65536, round(float(f"{b:.6f}") * 65536) / 65536
            assert seen[4 * n : 4 * n + 2] == [a + b, a - b]
            assert seen[4 * n + 2] == pytest.approx(a * b, abs=1 / 65536)
            assert seen[4 * n + 3] == pytest.approx(a / b, abs=1 / 65536)


def test_casts_unary_and_arrays(threads):
    body = """d = -2.75; i = (int)d; e = (double)i; e = e - d; j = !i; k = ~i; i = -i;
n = 2; a[n] = 42; n = n + 1; a[n] = 43; n = n - 1; m = a[n]; d = -d;"""
    names, declarations = "i e j k m d", "int i, j, k, m, n, a[4]; double d, e;"
    assert threads.run(body, names, declarations) == [2.0, 0.75, 0.0, 1.0, 42.0, 2.75]
    assert threads.value("a", count=4) == [0.0, 0.0, 42.0, 43.0]


@pytest.mark.parametrize("body", ["n = 4; a[n] = 1;", "n = -1; m = a[n];", "m = m / n;", "m = m % n;", "d = d / d;"])
def test_a_mistake_at_run_time_ends_the_thread(threads, body):
    threads.run(body + " m = 77;", "m", "int m, n, a[4]; double d;")
    assert threads.status()["error"] == 1 and threads.status()["run"] == 0 and threads.value("m") == 0.0
    assert "thread stopped" in threads.plc["SIM.refused"][0]["why"]


def test_a_motion_program_moves_an_axis(threads):
    body = """
GT_AxisOn(2); GT_PrfTrap(2);
prm[0] = 0.5; prm[1] = 0.25;
GT_SetTrapPrm(2, prm);
GT_GetTrapPrm(2, back);
GT_SetPos(2, 5000); vel = 20.0; GT_SetVel(2, vel); rtn = GT_Update(2);
wait: GT_GetSts(2, &sts, 1, &clock); cc = sts & 0x400; if(cc) goto wait;
GT_GetPrfPos(2, &pos, 1, &clock);
bad = GT_AxisOn(13);
GT_Delay(20); GT_GetClock(&later, &loops); later = later - clock;
GT_SetDo(12, 5); GT_GetDo(12, &outputs);
"""
    names = "int sts, clock, cc, rtn, bad, later, loops, outputs; double pos, vel, prm[4], back[4];"
    threads.load(names + "\nvoid main()\n{" + body + "}")
    threads.start("main")
    threads.plc.scan(500)
    assert [threads.value(n) for n in ("pos", "rtn", "bad", "outputs")] == [5000.0, 0.0, 7.0, 5.0]
    assert threads.value("back", count=4) == [0.5, 0.25, 0.0, 0.0]
    assert threads.plc.axes[2].position == 5000.0 and threads.value("later") == 20.0
    assert threads.status()["run"] == 0 and threads.status()["error"] == 0


def test_compile_reports_the_first_error(threads):
    (threads.folder / "bad.c").write_text("int i;\nvoid f()\n{\n i = j;\n}\n")
    assert threads("GT_Compile", name="bad.c") == 1
    threads(99)
    assert threads["line"] == 4 and "j is not declared" in threads["message"] and threads["text"].endswith("bad.c")
    assert not (threads.folder / "bad.bin").exists() and threads("GT_Download", name="bad.bin") == 2007
    (threads.folder / "bad.c").write_text("int i;\nvoid f()\n{\n i = 1;\n}\n")
    assert threads("GT_Compile", name="bad.c") == 0
    threads(99)
    assert threads["line"] == 0 and threads["message"] == ""
    assert threads("GT_Download", name="bad.bin") == 0
    assert threads("GT_Compile", name="nothing.c") == 1


def test_return_codes(threads):
    assert threads("GT_GetFunId", name="f") == 1 and threads("GT_GetVarId(0", name="n") == 1
    assert threads("GT_GetVarValue(k, ADR(item), ADR(r)", k=-1, j=1) == 1
    assert threads("GT_Bind", i=0, j=0, k=0) == 7
    assert threads("GT_Download", name="x" * 126) == 2007 and threads("GT_Download", name="none.bin") == 2007
    (threads.folder / "junk.bin").write_bytes(b"junk")
    assert threads("GT_Download", name="junk.bin") == 2008
    (threads.folder / "many.c").write_text("".join(f"void f{n}() {{ }}\n" for n in range(33)))
    assert threads("GT_Compile", name="many.c") == 0 and threads("GT_Download", name="many.bin") == 7
    threads.load(LOOP)
    for call in ("GT_RunThread", "GT_StopThread", "GT_PauseThread"):
        assert threads(call, i=0) == 1 and threads(call, i=32) == 7 and threads(call, i=-1) == 7
    assert threads("GT_GetThreadSts", i=32) == 7
    assert threads("GT_GetFunId", name="other") == 1 and threads("GT_GetVarId(0", name="to") == 1
    assert threads("GT_GetVarId(ADR", name="to", owner="other") == 1
    assert threads("GT_GetVarId(ADR", name="to", owner="count") == 0
    for bad in ({"k": -2, "j": 1}, {"k": 32, "j": 1}, {"k": 0, "j": 0}, {"k": 0, "j": 9}):
        assert threads("GT_GetVarValue(k, ADR(item), ADR(r)", **bad) == 7
    assert threads("GT_Bind", i=0, j=0, k=32) == 7 and threads("GT_Bind", i=0, j=1, k=0) == 7
    assert threads("GT_Bind", i=0, j=0, k=5) == 0 and threads("GT_Bind", i=1, j=0, k=5) == 1
    assert threads("GT_SetDataPage", i=0, j=6) == 0 and threads("GT_Bind", i=1, j=0, k=5) == 0
    assert threads("GT_SetDataPage", i=0, j=5) == 1 and threads("GT_SetDataPage", i=0, j=32) == 7
    assert threads("GT_Delay(") == 1 and threads("GT_DelayHighPrecision") == 1


def test_values_stay_in_the_array_that_the_pointer_leads_to(threads):
    assert threads.run("a = 1; b = 2; c = 3; d = 4;", "a b c d", "int a, b, c, d;") == [1, 2, 3, 4]
    assert threads("GT_GetVarId(0", name="a") == 0
    assert threads("GT_GetVarValue(k, ADR(item), ADR(few)", k=-1, j=4) == 7 and threads["few"] == [0, 0, 0]
    assert threads("GT_GetVarValue(k, ADR(item), ADR(few)", k=-1, j=3) == 0 and threads["few"] == [1, 2, 3]
    assert threads("GT_SetVarValue(k, ADR(item), ADR(few)", k=-1, j=4, few=[7, 8, 9]) == 7
    assert threads("GT_GetVarValue(k, ADR(item), ADR(r)", k=-1, j=4) == 0 and threads["r"][:4] == [1, 2, 3, 4]
    for pointer in ("pair)", "pair[0])"):  # eight bytes a value (13 commands 76, 126: double)
        assert threads(f"GT_GetVarValue(k, ADR(item), ADR({pointer}", k=-1, j=3) == 7 and threads["pair"] == [0, 0]
    assert threads("GT_GetVarValue(k, ADR(item), ADR(pair)", k=-1, j=2) == 0 and threads["pair"] == [1, 2]


def test_six_values_a_call_eight_where_they_are_dint(threads):
    """13 commands 76, 126: count 1..6; the advanced manual, whose values are long: 1..8."""
    threads.run("a[7] = 8;", "a", "int a[8];")
    assert threads("GT_GetVarValue(k, ADR(item), ADR(r)", k=-1, j=6) == 0
    assert threads("GT_GetVarValue(k, ADR(item), ADR(r)", k=-1, j=7) == 7
    assert threads("GT_GetVarValue(k, ADR(item), ADR(long)", k=-1, j=8) == 0 and threads["long"][7] == 8
    assert threads("GT_GetVarValue(k, ADR(item), ADR(long)", k=-1, j=9) == 7


def test_a_program_is_lost_at_power_off(threads):
    threads.load(LOOP)
    threads.plc.power_cycle()
    assert threads("GT_GetFunId", name="count") == 1
