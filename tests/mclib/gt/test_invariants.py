"""Thousands of random commands, every scan looked at inside the module.

Speed and acceleration (and jerk) are never over their limits, the position is the integral of the velocity, no jump."""

import pytest

from plcruntime import PLC

RANDOM = """
FUNCTION Random : LREAL (* evenly between low and high *)
VAR_IN_OUT seed : DWORD; END_VAR
VAR_INPUT low, high : LREAL; END_VAR
seed := seed * 1664525 + 1013904223;
Random := low + (high - low) * DWORD_TO_LREAL(SHR(seed, 8)) / 16777216.0;
END_FUNCTION
FUNCTION Count : DINT (* from 0 up to below 'many' *)
VAR_IN_OUT seed : DWORD; END_VAR
VAR_INPUT many : DINT; END_VAR
Count := MIN(many - 1, TRUNC(Random(seed, 0.0, DINT_TO_LREAL(many))));
END_FUNCTION
FUNCTION Check : BOOL (* the first thing that does not hold is kept *)
VAR_INPUT holds : BOOL; what : STRING; axis : INT; seen, most : LREAL; END_VAR
Found.checks := Found.checks + 1;
IF NOT holds AND Found.wrong = 0 THEN
    Found.what := what; Found.axis := axis; Found.scan := __SCAN(); Found.seen := seen; Found.most := most;
END_IF
IF NOT holds THEN Found.wrong := Found.wrong + 1; END_IF
END_FUNCTION
"""
FOUND = """
{attribute 'qualified_only'}
VAR_GLOBAL
    wrong, checks : DINT; what : STRING; axis : INT; scan : LINT; seen, most : LREAL;
END_VAR
"""


@pytest.fixture
def run(tmp_path):
    """Load a program, run it, and see that everything held in every scan."""

    def load(text: str, scans: int, **values) -> PLC:
        (tmp_path / "Found.st").write_text(FOUND)
        (tmp_path / "main.st").write_text(RANDOM + text)
        plc = PLC.load(tmp_path / "main.st", interval="1ms")
        for name, value in values.items():
            plc[f"PLC_PRG.{name}"] = value
        plc.scan(scans)
        found = {n: plc[f"Found.{n}"] for n in ("wrong", "what", "axis", "scan", "seen", "most")}
        assert found["wrong"] == 0, found
        assert plc["Found.checks"] > scans
        return plc

    return load


