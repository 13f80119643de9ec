"""One axis under every block, its inputs set from Python; after every scan the rules that always hold are checked.

Every PLC that a test of this folder or one below it loads is watched besides (`Watch`).
"""

import numpy as np
import pytest
from waiting import VARIABLE, wait

from plcruntime import PLC
from stcore import paths

PROGRAM = """
PROGRAM PLC_PRG
VAR
    ax : AXIS_REF_SM3;
    power : MC_Power; absolute, second : MC_MoveAbsolute; relative : MC_MoveRelative; additive : MC_MoveAdditive;
    velocity : MC_MoveVelocity; halt : MC_Halt; stop, stop2 : MC_Stop; reset : MC_Reset; jog : MC_Jog; inch : SMC_Inch;
    status : MC_ReadStatus; fault : MC_ReadAxisError; setpos : MC_SetPosition;
    """ + VARIABLE + """
    rtn : INT; gt : BYTE; prfPos, prfVel : LREAL; sts : DWORD; trap : TTrapPrm; jogPrm : TJogPrm;
END_VAR
CASE gt OF
    1: rtn := GT_PrfTrap(1);
       trap.acc := 1; trap.dec := 1; trap.smoothTime := 0;
       rtn := GT_SetTrapPrm(1, ADR(trap)); rtn := GT_SetPos(1, 1000); rtn := GT_SetVel(1, 10); rtn := GT_Update(1);
    2: rtn := GT_Update(1);
    3: rtn := GT_Stop(1, 0);
    4: rtn := GT_AxisOn(1);
    5: rtn := GT_ClrSts(1, 1);
    6: rtn := GT_Stop(1, 1);
    7: rtn := GT_AxisOff(1);
    8: rtn := GT_PrfJog(1); jogPrm.acc := 1; jogPrm.dec := 1;
       rtn := GT_SetJogPrm(1, ADR(jogPrm)); rtn := GT_SetVel(1, 5); rtn := GT_Update(1);
END_CASE
gt := 0;
power(Axis := ax); absolute(Axis := ax); second(Axis := ax); relative(Axis := ax); additive(Axis := ax);
velocity(Axis := ax); halt(Axis := ax); stop(Axis := ax); stop2(Axis := ax); reset(Axis := ax); jog(Axis := ax);
inch(Axis := ax); setpos(Axis := ax); status(Axis := ax, Enable := TRUE); fault(Axis := ax, Enable := TRUE);
GT_GetPrfPos(1, ADR(prfPos)); GT_GetPrfVel(1, ADR(prfVel)); GT_GetSts(1, ADR(sts));
END_PROGRAM
"""
EDGE = ("absolute", "second", "relative", "additive", "halt", "stop", "stop2", "reset", "velocity")
MOTION = ("absolute", "second", "relative", "additive", "halt", "stop", "stop2", "velocity", "jog", "inch")
ENDS = ("Done", "Busy", "Error", "CommandAborted")
RULED = (*ENDS, "Execute", "InVelocity", "ErrorID", "order.result")
STATES = (
    "Disabled", "Errorstop", "Stopping", "StandStill", "DiscreteMotion", "ContinuousMotion", "SynchronizedMotion",
    "Homing",
)  # fmt: skip


