"""The planner alone, over thousands of random moves: exact ends, no jumps, limits kept; as quick as ruckig where the
limits are symmetric."""

import math
import random

import pytest

from plcruntime import PLC

COUNT = 500
PROGRAM = f"""
TYPE Move : STRUCT
    acc, dec, jerkAcc, jerkDec, v0, a0, target, vEnd, vMax : LREAL;
    t, pos, vel, a, jumpP, jumpV, jumpA, vSeen, growSeen, shrinkSeen, jerkSeen : LREAL;
    n : DINT;
END_STRUCT END_TYPE
PROGRAM PLC_PRG
VAR
    m : ARRAY[1..{COUNT}] OF Move;
    plan : SimPlan;
    i, k, s : DINT;
    d, v, a, tEnd, p1, v1, a1 : LREAL;
END_VAR
FOR i := 1 TO {COUNT} DO
    plan.accMax := m[i].acc; plan.decMax := m[i].dec; plan.jerkAcc := m[i].jerkAcc; plan.jerkDec := m[i].jerkDec;
    plan.pos0 := 0; plan.vel0 := m[i].v0; plan.acc0 := m[i].a0;
    SimRewind(plan);
    SimPlanMove(plan, m[i].target, m[i].vEnd, m[i].vMax);
    m[i].t := plan.t; m[i].pos := plan.pos; m[i].vel := plan.vel; m[i].a := plan.acc; m[i].n := plan.n;
    m[i].jumpP := 0; m[i].jumpV := 0; m[i].jumpA := 0;
    m[i].vSeen := 0; m[i].growSeen := 0; m[i].shrinkSeen := 0; m[i].jerkSeen := 0;
    p1 := 0; v1 := m[i].v0; a1 := m[i].a0;
    FOR k := 0 TO plan.n - 1 DO
        m[i].jumpP := MAX(m[i].jumpP, ABS(plan.piece[k].pos - p1));
        m[i].jumpV := MAX(m[i].jumpV, ABS(plan.piece[k].vel - v1));
        m[i].jumpA := MAX(m[i].jumpA, ABS(plan.piece[k].acc - a1));
        m[i].jerkSeen := MAX(m[i].jerkSeen, ABS(plan.piece[k].jerk));
        tEnd := plan.t;
        IF k < plan.n - 1 THEN tEnd := plan.piece[k + 1].t; END_IF
        FOR s := 0 TO 8 DO
            d := (tEnd - plan.piece[k].t) * DINT_TO_LREAL(s) / 8.0;
            a := plan.piece[k].acc + d * plan.piece[k].jerk;
            v := plan.piece[k].vel + d * (plan.piece[k].acc + d * plan.piece[k].jerk / 2.0);
            m[i].vSeen := MAX(m[i].vSeen, ABS(v));
            IF ABS(v) > 1E-6 * m[i].vMax THEN
                IF a * v > 0 THEN m[i].growSeen := MAX(m[i].growSeen, ABS(a));
                ELSE m[i].shrinkSeen := MAX(m[i].shrinkSeen, ABS(a)); END_IF
            END_IF
        END_FOR
        p1 := plan.piece[k].pos
            + d * (plan.piece[k].vel + d * (plan.piece[k].acc / 2.0 + d * plan.piece[k].jerk / 6.0));
        v1 := v; a1 := a;
    END_FOR
END_FOR
END_PROGRAM
"""


@pytest.fixture(scope="module")
def planner():
    plc = PLC.load(PROGRAM)

    def plan(moves: list[dict]) -> list[dict]:
        done = []
        for at in range(0, len(moves), COUNT):
            part = moves[at : at + COUNT]
            plc["PLC_PRG.m"] = [*part, *([part[0]] * (COUNT - len(part)))]
            plc.scan()
            done += plc["PLC_PRG.m"][: len(part)]
        return done

    return plan


def move(acc, dec, j, v0=0.0, a0=0.0, target=0.0, v_end=0.0, v_max=1.0, j_dec=None):
    return {
        "acc": acc, "dec": dec, "jerkAcc": j, "jerkDec": j if j_dec is None else j_dec, "v0": v0, "a0": a0,
        "target": target, "vEnd": v_end, "vMax": v_max,
    }  # fmt: skip


def random_move(rng: random.Random, *, symmetric: bool, trapezoid: bool = False) -> dict:
    v_max, acc = 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-1, 1)
    dec = acc if symmetric else 10 ** rng.uniform(-1, 1)
    j = 0.0 if trapezoid else 10 ** rng.uniform(-1, 1.5)
    j_dec = j if symmetric or trapezoid else 10 ** rng.uniform(-1, 1.5)
    v0 = rng.uniform(-v_max, v_max) * rng.choice([0, 1, 1])
    room = math.sqrt(2 * min(j, j_dec) * (v_max - abs(v0)))
    a0 = 0.0 if trapezoid else rng.uniform(-1, 1) * min(acc, dec, room) * rng.choice([0, 1, 1])
    v_end = rng.uniform(-v_max, v_max) * rng.choice([0, 0, 1])
    target = rng.uniform(-1, 1) * 10 ** rng.uniform(-2, 2)
    return move(acc, dec, j, v0, a0, target, v_end, v_max, j_dec)