TRAP_AND_JOG = """
TYPE Watched : STRUCT
    p, v, a : LREAL;        (* a scan ago *)
    moving, stopped : BOOL; (* stopped: GT_Stop has ended what GT_Update began *)
    fresh : BOOL;           (* velStart: the velocity may jump in the next scan *)
    acc, most, jerk : LREAL;   (* bounds of acceleration, speed; jerk 0: none *)
END_STRUCT END_TYPE
FUNCTION Lower : LREAL (* of acceleration and deceleration, where 0 is as the acceleration *)
VAR_INPUT acc, dec : LREAL; END_VAR
Lower := SEL(dec > 0.0, acc, MIN(acc, dec));
END_FUNCTION
PROGRAM PLC_PRG
VAR
    seed : DWORD := 1; first : BOOL := TRUE; i, choice : INT; w : ARRAY[1..12] OF Watched;
    trap : TTrapPrm; jog : TJogPrm; rtn, mode : INT; p, v, a, vel, slow : LREAL; target : DINT;
    updates, changes, stops, arrivals, modes : DINT;
END_VAR
IF first THEN
    first := FALSE;
    FOR i := 1 TO 12 DO
        GT_AxisOn(i);
        GT_SetStopDec(i, Random(seed, 0.5, 2.0), Random(seed, 5.0, 20.0));
    END_FOR
END_IF
FOR i := 1 TO 12 DO
    (* what the last scan has brought *)
    p := SIM.Axis[i].prfPos; v := SIM.Axis[i].prfVel; a := SIM.Axis[i].prfAcc;
    IF w[i].fresh THEN
        w[i].fresh := FALSE;
    ELSE
        Check(ABS(v - w[i].v) <= w[i].acc + 1E-9, 'the velocity jumps', i, v - w[i].v, w[i].acc);
        Check(ABS(p - w[i].p - (v + w[i].v) / 2) <= w[i].acc / 4 + 1E-9, 'the position is no integral', i,
            p - w[i].p - (v + w[i].v) / 2, w[i].acc / 4);
        IF w[i].jerk > 0.0 AND NOT w[i].stopped THEN
            Check(ABS(a - w[i].a) <= w[i].jerk * 1.000001 + 1E-9, 'jerk', i, a - w[i].a, w[i].jerk);
        END_IF
    END_IF
    Check(ABS(v) <= w[i].most + 1E-9, 'speed', i, v, w[i].most);
    Check(ABS(a) <= w[i].acc + 1E-9, 'acceleration', i, a, w[i].acc);
    IF NOT SIM.Axis[i].moving THEN
        Check(v = 0.0 AND a = 0.0, 'not at rest', i, v, 0.0);
        IF w[i].moving AND NOT w[i].stopped THEN
            arrivals := arrivals + 1;
            IF SIM.Axis[i].mode = 0 THEN
                Check(p = SIM.Axis[i].target, 'not at the target', i, p, DINT_TO_LREAL(SIM.Axis[i].target));
            END_IF
        END_IF
        w[i].stopped := FALSE;
    END_IF
    w[i].p := p; w[i].v := v; w[i].a := a; w[i].moving := SIM.Axis[i].moving;
    (* and now and then a command *)
    IF Count(seed, 30) = 0 THEN
        choice := DINT_TO_INT(Count(seed, 20));
        IF choice < 3 THEN
            GT_Stop(SHL(DWORD#1, i - 1), 0);
        ELSIF choice = 3 THEN
            GT_Stop(SHL(DWORD#1, i - 1), SHL(DWORD#1, i - 1));
        END_IF
        IF choice < 4 AND w[i].moving THEN
            stops := stops + 1;
            w[i].stopped := TRUE;
            w[i].acc := MAX(w[i].acc, SEL(choice = 3, SIM.Axis[i].decSmooth, SIM.Axis[i].decAbrupt));
        ELSIF choice >= 4 THEN
            IF NOT w[i].moving THEN
                mode := DINT_TO_INT(Count(seed, 2));
                modes := modes + 1;
                IF mode = 0 THEN
                    trap.acc := Random(seed, 0.05, 2.0);
                    trap.dec := SEL(Count(seed, 3) = 0, Random(seed, 0.05, 2.0), 0.0);
                    trap.smoothTime := DINT_TO_INT(Count(seed, 51));
                    trap.velStart := SEL(Count(seed, 5) = 0, 0.0, Random(seed, 0.0, 10.0));
                    rtn := GT_PrfTrap(i) + GT_SetTrapPrm(i, ADR(trap));
                ELSE
                    jog.acc := Random(seed, 0.05, 2.0);
                    jog.dec := SEL(Count(seed, 3) = 0, Random(seed, 0.05, 2.0), 0.0);
                    jog.smooth := SEL(Count(seed, 3) = 0, Random(seed, 0.01, 0.99), 0.0);
                    rtn := GT_PrfJog(i) + GT_SetJogPrm(i, ADR(jog));
                END_IF
            END_IF
            mode := DINT_TO_INT(SIM.Axis[i].mode);
            IF mode = 0 THEN
                IF Count(seed, 3) > 0 OR NOT w[i].moving THEN
                    target := LREAL_TO_DINT(p + Random(seed, -8000.0, 8000.0));
                    rtn := rtn + GT_SetPos(i, target);
                END_IF
                vel := Random(seed, 2.0, 100.0);
            ELSE
                vel := SEL(Count(seed, 5) = 0, Random(seed, -100.0, 100.0), 0.0);
            END_IF
            rtn := rtn + GT_SetVel(i, vel) + GT_Update(SHL(DWORD#1, i - 1));
            Check(rtn = 0, 'refused', i, INT_TO_LREAL(rtn), 0.0);
            updates := updates + 1;
            IF w[i].moving THEN changes := changes + 1; END_IF
            IF mode = 0 THEN
                w[i].acc := MAX(SIM.Axis[i].trap.acc, SIM.Axis[i].trap.dec, ABS(a));
                w[i].jerk := 0.0;
                IF SIM.Axis[i].trap.smoothTime > 0 THEN
                    w[i].jerk := MAX(SIM.Axis[i].trap.acc, SIM.Axis[i].trap.dec) / SIM.Axis[i].trap.smoothTime;
                END_IF
                w[i].fresh := NOT w[i].moving AND SIM.Axis[i].trap.velStart > 0.0;
            ELSE
                w[i].acc := MAX(SIM.Axis[i].jog.acc, SIM.Axis[i].jog.dec, ABS(a));
                w[i].jerk := 0.0;
            END_IF
            (* an acceleration needs its time to go; on the way the velocity changes on *)
            slow := 1E300;
            IF mode = 0 AND SIM.Axis[i].trap.smoothTime > 0 THEN
                slow := Lower(SIM.Axis[i].trap.acc, SIM.Axis[i].trap.dec) / SIM.Axis[i].trap.smoothTime;
            ELSIF mode = 1 AND SIM.Axis[i].jog.smooth > 0.0 THEN
                slow := Lower(SIM.Axis[i].jog.acc, SIM.Axis[i].jog.dec);
                slow := slow * slow / (SIM.Axis[i].jog.smooth * ABS(vel - v));
            END_IF
            w[i].most := MAX(ABS(vel), ABS(v), ABS(v + a * ABS(a) / (2 * slow)));
            w[i].stopped := FALSE;
        END_IF
    END_IF
END_FOR
END_PROGRAM
"""


