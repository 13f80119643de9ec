"""An input that is no number is an error of its block, and nothing moves."""

import pytest

from tests.mclib.mc.conftest import BLOCKS, LINKS, TABLES

NAN, INFINITE = float("nan"), float("inf")
INPUTS = [
    ("first", "Position", 201), ("relative", "Distance", 226), ("additive", "Distance", 251),
    ("velocity", "Velocity", 301), ("over", "Distance", 276), ("onward", "Position", 451),
    ("onward", "EndVelocity", 451), ("further", "EndVelocity", 426), ("smcOnward", "EndVelocity", 451),
    ("smcFurther", "Distance", 426), ("smcFurther", "EndVelocity", 426),
]  # fmt: skip


@pytest.mark.parametrize("value", [NAN, INFINITE])
def test_a_move_to_nowhere(bench, value):
    for block, name, error in INPUTS:
        bench.start(block, 5, **{name: value})
        assert bench[f"{block}.ErrorID"] == error, (block, name)
        assert bench["ax.fSetPosition"] == 0.0 and bench["ax.fSetVelocity"] == 0.0
        bench[f"{block}.{name}"] = 0.0
        bench[f"{block}.Execute"] = False
        bench.scan(2)
        assert bench.state == "standstill"


@pytest.mark.parametrize("value", [NAN, INFINITE])
def test_a_table_of_no_numbers(bench, value):
    for block, size, step in (("positions", 325, 326), ("velocities", 350, 351), ("accelerations", 375, 376)):
        bench.profile(block, [(100, 1.0), (100, value)])
        assert bench[f"{block}.ErrorID"] == step and bench.state == "standstill"
        bench.profile(block, [(100, 1.0), (100, 0.0)], Offset=value)
        assert bench[f"{block}.ErrorID"] == size and bench.state == "standstill"
        assert bench["ax.fSetPosition"] == 0.0


GOOD = {
    "Velocity": 1000.0, "VelocityDiff": 100.0, "Acceleration": 1e4, "Deceleration": 1e4, "Position": 100.0,
    "Distance": 100.0, "EndVelocity": 50.0, "Torque": 0.005, "TorqueRamp": 0.1, "ArraySize": 1, "StartMode": 2,
    "MasterSyncPosition": 60.0, "SlaveSyncPosition": 30.0, "fVelocityFast": 100.0, "fVelocitySlow": 10.0,
    "fAcceleration": 1e3, "fDeceleration": 1e3, "bReferenceSwitch": True,
}  # fmt: skip
OTHERS = ("gear2", "second", "third", "over2", "reset", "phase", "further2")  # as others, or no numbers


def test_every_number_of_every_block(bench):
    """Whatever an input holds: an error and nothing moves, or the axis stays where numbers are."""
    bench.fill_tables(0.5)
    bench.start("run", 50, Velocity=100.0)
    snapshot, found = bench.plc.snapshot(), 0
    for block in (set(BLOCKS) | set(LINKS) | set(TABLES) | {"combine", "jog", "inch", "smcHome"}) - set(OTHERS):
        members = bench[block]
        inputs = {name: value for name, value in GOOD.items() if name in members}
        for name in (n for n, v in members.items() if isinstance(v, float) and (n[0].isupper() or n[0] == "f")):
            for value in (NAN, INFINITE, 1e308, -1e308, 1e-310):
                bench.plc.restore(snapshot)
                bench["calm"] = False
                bench.start(block, 5, **{**inputs, name: value})
                place, speed = bench["ax.fSetPosition"], bench["ax.fSetVelocity"]
                assert abs(place) < 1e3 and abs(speed) < 1e4, (block, name, value)
                assert place == 0.0 or not bench.outputs(block) == "Error", (block, name, value)
                found += 1
    assert found > 300
