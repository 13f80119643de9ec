"""The recorder beside a copy of the memory after every scan: what the module writes down is what was there."""

import pytest

from plcruntime import PLC, recorder

PROGRAM = """PROGRAM PLC_PRG
VAR
  always, other: LREAL; quiet: LREAL := 2.5; sometimes: DINT; blink: BOOL; sum: LINT; text: STRING(20) := 'a';
  rare: ARRAY[0..40] OF INT; still: ARRAY[0..8] OF LREAL; early: DINT; p: POINTER TO DINT; w: WORD;
END_VAR
always := always + 0.1;
other := always * always;
IF __SCAN() MOD 7 = 0 THEN sometimes := sometimes + 1; END_IF
IF __SCAN() MOD 16 < 9 THEN blink := NOT blink; sum := sum + 3; END_IF
rare[__SCAN() MOD 41] := LINT_TO_INT(__SCAN());
IF __SCAN() < 3 THEN early := early + 1; END_IF
IF __SCAN() = 33 THEN text := 'a longer text'; END_IF
p := SEL(__SCAN() MOD 20 > 10, ADR(sometimes), ADR(early));
w := LINT_TO_WORD(__SCAN());
END_PROGRAM
"""
NAMES = ["always", "other", "quiet", "sometimes", "blink", "sum", "text", "rare[3]", "rare[40]", "early", "w.2", "w"]


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    file = tmp_path_factory.mktemp("recorder") / "prog.st"
    file.write_text(PROGRAM)
    return str(file)


def read(plc, count):
    rows = []
    for _ in range(count):
        plc.scan()
        rows.append(tuple(plc[name] for name in NAMES))
    return rows


@pytest.mark.parametrize("scans", [1, 15, 16, 17, 32, 100])
def test_every_scan_as_the_memory_had_it(source, scans):
    want = read(PLC.load(source), scans)
    plc = PLC.load(source)
    trace = plc.trace(*NAMES)
    plc.scan(scans)
    assert [row[1:] for row in trace.rows()] == want
    assert list(zip(*(trace[name].tolist() for name in NAMES), strict=True)) == want


def test_all_variables_in_pieces_through_a_small_buffer(source, monkeypatch):
    want = read(PLC.load(source), 330)
    monkeypatch.setattr(recorder, "BUFFER", 64)
    plc = PLC.load(source)
    plc.scan(20)
    trace = plc.trace("*")
    for count in (1, 2, 15, 16, 17, 259):
        plc.scan(count)
    assert len(trace) == 310 and len(trace.segments) >= 6
    for i, name in enumerate(NAMES[:6]):
        assert trace[f"PLC_PRG.{name}"].tolist() == [row[i] for row in want[20:]], name


def test_what_does_not_change_takes_no_memory(source):
    plc = PLC.load(source)
    trace = plc.trace("still[4]")
    plc.scan(100_000)
    assert len(trace) == 100_000
    assert sum(len(s.chunk.values) + len(s.chunk.headers) for s in trace.segments) < 200


def test_rows_beyond_what_a_chunk_can_number(source):
    plc = PLC.load(source)
    trace = plc.trace("early")
    plc.scan(16 * recorder.MOST + 40)
    assert [s.rows for s in trace.segments] == [16 * recorder.MOST, 40]
    assert trace["early"][[0, 1, 2, 3, -1]].tolist() == [1, 2, 3, 3, 3]


def test_going_back_drops_the_rows_and_records_them_again(source):
    plc = PLC.load(source)
    trace = plc.trace("always", "sometimes")
    plc.scan(50)
    before = list(trace.rows())
    plc.back(21)
    assert list(trace.rows()) == before[:29]
    plc.scan(21)
    assert list(trace.rows()) == before


def test_large_traces_are_kept_in_arenas(source, monkeypatch):
    from plcruntime import rows

    monkeypatch.setattr(rows, "ARENA", 1 << 16)
    monkeypatch.setattr(rows, "LARGE", 1 << 10)
    monkeypatch.setattr(recorder, "BUFFER", 1 << 15)
    want = read(PLC.load(source), 3000)
    plc = PLC.load(source)
    trace = plc.trace(*NAMES)
    plc.scan(3000)
    assert [row[1:] for row in trace.rows()] == want
