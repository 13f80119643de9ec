import math
from datetime import timedelta

import pytest

from stcore import paths
from stcore.paths import PathError
from stcore.show import show
from stcore.syntax import Arg, ArrayInit, Literal, Name, StructInit, Unary
from stcore.values import plain_literal


@pytest.mark.parametrize(
    "path, full",
    [
        ("plc_prg.TRAP.acc", "PLC_PRG.trap.acc"),
        ("trap.acc", "PLC_PRG.trap.acc"),
        ("arr[ 3 ]", "PLC_PRG.arr[3]"),
        ("grid[1, 2]", "PLC_PRG.grid[1,2]"),
        ("gain", "GVL.gain"),
        ("gvl.GAIN", "GVL.gain"),
        ("timers[2].et", "PLC_PRG.timers[2].ET"),
        ("timers[1].axis.dec", "PLC_PRG.timers[1].axis.dec"),
        ("p^.acc", "PLC_PRG.p^.acc"),
        ("status.9", "PLC_PRG.status.9"),
        ("status.%B1", "PLC_PRG.status.%B1"),
        ("Axis[1].prfPos", "SIM.Axis[1].prfPos"),  # the user's Axis is an INT
        ("axis", "PLC_PRG.Axis"),
        ("door", "door"),
        ("%ix1.2", "%IX1.2"),
        ("%MW4", "%MW4"),
        ("only", "Other.only"),
    ],
)
def test_full_names(plc, path, full):
    assert plc.place(path).name == full


@pytest.mark.parametrize(
    "path, words",
    [
        ("position", ["ambiguous", "PLC_PRG.position", "Other.position"]),
        ("velocty", ["unknown variable 'velocty'", "did you mean velocity"]),
        ("PLC_PRG.velocty", ["PLC_PRG has no variable velocty", "velocity"]),
        ("arr[5]", ["PLC_PRG.arr[5]", "1..4"]),
        ("arr[1,2]", ["1 indices, not 2"]),
        ("arr[i]", ["'i' is not a number"]),
        ("velocity.3", ["LREAL", "no bits"]),
        ("status.16", ["last is 15"]),
        ("status.%W1", ["last is 0"]),
        ("velocity^", ["not a pointer"]),
        ("velocity.x", ["no member x"]),
        ("a b", ["' b'"]),
        ("", ["not the path"]),
        ("[1]", ["not the path"]),
        ("%IX1", ["needs its bit"]),
        ("%MW99", ["outside %M"]),
        ("%Z1", ["direct address"]),
    ],
)
def test_wrong_paths(plc, path, words):
    with pytest.raises(PathError) as caught:
        plc[path]
    for word in words:
        assert word in str(caught.value)


def test_pointers_are_followed(plc):
    with pytest.raises(PathError, match="NULL"):
        plc["p^.acc"]
    with pytest.raises(PathError, match="NULL"):
        plc["timers[1].axis.acc"]
    address = plc.place("trap").address
    plc["trap.dec"] = 0.125
    plc["p"] = address
    assert plc["p^.dec"] == 0.125
    assert plc["p[0].dec"] == 0.125
    member = plc.place("timers[1]").type.members["AXIS"]
    plc._machine.memory[plc.place("timers[1]").address + member.offset :][:4] = address.to_bytes(4, "little")
    plc["timers[1].axis.dec"] = 0.5
    assert plc["trap"] == {"acc": 0.0, "dec": 0.5, "smoothTime": 0}
    plc["p"] = 0xFFFFFF00
    with pytest.raises(PathError, match="out of the memory"):
        plc["p^.acc"]


def test_a_reference_is_what_it_refers_to(plc):
    place = plc.place("PLC_PRG").type.members["REF"]
    at = plc.place("PLC_PRG").address + place.offset
    plc._machine.memory[at : at + 4] = plc.place("velocity").address.to_bytes(4, "little")
    assert plc["ref"] == 0.5
    plc["ref"] = 2
    assert plc["velocity"] == 2.0


