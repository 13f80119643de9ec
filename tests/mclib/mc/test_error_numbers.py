"""The numbers of SMC_ERROR that CODESYS documents: SMC_ERROR of SM3_Error 4.20, and SML_ERROR, which numbers alike."""

import re
from pathlib import Path

import mclib

SM3 = {
    "NO_ERROR": 0, "DI_GENERAL_COMMUNICATION_ERROR": 1, "DI_AXIS_ERROR": 2, "DI_FIELDBUS_LOST_SYNCRONICITY": 3,
    "DI_SWLIMITS_EXCEEDED": 10, "DI_HWLIMITS_EXCEEDED": 11, "DI_LINEAR_AXIS_OUTOFRANGE": 12,
    "DI_HALT_OR_QUICKSTOP_NOT_SUPPORTED": 13, "DI_VOLTAGE_DISABLED": 14, "DI_IRREGULAR_ACTPOSITION": 15,
    "DI_POSITIONLAGERROR": 16, "DI_HOMING_ERROR": 17, "DI_LICENSING_ERROR": 18, "DI_DRIVE_LIMIT_ACTIVE": 19,
    "REGULATOR_OR_START_NOT_SET": 20, "WRONG_CONTROLLER_MODE": 21, "INVALID_ACTION_FOR_LOGICAL": 25,
    "AXIS_IS_NOT_OPERATIONAL": 27,
}  # fmt: skip
SML = {
    "AXIS_NOT_READY_FOR_MOTION": 34, "RAG_ERROR_DURING_STARTUP": 80, "CGR_ZERO_VALUES": 90, "R_NO_ERROR_TO_RESET": 120,
    "R_DRIVE_DOESNT_ANSWER": 121, "R_ERROR_NOT_RESETTABLE": 122, "R_DRIVE_DOESNT_ANSWER_IN_TIME": 123,
    "RP_PARAM_UNKNOWN": 130, "RP_REQUESTING_ERROR": 131, "WP_PARAM_INVALID": 140, "WP_SENDING_ERROR": 141,
    "H_AXIS_WASNT_STANDSTILL": 170, "MS_AXIS_IN_ERRORSTOP": 183,
}  # fmt: skip
# names that CODESYS's pages mention without a number, in the order of its list
IN_ORDER = ["FB_WASNT_CALLED_DURING_MOTION", "AXIS_IS_NO_AXIS_REF", "AXIS_REF_CHANGED_DURING_OPERATION"]


def numbers() -> dict[str, int]:
    (file,) = mclib.LIBRARY.rglob("SMC_ERROR.st")
    found = re.findall(r"^\s+SMC_(\w+) := (\d+)", Path(file).read_text(encoding="utf-8"), re.M)
    assert len(found) == len(dict(found)) == len({n for _, n in found})  # no name and no number twice
    return {name: int(number) for name, number in found}


def test_documented_numbers():
    ours = numbers()
    for name, number in (SM3 | SML).items():
        assert ours[name] == number, name
    assert 27 < ours[IN_ORDER[0]] < ours[IN_ORDER[1]] < ours[IN_ORDER[2]] < 34