@pytest.mark.parametrize("seed", [1, 2])
def test_trap_and_jog(run, seed):
    plc = run(TRAP_AND_JOG, 10000, seed=seed)
    done = {n: plc[f"PLC_PRG.{n}"] for n in ("updates", "changes", "stops", "arrivals", "modes")}
    assert done["updates"] > 2500 and done["changes"] > 1000 and done["stops"] > 300 and done["arrivals"] > 100, done


GEAR = """
TYPE Watched : STRUCT
    p, v, m, vm : LREAL;        (* slave and master a scan ago *)
    low, high, left : LREAL;    (* the ratio is between them; after this way of the master it is the last one *)
    goal, bend : LREAL;         (* that ratio; change of the ratio by a pulse of the master *)
END_STRUCT END_TYPE
PROGRAM PLC_PRG
VAR
    seed : DWORD := 1; first : BOOL := TRUE; i, k : INT; w : ARRAY[7..12] OF Watched; jog : TJogPrm;
    p, v, m, vm, d, bound : LREAL; rtn : INT; x, y, z : DINT; updates, ratios, clutches : DINT;
END_VAR
IF first THEN
    first := FALSE;
    FOR i := 1 TO 6 DO
        jog.acc := Random(seed, 0.2, 1.0);
        rtn := rtn + GT_AxisOn(i) + GT_PrfJog(i) + GT_SetJogPrm(i, ADR(jog));
        rtn := rtn + GT_AxisOn(i + 6) + GT_PrfGear(i + 6, 0) + GT_SetGearMaster(i + 6, i, GEAR_MASTER_PROFILE, 0)
            + GT_SetGearRatio(i + 6, 1, 1, 0) + GT_GearStart(SHL(DWORD#1, i + 5));
        w[i + 6].low := 1.0; w[i + 6].high := 1.0; w[i + 6].goal := 1.0;
    END_FOR
END_IF
FOR i := 7 TO 12 DO
    k := i - 6;
    p := SIM.Axis[i].prfPos; v := SIM.Axis[i].prfVel; m := SIM.Axis[k].prfPos; vm := SIM.Axis[k].prfVel;
    d := m - w[i].m;
    Check(p - w[i].p >= MIN(w[i].low * d, w[i].high * d) - 1E-7
        AND p - w[i].p <= MAX(w[i].low * d, w[i].high * d) + 1E-7, 'the way of the slave', i, p - w[i].p, d);
    Check(v >= MIN(w[i].low * vm, w[i].high * vm) - 1E-7 AND v <= MAX(w[i].low * vm, w[i].high * vm) + 1E-7,
        'the velocity of the slave', i, v, vm);
    bound := MAX(ABS(w[i].low), ABS(w[i].high)) * SIM.Axis[k].jog.acc + w[i].bend * MAX(vm * vm, w[i].vm * w[i].vm);
    Check(ABS(v - w[i].v) <= bound * 1.01 + 1E-7, 'the velocity jumps', i, v - w[i].v, bound);
    Check(ABS(p - w[i].p - (v + w[i].v) / 2) <= bound / 4 * 1.01 + 1E-7, 'the position is no integral', i,
        p - w[i].p - (v + w[i].v) / 2, bound / 4);
    w[i].left := w[i].left - ABS(d);
    IF w[i].left < -200.0 AND w[i].low < w[i].high THEN
        w[i].low := w[i].goal; w[i].high := w[i].goal; w[i].bend := 0.0; (* and from now on exactly *)
        clutches := clutches + 1;
    END_IF
    w[i].p := p; w[i].v := v; w[i].m := m; w[i].vm := vm;
    IF Count(seed, 25) = 0 THEN
        rtn := rtn + GT_SetVel(k, Random(seed, -50.0, 50.0)) + GT_Update(SHL(DWORD#1, k - 1));
        updates := updates + 1;
    END_IF
    IF Count(seed, 100) = 0 THEN
        x := Count(seed, 9) + 1; y := Count(seed, 41) - 20; z := Count(seed, 3000) + 300;
        rtn := rtn + GT_SetGearRatio(i, x, y, z) + GT_GearStart(SHL(DWORD#1, i - 1));
        w[i].goal := DINT_TO_LREAL(y) / DINT_TO_LREAL(x);
        w[i].low := MIN(w[i].low, w[i].goal); w[i].high := MAX(w[i].high, w[i].goal);
        w[i].left := DINT_TO_LREAL(z);
        w[i].bend := MAX(w[i].bend, (w[i].high - w[i].low) / DINT_TO_LREAL(z));
        ratios := ratios + 1;
    END_IF
    Check(rtn = 0, 'refused', i, INT_TO_LREAL(rtn), 0.0);
END_FOR
END_PROGRAM
"""