def check(m: dict) -> None:
    size = max(1.0, abs(m["target"]))
    assert abs(m["pos"] - m["target"]) < 1e-8 * size, m
    assert m["vel"] == pytest.approx(m["vEnd"], abs=1e-12) and m["a"] == 0.0, m
    assert m["n"] <= 18
    assert m["jumpP"] < 1e-8 * size and m["jumpV"] < 1e-8, m
    assert m["vSeen"] <= m["vMax"] * (1 + 1e-9), m
    assert m["growSeen"] <= m["acc"] * (1 + 1e-7) and m["shrinkSeen"] <= m["dec"] * (1 + 1e-7), m
    if m["jerkAcc"]:
        assert m["jumpA"] < 1e-6 * max(1.0, m["acc"], m["dec"]), m
        assert m["jerkSeen"] <= max(m["jerkAcc"], m["jerkDec"]) * (1 + 1e-12), m


@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize("trapezoid", [True, False])
def test_random_moves_end_exactly_and_keep_their_limits(planner, symmetric, trapezoid):
    rng = random.Random(4 + 2 * symmetric + trapezoid)
    for m in planner([random_move(rng, symmetric=symmetric, trapezoid=trapezoid) for _ in range(5000)]):
        check(m)


def test_as_quick_as_ruckig_where_the_limits_are_symmetric(planner):
    ruckig = pytest.importorskip("ruckig")
    rng = random.Random(7)
    otg = ruckig.Ruckig(1)
    for m in planner([random_move(rng, symmetric=True) for _ in range(5000)]):
        given = ruckig.InputParameter(1)
        given.current_position, given.current_velocity, given.current_acceleration = [0.0], [m["v0"]], [m["a0"]]
        given.target_position, given.target_velocity, given.target_acceleration = [m["target"]], [m["vEnd"]], [0.0]
        given.max_velocity, given.max_acceleration, given.max_jerk = [m["vMax"]], [m["acc"]], [m["jerkAcc"]]
        best = ruckig.Trajectory(1)
        otg.calculate(given, best)
        assert m["t"] == pytest.approx(best.duration, rel=1e-7, abs=1e-9), m


def test_trapezoid_durations_are_the_closed_form(planner):
    rng = random.Random(9)
    moves = []
    for _ in range(1000):
        acc, dec, v = (10 ** rng.uniform(-1, 1) for _ in range(3))
        moves.append(move(acc, dec, 0.0, target=10 ** rng.uniform(-2, 3), v_max=v))
    for m in planner(moves):
        ramps = m["vMax"] ** 2 / 2 * (1 / m["acc"] + 1 / m["dec"])
        if m["target"] >= ramps:
            t = m["vMax"] / m["acc"] + m["vMax"] / m["dec"] + (m["target"] - ramps) / m["vMax"]
        else:
            peak = math.sqrt(2 * m["target"] / (1 / m["acc"] + 1 / m["dec"]))
            t = peak / m["acc"] + peak / m["dec"]
        assert m["t"] == pytest.approx(t, rel=1e-9)


def test_an_axis_faster_than_the_new_limit_slows_down_and_still_ends_exactly(planner):
    rng = random.Random(11)
    moves = []
    for _ in range(1000):
        m = random_move(rng, symmetric=False)
        m["v0"] = m["vMax"] * rng.choice([-1, 1]) * rng.uniform(1, 3)
        moves.append(m)
    for m in planner(moves):
        assert abs(m["pos"] - m["target"]) < 1e-8 * max(1.0, abs(m["target"])), m
        assert m["jumpP"] < 1e-8 * max(1.0, abs(m["target"])) and m["jumpV"] < 1e-8, m


def test_no_distance_needs_no_time(planner):
    (m,) = planner([move(1.0, 1.0, 1.0)])
    assert (m["t"], m["n"], m["pos"]) == (0.0, 0, 0.0)


def test_overshoots_and_comes_back_when_the_target_is_too_near(planner):
    # braking from 1 with 1 takes 0.5: a target at 0.25 is passed and met on the way back
    (m,) = planner([move(1.0, 1.0, 0.0, v0=1.0, target=0.25, v_max=2.0)])
    check(m)
    assert m["t"] == pytest.approx(1.0 + 2 * math.sqrt(0.25))
