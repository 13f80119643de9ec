"""The GT_ commands of motion programs (Table 10-2 and their counterparts), and how their arguments travel.

A signature is a word for each parameter: int and double are values, the others pointers to variables of the motion
program, named by what the command expects there. Structures are arrays: of the numbers that they hold.
"""

from __future__ import annotations

# kind of a pointer -> its number in the interpreter (GtMotionField.st)
POINTERS = {"INT": 1, "DINT": 2, "LREAL": 3, "UINT": 4, "TTrapPrm": 5, "TPid": 6, "TTrigger": 7, "TTriggerStatus": 8}
_MANY = "int LREAL int DINT"  # first axis, values, count, clock
COMMANDS: dict[str, str] = {
    "GT_Delay": "int", "GT_DelayHighPrecision": "int", "GT_SetDataPage": "int int",
    "GT_SetDo": "int int", "GT_SetDoBit": "int int int", "GT_GetDo": "int DINT", "GT_GetDi": "int DINT",
    "GT_GetDiReverseCount": "int int DINT int", "GT_SetDiReverseCount": "int int DINT int",
    "GT_SetDac": "int INT int", "GT_GetDac": "int INT int DINT", "GT_GetDacValue": "int INT int DINT",
    "GT_GetEncPos": _MANY, "GT_GetEncVel": _MANY, "GT_SetEncPos": "int int",
    "GT_SetTrigger": "int TTrigger", "GT_GetTriggerStatus": "int TTriggerStatus int",
    "GT_LinkCaptureOffset": "int int", "GT_GetCaptureOffset": "int DINT", "GT_GetClock": "DINT DINT",
    "GT_GetSts": "int DINT int DINT", "GT_ClrSts": "int int", "GT_AxisOn": "int", "GT_AxisOff": "int",
    "GT_Stop": "int int", "GT_SynchAxisPos": "int", "GT_ZeroPos": "int int", "GT_SetPrfPos": "int int",
    "GT_SetSoftLimit": "int int int", "GT_GetSoftLimit": "int DINT DINT",
    "GT_SetAxisBand": "int int int", "GT_GetAxisBand": "int DINT DINT",
    "GT_GetPrfPos": _MANY, "GT_GetPrfVel": _MANY, "GT_GetPrfAcc": _MANY, "GT_GetPrfMode": "int DINT int DINT",
    "GT_GetAxisPrfPos": _MANY, "GT_GetAxisPrfVel": _MANY, "GT_GetAxisPrfAcc": _MANY, "GT_GetAxisEncPos": _MANY,
    "GT_GetAxisEncVel": _MANY, "GT_GetAxisEncAcc": _MANY, "GT_GetAxisError": _MANY,
    "GT_SetControlFilter": "int int", "GT_GetControlFilter": "int INT", "GT_SetPid": "int int TPid",
    "GT_GetPid": "int int TPid", "GT_PrfTrap": "int", "GT_SetTrapPrm": "int TTrapPrm", "GT_GetTrapPrm": "int TTrapPrm",
    "GT_PrfJog": "int", "GT_SetJogPrm": "int LREAL", "GT_GetJogPrm": "int LREAL", "GT_Update": "int",
    "GT_SetPos": "int int", "GT_GetPos": "int DINT", "GT_SetVel": "int double", "GT_GetVel": "int LREAL",
    "GT_PrfGear": "int int", "GT_SetGearMaster": "int int int int", "GT_GetGearMaster": "int INT INT INT",
    "GT_SetGearRatio": "int int int int", "GT_GetGearRatio": "int DINT DINT DINT", "GT_GearStart": "int",
    "GT_SetExtIoValue": "int int", "GT_GetExtIoValue": "int UINT", "GT_SetExtIoBit": "int int int",
    "GT_GetExtIoBit": "int int UINT", "GT_GetExtAdValue": "int int UINT", "GT_GetExtAdVoltage": "int int LREAL",
    "GT_SetExtDaValue": "int int int", "GT_SetExtDaVoltage": "int int double", "GT_GetStsExtMdl": "int int UINT",
    "GT_AlarmOff": "int", "GT_AlarmOn": "int", "GT_LmtsOn": "int int", "GT_LmtsOff": "int int",
    "GT_ProfileScale": "int int int", "GT_EncScale": "int int int", "GT_StepDir": "int", "GT_StepPulse": "int",
    "GT_SetMtrBias": "int int", "GT_GetMtrBias": "int INT", "GT_SetMtrLmt": "int int", "GT_GetMtrLmt": "int INT",
    "GT_LmtSns": "int", "GT_EncSns": "int", "GT_EncOn": "int", "GT_EncOff": "int",
    "GT_SetPosErr": "int int", "GT_GetPosErr": "int DINT",
    "GT_SetStopDec": "int double double", "GT_GetStopDec": "int LREAL LREAL", "GT_CtrlMode": "int int",
}  # fmt: skip
NUMBER = {name: n for n, name in enumerate(COMMANDS, 1)}
OWN = ("GT_Delay", "GT_DelayHighPrecision", "GT_SetDataPage")  # the interpreter itself does these


def dispatch(types: dict[str, list[str]]) -> str:
    """GtMotionCall.st. types: of the inputs of each command, as the library declares them."""
    lines = []
    for name, number in NUMBER.items():
        if name in OWN:
            continue
        given = []
        for i, (word, kind) in enumerate(zip(COMMANDS[name].split(), types[name], strict=False)):
            if word == "int":
                given.append(f"call.n[{i}]" if kind == "DINT" else f"DINT_TO_{kind}(call.n[{i}])")
            else:
                given.append(f"call.x[{i}]" if word == "double" else f"ADR(call.buffer[{i}, 0])")
        line = f"    {number}: GtMotionCall := {name}({', '.join(given)});"
        lines.append(line if len(line) <= 120 else line.replace(f"{name}(", f"{name}(\n        "))
    return _CALL.format(cases="\n".join(lines))


_CALL = """{{attribute 'hidden'}}
(* Call a GT_ command of a motion program. mclib/motion_programs/commands.py has the numbers and made this file. *)
FUNCTION GtMotionCall : INT
VAR_INPUT
    command : INT;
END_VAR
VAR_IN_OUT
    call : GtMotionArguments;
END_VAR
CASE command OF
{cases}
END_CASE
END_FUNCTION
"""