class Bench:
    """A PLC with one axis. Units are pulses: the axis is unscaled unless a test says otherwise."""

    def __init__(self) -> None:
        self.plc = PLC.load(PROGRAM)
        self.continuous = True  # position and velocity may not jump
        self._rough: list[tuple[int, int]] = []  # scans in which they may
        columns = [f"PLC_PRG.{n}.{m}" for n in MOTION for m in RULED if m.split(".")[0] in self[n]]
        self._trace = self.plc.trace(*columns, *(f"SIM.Axis[1].{m}" for m in AXIS))

    def __getitem__(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]

    def __setitem__(self, name: str, value) -> None:
        self.plc[f"PLC_PRG.{name}"] = value

    @property
    def state(self) -> str:
        names = [n for n in STATES if self[f"status.{n}"]]
        assert len(names) == 1, names
        return names[0]

    def scan(self, count: int = 1) -> None:
        self._run(lambda: self.plc.scan(count))

    def until(self, name: str, most: int = 20000) -> int:
        return self._run(lambda: wait(self.plc, f"PLC_PRG.{name}", most))

    def _run(self, run):
        before = self.plc.scans
        try:
            return run()
        finally:
            if not self.continuous:
                self._rough.append((before, self.plc.scans))

    def start(self, block: str, **inputs) -> None:
        """Set a block's inputs and its Execute, and scan once."""
        for name, value in inputs.items():
            self[f"{block}.{name}"] = value
        self[f"{block}.Execute"] = True
        self.scan()

    def power(self) -> None:
        for name in ("Enable", "bRegulatorOn", "bDriveStart"):
            self[f"power.{name}"] = True
        self.until("power.Status")
        self.scan()

    def check(self) -> None:
        """The rules, in every scan."""
        if not len(self._trace):
            return
        rows, owners = Rows(self._trace), 0
        for name in MOTION:
            get = {m: rows[f"PLC_PRG.{name}.{m}"] for m in RULED if m.split(".")[0] in self[name]}
            outputs = sum(get[m].astype(int) for m in ENDS if m in get)
            assert not (outputs > 1).any(), f"{name}: two outputs"
            if name in EDGE:
                silent = get["Execute"] & (outputs == 0) & ~get.get("InVelocity", np.False_)
                assert not silent.any(), f"{name}: Execute and no output"
            assert not (get["Error"] != (get["ErrorID"] != 0)).any(), name
            # a block that was called before the one that took the axis learns of it in the next scan
            owners = owners + (get["Busy"] & (get["order.result"] == 0))
        assert not (owners > 1).any(), "two blocks own the axis"
        position, velocity = rows["SIM.Axis[1].prfPos"], rows["SIM.Axis[1].prfVel"]
        jumps = np.abs(np.diff(position) - (velocity[1:] + velocity[:-1]) / 2) >= 2.6
        for first, last in self._rough:
            jumps[max(first - 1, 0) : last - 1] = False
        assert not jumps.any(), "the position jumped"


@pytest.fixture
def bench():
    made = Bench()
    yield made
    made.check()


MEMBERS = ("Execute", *ENDS, "ErrorID", "Active", "order.result", "link.order.result")
AXIS = ("prfPos", "shifted", "prfVel", "prfAcc", "drive.enabled", "state")
HOMING = 7
FEW = 50  # rows
TYPES = {"ErrorID": "<i2", "result": "<i2", "state": "<i2"} | dict.fromkeys(AXIS[:4], "<f8")  # the others are BOOL


_LAST: list = []  # the last programs and what is watched of them: many tests share one


def to_watch(program) -> tuple[dict[str, list[str]], range, dict[str, paths.Place]]:
    """Blocks with the members that they have, numbers of the axes, the places of both."""
    for known, found in _LAST:
        if known is program:
            return found
    small, _ = paths.small_places(program, 64)
    names = {place.name.upper(): place.name for place in small}
    blocks = {}
    for upper, name in names.items():
        prefix = name.rpartition(".")[0]
        if upper.endswith(".BUSY") and f"{prefix}.ErrorID".upper() in names and not name.startswith("SIM."):
            blocks[prefix] = [m for m in MEMBERS if f"{prefix}.{m}".upper() in names]
    axes = range(1, 1 + sum(upper.endswith(".WAXISSTRUCTID") for upper in names))
    columns = [f"{prefix}.{m}" for prefix, members in blocks.items() for m in members]
    columns += [f"SIM.Axis[{n}].{m}" for n in axes for m in AXIS]
    found = blocks, axes, {c: paths.resolve(program, c) for c in columns} if blocks else {}
    _LAST.insert(0, (program, found))
    del _LAST[4:]
    return found