def test_gear(run):
    plc = run(GEAR, 20000)
    done = {n: plc[f"PLC_PRG.{n}"] for n in ("updates", "ratios", "clutches")}
    assert done["updates"] > 3000 and done["ratios"] > 800 and done["clutches"] > 300, done


PT = """
TYPE Point : STRUCT p, v : LREAL; t : DINT; END_STRUCT END_TYPE
TYPE Stream : STRUCT
    p, v : LREAL;                       (* a scan ago *)
    pos, vel : LREAL; time : DINT;      (* the last point that was pushed *)
    wait : ARRAY[0..127] OF Point;      (* points that are still to come *)
    head, tail : DINT;
    began : DINT;
END_STRUCT END_TYPE
PROGRAM PLC_PRG
VAR
    seed : DWORD := 1; first : BOOL := TRUE; i, space, rtn : INT; s : ARRAY[1..12] OF Stream; now, step, points : DINT;
    p, v, goal : LREAL;
END_VAR
FOR i := 1 TO 12 DO
    IF first THEN
        rtn := rtn + GT_AxisOn(i) + GT_PrfPt(i, PT_MODE_DYNAMIC);
    ELSE
        p := SIM.Axis[i].prfPos; v := SIM.Axis[i].prfVel;
        Check(ABS(p - s[i].p - (v + s[i].v) / 2) < 1E-6, 'the position is no integral', i, p - s[i].p,
            (v + s[i].v) / 2);
        Check(ABS(v - s[i].v) <= 40.0 + 1E-6, 'the velocity jumps', i, v, s[i].v);
        Check(ABS(v) <= 20.0 + 1E-6, 'speed', i, v, 20.0);
        s[i].p := p; s[i].v := v;
        IF s[i].head < s[i].tail AND_THEN s[i].wait[s[i].head MOD 128].t = now THEN
            Check(ABS(p - s[i].wait[s[i].head MOD 128].p) < 1E-6, 'the point', i, p, s[i].wait[s[i].head MOD 128].p);
            Check(ABS(v - s[i].wait[s[i].head MOD 128].v) < 1E-6, 'its velocity', i, v, s[i].wait[s[i].head MOD 128].v);
            s[i].head := s[i].head + 1;
            points := points + 1;
        END_IF
    END_IF
    rtn := rtn + GT_PtSpace(i, ADR(space));
    WHILE space > 0 AND rtn = 0 DO
        step := Count(seed, 30) + 1;
        goal := Random(seed, -20.0, 20.0);
        s[i].pos := s[i].pos + (s[i].vel + goal) / 2 * step;
        s[i].vel := goal;
        s[i].time := s[i].time + step;
        rtn := rtn + GT_PtData(i, s[i].pos, s[i].time, PT_SEGMENT_NORMAL);
        s[i].wait[s[i].tail MOD 128].p := s[i].pos;
        s[i].wait[s[i].tail MOD 128].v := goal;
        s[i].wait[s[i].tail MOD 128].t := s[i].time;
        s[i].tail := s[i].tail + 1;
        rtn := rtn + GT_PtSpace(i, ADR(space));
    END_WHILE
    Check(rtn = 0, 'refused', i, INT_TO_LREAL(rtn), 0.0);
END_FOR
IF first THEN
    first := FALSE;
    rtn := rtn + GT_PtStart(16#FFF, 0);
END_IF
now := now + 1;
END_PROGRAM
"""


def test_pt(run):
    plc = run(PT, 6000)
    assert plc["PLC_PRG.points"] > 4000