@pytest.mark.parametrize(
    "path, value, back",
    [
        ("run", True, True),
        ("run", 0, False),
        ("counter", -5, -5),
        ("velocity", 3, 3.0),
        ("r", 0.1, 0.10000000149011612),
        ("t", 1.5, 1.5),
        ("t", timedelta(milliseconds=20), 0.02),
        ("date", 1_700_000_000, 1_700_000_000.0),
        ("arr", [1, 2, 3, -4], [1, 2, 3, -4]),
        ("arr[2]", 7, 7),
        ("grid", [[1, 2, 3], [4, 5, 6]], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
        ("grid", [1, 2, 3, 4, 5, 6], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
        ("trap", {"ACC": 0.25}, {"acc": 0.25, "dec": 0.0, "smoothTime": 0}),
        ("name", "Größe", "Größe"),
        ("name", b"\xff\xfe", "ÿþ"),
        ("wide", "äöü", "äöü"),
        ("mode", 5, 5),
        ("mode", "Moving", 5),
        ("status", 0xFFFF, 0xFFFF),
        ("status.9", True, True),
        ("%MW4", 513, 513),
        ("%MX8.1", True, True),
        ("door", True, True),
        ("timers", [{"IN": True}, {}], [{"IN": True, "ET": 0.0}, {"IN": False, "ET": 0.0}]),
    ],
)
def test_write_and_read(plc, path, value, back):
    plc[path] = value
    assert plc[path] == back
    assert type(plc[path]) is type(back)


def test_word_addresses_count_words(plc):
    plc["%MW4"] = 0x0201
    assert plc["%MB8"] == 1 and plc["%MB9"] == 2


def test_numpy_values_are_values(plc):
    np = pytest.importorskip("numpy")
    plc["run"], plc["counter"], plc["velocity"] = np.bool_(True), np.int32(3), np.float32(0.5)
    plc["arr"] = np.array([1, 2, 3, 4], dtype=np.int16)
    plc["grid"] = np.ones((2, 3))
    assert plc["run"] is True and plc["counter"] == 3 and plc["velocity"] == 0.5
    assert plc["arr"] == [1, 2, 3, 4] and plc["grid"] == [[1.0] * 3] * 2


@pytest.mark.parametrize(
    "path, value, error, words",
    [
        ("arr[1]", 40000, ValueError, ["PLC_PRG.arr[1]", "INT", "-32768..32767"]),
        ("counter", 1.5, TypeError, ["PLC_PRG.counter", "DINT"]),
        ("counter", "3", TypeError, ["whole number, not '3'"]),
        ("counter", True, TypeError, ["whole number, not TRUE"]),
        ("run", 2, ValueError, ["TRUE or FALSE"]),
        ("run", "TRUE", TypeError, ["TRUE or FALSE"]),
        ("velocity", "fast", TypeError, ["LREAL"]),
        ("r", 1e300, ValueError, ["REAL", "too large"]),
        ("t", -1, ValueError, ["TIME", "0..4294967.295 s"]),
        ("t", math.nan, ValueError, ["not a time"]),
        ("arr", [1, 2], ValueError, ["4 elements, not 2"]),
        ("arr", 5, TypeError, ["list"]),
        ("grid", [[1, 2], [3, 4]], ValueError, ["3 elements, not 2"]),
        ("trap", 5, TypeError, ["dict"]),
        ("trap", {"acc": "x"}, TypeError, ["PLC_PRG.trap.acc"]),
        ("trap", {"nope": 1}, PathError, ["nope", "acc, dec, smoothTime"]),
        ("name", "much too long a name", ValueError, ["STRING(10)", "20 characters"]),
        ("name", 5, TypeError, ["str"]),
        ("mode", "flying", ValueError, ["idle, moving"]),
        ("limit", 5, ValueError, ["constant"]),
    ],
)
def test_wrong_values_change_nothing(plc, path, value, error, words):
    before = bytes(plc._machine.memory)
    with pytest.raises(error) as caught:
        plc[path] = value
    for word in words:
        assert word in str(caught.value)
    assert bytes(plc._machine.memory) == before


def literal(value, type_name=None):
    return Literal(0, 1, value, type_name, str(value))


def put(plc, path, node):
    from stcore import values

    place = plc.place(path)
    plc[path] = values.literal(plc.program, plc._machine.memory, node, place.type, place.name)
    return plc[path]


def test_plain_literals():
    for text, value in (("TRUE", True), ("false", False), (" -12 ", -12), ("+3", 3), ("1.5", 1.5), ("-2.0e-3", -0.002)):
        node = plain_literal(text)
        assert node.value == value and type(node.value) is type(value)
    for text in ("", "16#FF", "1_000", "T#1s", "1.", ".5", "'a'", "idle", "1 + 2", "٣"):
        assert plain_literal(text) is None


def test_literals(plc):
    assert put(plc, "run", literal(True, "BOOL")) is True
    assert put(plc, "counter", Unary(0, 1, "-", literal(7))) == -7
    assert put(plc, "t", literal(1_500_000_000, "TIME")) == 1.5
    assert put(plc, "date", literal(1_700_000_000, "DT")) == 1_700_000_000
    assert put(plc, "name", literal("text", "STRING")) == "text"
    assert put(plc, "mode", Name(0, 1, "moving")) == 5
    plc["arr"] = [9, 9, 9, 9]
    node = ArrayInit(0, 1, [(None, literal(1)), (literal(2), literal(5))])
    assert put(plc, "arr", node) == [1, 5, 5, 9]
    assert put(plc, "grid", ArrayInit(0, 1, [(None, literal(1)), (None, literal(2))]))[0][:2] == [1.0, 2.0]
    node = StructInit(0, 1, [Arg(0, 1, "Acc", literal(0.25), False, False)])
    assert put(plc, "trap", node)["acc"] == 0.25


@pytest.mark.parametrize(
    "path, node",
    [
        ("t", literal(500)),
        ("counter", literal(500, "TIME")),
        ("counter", literal(1.5)),
        ("counter", literal("a", "STRING")),
        ("run", literal(3)),
        ("date", literal(500, "TIME")),
        ("counter", ArrayInit(0, 1, [(None, literal(1))])),
        ("counter", StructInit(0, 1, [])),
    ],
)
def test_literals_of_the_wrong_type(plc, path, node):
    with pytest.raises((TypeError, ValueError), match="PLC_PRG"):
        put(plc, path, node)


def test_shown_as_st(plc):
    plc["mode"], plc["t"], plc["name"] = 5, 1.5, "it's"
    assert plc.show("mode") == "moving"
    assert plc.show("t") == "T#1.5s"
    assert plc.show("name") == "'it$'s'"
    assert plc.show("run") == "FALSE"
    assert plc.show("grid") == "[[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]"
    assert plc.show("trap") == "(acc := 0.0, dec := 0.0, smoothTime := 0)"
    assert show(plc.place("mode").type, 3) == "3"


def test_leaves(plc):
    names = [p.name for p in paths.leaves(plc.place("timers"))]
    assert names == ["PLC_PRG.timers[1].IN", "PLC_PRG.timers[1].ET", "PLC_PRG.timers[2].IN", "PLC_PRG.timers[2].ET"]
    assert [p.name for p in paths.leaves(plc.place("grid"))][3] == "PLC_PRG.grid[1,1]"