class Watch:
    """A trace of a PLC's motion blocks and axes; check() says what is against the rules."""

    def __init__(self, plc) -> None:
        self.plc = plc
        self.blocks, self.axes, columns = to_watch(plc.program)
        plc._places.update(columns)  # resolved once for all tests of a program
        self.trace = plc.trace(*columns) if self.blocks else None

    def check(self) -> list[str]:
        if self.trace is None or not len(self.trace):
            return []
        self.rows = Rows(self.trace)
        # a scan follows the one before: not after a restart, a step back or a restored snapshot
        self.follows = np.concatenate([np.arange(s.rows) > 0 for s in self.trace.segments if s.rows])
        found = [wrong for name, members in self.blocks.items() for wrong in self._outputs(name, members)]
        return found + [wrong for n in self.axes for wrong in self._motion(n)]

    def _outputs(self, name: str, members: list[str]):
        """At most one of Done, Busy, Error, CommandAborted; an error has a number; what is Active is Busy."""
        get = {m: self.rows[f"{name}.{m}"] for m in members}
        ends = [m for m in ENDS if m in get]
        if "Execute" in get:  # a block with Enable may be Busy with an error that ends by itself
            yield from self._never(sum(get[m].astype(int) for m in ends) > 1, f"{name}: more than one of {ends}")
        yield from self._never(get["Error"] != (get["ErrorID"] != 0), f"{name}: Error and ErrorID")
        if "Active" in get and "Done" in get:
            # MC_Stop is Active and Done while it holds the axis
            yield from self._never(get["Active"] & ~(get["Busy"] | get["Done"]), f"{name}: Active, but not Busy")
        if {"Execute", "Done", "CommandAborted"} <= get.keys():
            rose = np.concatenate(([False], get["Execute"][1:] & ~get["Execute"][:-1])) & self.follows
            said = sum(get[m].astype(int) for m in ends) == 1
            # in the scan of the edge or, where the program has called the block before it set Execute, in the next
            late = np.concatenate((said[1:], [True]))
            yield from self._never(rose & ~said & ~late, f"{name}: Execute has risen and no output is TRUE")

    def _motion(self, n: int):
        """The planned position goes on from where it was, by what the planned velocity says, but for what was set."""
        get = {m: self.rows[f"SIM.Axis[{n}].{m}"] for m in AXIS}
        way = np.diff(get["prfPos"] - get["shifted"])
        v, a = get["prfVel"], np.abs(get["prfAcc"])
        dt = self.plc.interval * 1000
        low, high = np.minimum(v[1:], v[:-1]) * dt, np.maximum(v[1:], v[:-1]) * dt
        # the velocity may have its peak within the scan; prfAcc knows nothing of a phase that is shifted meanwhile
        slack = np.maximum(a[1:], a[:-1]) * dt * dt + (high - low) + 0.005
        jumped = (way < low - slack) | (way > high + slack)
        on = get["drive.enabled"]
        calm = on[1:] & on[:-1] & (get["state"][1:] != HOMING) & (get["state"][:-1] != HOMING) & self.follows[1:]
        yield from self._never(np.concatenate(([False], jumped & calm)), f"axis {n}: its position jumped")

    def _never(self, rows, what: str):
        if rows.any():
            yield f"{what} (first in row {int(np.flatnonzero(rows)[0])} of {len(rows)})"


class Rows:
    """The columns of a trace, quick where each scan was a call of its own: those rows are stacked once."""

    def __init__(self, trace) -> None:
        self.index = {name.upper(): i for i, name in enumerate(trace.names)}
        self.parts = []  # a stack of rows with their offsets, or a segment of many rows
        for segment in (s for s in trace.segments if s.rows):
            if segment.rows > FEW:
                self.parts.append(segment)
                continue
            images = [np.frombuffer(bytes(i), np.uint8) for i in segment.images()]
            last = self.parts[-1] if self.parts else None
            if isinstance(last, tuple) and last[0] == segment.offsets:
                last[1].extend(images)
            else:
                self.parts.append((segment.offsets, images))
        self.parts = [(p[0], np.stack(p[1])) if isinstance(p, tuple) else p for p in self.parts]

    def __getitem__(self, name: str):
        i, dtype = self.index[name.upper()], np.dtype(TYPES.get(name.rpartition(".")[2], "?"))
        columns = []
        for part in self.parts:
            if isinstance(part, tuple):
                bytes_ = part[1][:, part[0][i] : part[0][i] + dtype.itemsize]
                columns.append(np.ascontiguousarray(bytes_).view(dtype)[:, 0])
            else:
                columns.append(part.column(i, dtype))
        return np.concatenate(columns)


@pytest.fixture(autouse=True)
def rules(monkeypatch):
    """Every PLC that a test loads is watched: the rules of Watch hold in every scan."""
    watched, load = [], PLC.load.__func__

    def watching(cls, *arguments, **options):
        plc = load(cls, *arguments, **options)
        watched.append(Watch(plc))
        return plc

    monkeypatch.setattr(PLC, "load", classmethod(watching))
    yield
    assert not [wrong for watch in watched for wrong in watch.check()]