FOLLOW = """
TYPE Watched : STRUCT
    p, m, r : LREAL;    (* slave, master, ratio a scan ago *)
    fifo : INT;         (* that runs *)
    asked : BOOL;       (* the other one is filled and waits *)
END_STRUCT END_TYPE
FUNCTION Fill : INT (* a curve of NORMAL segments from ratio 'from' to 0.6, each 60 pulses long or more *)
VAR_IN_OUT seed : DWORD; END_VAR
VAR_INPUT axis, fifo : INT; from : LREAL; END_VAR
VAR n, k : DINT; x, step : DINT; y, r, goal : LREAL; kind : INT; END_VAR
n := Count(seed, 14) + 2;
r := from;
FOR k := 1 TO n DO
    step := 60 + Count(seed, 400);
    goal := SEL(k = n, Random(seed, -3.0, 3.0), 0.6);
    x := x + step;
    y := y + (r + goal) / 2 * step;
    r := goal;
    kind := SEL(k = 1 AND from > 0.0, FOLLOW_SEGMENT_NORMAL, FOLLOW_SEGMENT_CONTINUE);
    Fill := Fill + GT_FollowData(axis, x, y, kind, fifo);
END_FOR
END_FUNCTION
PROGRAM PLC_PRG
VAR
    seed : DWORD := 1; first : BOOL := TRUE; i, k, rtn, space : INT; w : ARRAY[7..12] OF Watched; jog : TJogPrm;
    p, m, r, d, bend : LREAL; updates, switches : DINT;
END_VAR
IF first THEN
    first := FALSE;
    FOR i := 7 TO 12 DO
        jog.acc := 1.0;
        rtn := rtn + GT_AxisOn(i - 6) + GT_PrfJog(i - 6) + GT_SetJogPrm(i - 6, ADR(jog)) + GT_SetVel(i - 6, 20.0)
            + GT_Update(SHL(DWORD#1, i - 7)) + GT_AxisOn(i) + GT_PrfFollow(i, 0)
            + GT_SetFollowMaster(i, i - 6, FOLLOW_MASTER_PROFILE, 0) + GT_SetFollowLoop(i, 0) + Fill(seed, i, 0, 0.0)
            + Fill(seed, i, 1, 0.6);
        rtn := rtn + GT_FollowStart(SHL(DWORD#1, i - 1), 0) + GT_FollowSwitch(SHL(DWORD#1, i - 1));
        w[i].asked := TRUE;
    END_FOR
END_IF
bend := 6.0 / 60.0; (* most that the ratio changes by a pulse *)
FOR i := 7 TO 12 DO
    k := i - 6;
    p := SIM.Axis[i].prfPos; m := SIM.Axis[k].prfPos; d := m - w[i].m;
    r := w[i].r;
    IF SIM.Axis[k].prfVel > 0.1 THEN
        r := SIM.Axis[i].prfVel / SIM.Axis[k].prfVel;
        Check(ABS(r) <= 3.0 + 1E-6, 'the ratio', i, r, 3.0);
        Check(ABS(r - w[i].r) <= bend * d + 1E-6, 'the ratio jumps', i, r - w[i].r, bend * d);
        Check(ABS(p - w[i].p - (r + w[i].r) / 2 * d) <= bend * d * d / 4 + 1E-6, 'the position is no integral', i,
            p - w[i].p - (r + w[i].r) / 2 * d, bend * d * d / 4);
    END_IF
    w[i].p := p; w[i].m := m; w[i].r := r;
    IF Count(seed, 25) = 0 THEN
        rtn := rtn + GT_SetVel(k, Random(seed, 2.0, 40.0)) + GT_Update(SHL(DWORD#1, k - 1));
        updates := updates + 1;
    END_IF
    IF w[i].asked THEN
        rtn := rtn + GT_FollowSpace(i, ADR(space), w[i].fifo);
        IF space = 16 THEN (* the old FIFO is emptied: the other one runs *)
            w[i].asked := FALSE;
            w[i].fifo := 1 - w[i].fifo;
            switches := switches + 1;
        END_IF
    ELSIF Count(seed, 50) = 0 THEN
        rtn := rtn + Fill(seed, i, 1 - w[i].fifo, 0.6) + GT_FollowSwitch(SHL(DWORD#1, i - 1));
        w[i].asked := TRUE;
    END_IF
    Check(rtn = 0, 'refused', i, INT_TO_LREAL(rtn), 0.0);
END_FOR
END_PROGRAM
"""


def test_follow(run):
    plc = run(FOLLOW, 30000)
    assert plc["PLC_PRG.updates"] > 5000 and plc["PLC_PRG.switches"] > 500
