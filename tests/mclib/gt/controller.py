"""Axis 1 under GT_ commands. They are called from a PROGRAM whose variables are the arguments; job says which one is in
the next scan."""

from plcruntime import PLC

COMMANDS = {
    1: "GT_AxisOn(a)", 2: "GT_AxisOff(a)", 3: "GT_ClrSts(a, n)", 4: "GT_PrfTrap(a)", 5: "GT_PrfJog(a)",
    6: "GT_SetTrapPrm(a, ADR(trap))", 7: "GT_GetTrapPrm(a, ADR(trap))", 8: "GT_SetJogPrm(a, ADR(jog))",
    9: "GT_GetJogPrm(a, ADR(jog))", 10: "GT_SetPos(a, x)", 11: "GT_GetPos(a, ADR(x))", 12: "GT_SetVel(a, v)",
    13: "GT_GetVel(a, ADR(v))", 14: "GT_Update(x)", 15: "GT_Stop(x, y)", 16: "GT_SetPrfPos(a, x)",
    17: "GT_ZeroPos(a, n)", 18: "GT_GetPrfPos(a, ADR(values), n, ADR(clock))", 19: "GT_GetSts(a, ADR(words), n)",
    20: "GT_SetSoftLimit(a, x, y)", 21: "GT_GetSoftLimit(a, ADR(x), ADR(y))", 22: "GT_SetStopDec(a, v, w)",
    23: "GT_GetStopDec(a, ADR(v), ADR(w))", 24: "GT_SetAxisBand(a, x, y)", 25: "GT_GetAxisBand(a, ADR(x), ADR(y))",
    26: "GT_Open()", 27: "GT_Close()", 28: "GT_Reset()", 29: "GT_GetClock(ADR(clock))", 30: "GT_LmtsOff(a, n)",
    31: "GT_LmtsOn(a, n)", 32: "GT_AlarmOff(a)", 33: "GT_AlarmOn(a)", 34: "GT_ProfileScale(a, p, q)",
    35: "GT_EncScale(a, p, q)", 36: "GT_SetEncPos(a, x)", 37: "GT_SynchAxisPos(x)",
    38: "GT_GetPrfMode(a, ADR(words), n)", 39: "GT_GetEncPos(a, ADR(values), n)",
    40: "GT_GetAxisPrfPos(a, ADR(values), n)", 41: "GT_GetAxisEncPos(a, ADR(values), n)",
    42: "GT_GetAxisError(a, ADR(values), n)", 43: "GT_SetPosErr(a, x)", 44: "GT_GetPosErr(a, ADR(x))",
    45: "GT_LoadConfig(file)", 46: "GT_GetPrfPos(a, 0, n)", 47: "GT_GetEncVel(a, ADR(values), n)",
    48: "GT_GetAxisEncAcc(a, ADR(values), n)", 49: "GT_GetPrfAcc(a, ADR(values), n)",
    50: "GT_GetPrfVel(a, ADR(values), n)",
}  # fmt: skip
PROGRAM = f"""
PROGRAM PLC_PRG
VAR
    job, a, n, p, q, rtn : INT; x, y : DINT; v, w : LREAL; clock : UDINT; file : STRING(200);
    trap : TTrapPrm; jog : TJogPrm; values : ARRAY[0..11] OF LREAL; words : ARRAY[0..11] OF DINT;
END_VAR
CASE job OF
{"".join(f"    {n}: rtn := {c};" + chr(10) for n, c in COMMANDS.items())}
END_CASE
job := 0;
END_PROGRAM
"""
NUMBER = {c[: c.index("(")]: n for n, c in reversed(COMMANDS.items())}
ALARM, POSITIVE, NEGATIVE, ENABLED, MOVING, IN_POSITION = (1 << n for n in (1, 5, 6, 9, 10, 11))


class Controller:
    def __init__(self) -> None:
        self.plc = PLC.load(PROGRAM)
        self.axis = self.plc.axes[1]

    def __call__(self, command: str | int, **inputs) -> int:
        """Run one command in one scan and give what it returned."""
        for name, value in {"a": 1, "n": 1, **inputs}.items():
            self.plc[f"PLC_PRG.{name}"] = value
        self.plc["PLC_PRG.job"] = NUMBER[command] if isinstance(command, str) else command
        self.plc.scan()
        return self.plc["PLC_PRG.rtn"]

    def get(self, name: str):
        return self.plc[f"PLC_PRG.{name}"]

    @property
    def status(self) -> int:
        assert self("GT_GetSts") == 0
        return self.get("words")[0]

    @property
    def why(self) -> str:
        return self.plc["SIM.refused"][(self.plc["SIM.refusals"] - 1) % 32]["why"]

    def trap(self, target=1000, vel=10.0, acc=1.0, dec=0.0, smooth=0, start=0.0) -> None:
        assert self("GT_PrfTrap") == 0
        assert self("GT_SetTrapPrm", trap={"acc": acc, "dec": dec, "velStart": start, "smoothTime": smooth}) == 0
        assert self("GT_SetPos", x=target) == 0
        assert self("GT_SetVel", v=vel) == 0
        assert self("GT_Update", x=1) == 0

    def run(self, scans: int) -> None:
        self.plc.scan(scans)
