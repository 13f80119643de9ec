"""Waiting for a variable of a PLC in one call, where a scan a call would cost a hundred times as much."""

from plcruntime import PLC
from plcruntime.errors import ConditionTimeout

VARIABLE = "awaited : POINTER TO BOOL;"  # of PLC_PRG, so that one condition serves for every variable


def wait(plc: PLC, path: str, most: int) -> int:
    """Run until a BOOL is TRUE; the scans that it took. Raises AssertionError when it is not after `most`."""
    if plc[path]:
        return 0
    start = plc.scans
    plc["PLC_PRG.awaited"] = plc.place(path).locate(plc._machine.memory)
    try:
        plc.run_until("PLC_PRG.awaited^", f"#{most}")
    except ConditionTimeout:
        raise AssertionError(f"{path} did not come in {most} scans") from None
    return plc.scans - start
