"""A program with one powered axis, P.ax, and what a test adds to it."""

from plcruntime import PLC

POWER = "power(Axis := ax, Enable := TRUE, bRegulatorOn := TRUE, bDriveStart := TRUE);"


def load(declared: str, statements: str):
    plc = PLC.load(
        f"PROGRAM P VAR ax : AXIS_REF_SM3; power : MC_Power; {declared} END_VAR\n{POWER} {statements}\nEND_PROGRAM"
    )
    plc.scan(10)
    return plc


def until(plc, name: str, most: int = 20000) -> int:
    for n in range(most):
        if plc[f"P.{name}"]:
            return n
        plc.scan()
    raise AssertionError(name)
