import pytest

from plcruntime import durations, stimuli
from plcruntime.errors import UsageError


@pytest.mark.parametrize(
    "text, ns",
    [
        ("500ms", 500_000_000),
        ("2.5s", 2_500_000_000),
        ("T#1s500ms", 1_500_000_000),
        ("time#1m", 60 * 10**9),
        ("LTIME#5us3ns", 5003),
        ("1h 30min", 5400 * 10**9),
        ("1_000ms", 10**9),
        ("0.1s", 10**8),
        ("1D", 86400 * 10**9),
        ("0s", 0),
        (2, 2 * 10**9),
        (0.3, 3 * 10**8),
    ],
)
def test_durations(text, ns):
    assert durations.nanoseconds(text) == ns


@pytest.mark.parametrize("text", ["", "5", "ms", "5 apples", "-1s", "T#", "1s2", -1, float("nan"), True])
def test_what_is_no_duration(text):
    with pytest.raises(ValueError, match="is not a duration"):
        durations.nanoseconds(text)


def test_scans():
    assert durations.scans("10ms", 10**6) == 10
    assert durations.scans("10.5ms", 10**6) == 11
    assert durations.scans("#120", 10**6) == 120
    assert durations.scans("0ms", 10**6) == 0
    with pytest.raises(ValueError, match="#120"):
        durations.scans("#-1", 10**6)


def test_texts():
    assert [durations.text(n) for n in (250, 10**6, 1_500_000, 2_500_000_000, 0)] == [
        "0.25 us", "1 ms", "1.5 ms", "2.5 s", "0 ms",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "text, parts",
    [
        ("x=TRUE@10ms", ("x", "TRUE", "10ms")),
        ("a.b[1] := 5", ("a.b[1]", "5", "")),
        ("s='a@b'@#3", ("s", "'a@b'", "#3")),
        ("s='it$'s@x'", ("s", "'it$'s@x'", "")),
        ('w="@"@1s', ("w", '"@"', "1s")),
        ("p=(a:=1, b:=2)@1s", ("p", "(a:=1, b:=2)", "1s")),
    ],
)
def test_stimuli(text, parts):
    s = stimuli.parse(text)
    assert (s.path, s.value, s.time) == parts


@pytest.mark.parametrize("text", ["x", "=5", "x=", "x=@1s", "x=1@", "x=1@ "])
def test_what_is_no_stimulus(text):
    with pytest.raises(UsageError):
        stimuli.parse(text)
