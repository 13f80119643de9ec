"""python kill_retain.py FILE KILLS: kills PLCs while they write a retain file; prints kills, saves told, last value.

Ends with exit code 1 when a file was ever half written, or lost a save that was told.
"""

import os
import random
import signal
import sys
import time

from plcruntime.plc import PLC, build

PROGRAM = """PROGRAM PLC_PRG
VAR PERSISTENT n : LINT; END_VAR
VAR RETAIN copies : ARRAY[1..500] OF LINT; i : INT; END_VAR
n := n + 1;
FOR i := 1 TO 500 DO copies[i] := n; END_FOR
END_PROGRAM
"""


def work(program, file: str, pipe: int) -> None:
    """Count on from what the file holds, until killed."""
    plc = PLC(program, retain=file)
    while True:
        plc.scan()
        plc.save_retain()
        os.write(pipe, plc["n"].to_bytes(8, "little"))


def value(program, file: str) -> int:
    """What a PLC that starts now finds. Every copy must be of the same scan."""
    plc = PLC(program, retain=file)
    copies = set(plc["copies"])
    assert copies == {plc["n"]}, f"{sorted(copies)} beside {plc['n']}"
    return plc["n"]


def main() -> None:
    file, kills = sys.argv[1], int(sys.argv[2])
    random.seed(1)
    program, _ = build(PROGRAM)
    told = saves = 0
    for _ in range(kills):
        read_end, write_end = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                work(program, file, write_end)
            finally:
                os._exit(1)
        os.close(write_end)
        first = os.read(read_end, 8)  # it has begun
        time.sleep(random.uniform(0, 0.006))
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        assert os.WIFSIGNALED(status), "the child failed by itself"
        while more := os.read(read_end, 8):
            first = more
            saves += 1
        os.close(read_end)
        told = int.from_bytes(first, "little")
        saves += 1
        found = value(program, file)
        assert told <= found <= told + 1, f"saved {told}, found {found}"
    print(kills, saves, found)


if __name__ == "__main__":
    main()
