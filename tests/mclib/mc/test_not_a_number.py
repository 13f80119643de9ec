"""An input that is no number is an error of its block, and nothing moves."""

import pytest

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
