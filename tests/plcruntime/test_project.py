import re
from pathlib import Path

import pytest
from fake_machine import FakeMachine, program

from plcruntime import project, sources
from plcruntime.errors import UsageError
from plcruntime.plc import PLC

ROOT = Path(__file__).resolve().parents[2]


def write(folder: Path, text: str) -> Path:
    path = folder / "plc.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_everything_is_read(tmp_path):
    path = write(
        tmp_path,
        '[project]\nfiles=["a.st"]\ninterval="2ms"\nlibraries=["lib"]\nwatchdog="5s"\nstrict=true\n'
        '[[task]]\nname="Fast"\nprogram="P"\ninterval="1ms"\npriority=1\n[[task]]\nprograms=["A","B"]\n'
        '[[axis]]\nname="X"\nlag="2ms"\nsoft_positive=100\n[[axis]]\nnumber=5\nmodulo=360\n',
    )
    p = project.load(path)
    assert p.files == [tmp_path / "a.st"] and p.libraries == [tmp_path / "lib"]
    assert (p.interval, p.watchdog, p.strict) == (2_000_000, 5.0, True)
    assert [(t.name, t.programs, t.interval, t.priority) for t in p.tasks] == [
        ("Fast", ["P"], 1_000_000, 1),
        ("Task2", ["A", "B"], None, 0),
    ]
    assert p.axes[0].members == {"drive.lag": 2.0, "softPositive": 100}
    assert p.axes[1].number == 5 and p.axes[1].members == {"ref^.fPositionPeriod": 360, "ref^.iMovementType": 0}


@pytest.mark.parametrize(
    "text, words",
    [
        ("[projekt]", ["unknown key projekt", "did you mean project?"]),
        ('[project]\nintervall="1ms"', ["unknown key project.intervall", "interval"]),
        ("[[axis]]\nsoft_postive=1", ["axis.soft_postive", "soft_positive"]),
        ("[project]\ninterval=true", ["project.interval", "duration"]),
        ('[project]\ninterval="fast"', ["project.interval", "fast"]),
        ('[project]\ninterval="0ms"', ["longer than 0"]),
        ('[project]\nfiles="a.st"', ["list of texts"]),
        ("project=3", ["takes a table"]),
        ("[task]", ["[[...]]"]),
        ("[[task]]\n", ["Task1 has no program"]),
        ("[[axis]]\n[[axis]]\nnumber=1", ["axis number 1 is there twice"]),
        ("[[axis]]\nnumber=0", ["not 1 or more"]),
        ('[[axis]]\nlag="x"', ["axis 1: lag"]),
        ("[project", ["is not TOML"]),
    ],
)
def test_mistakes(tmp_path, text, words):
    with pytest.raises(UsageError) as caught:
        project.load(write(tmp_path, text))
    for word in (*words, "plc.toml"):
        assert word in str(caught.value)


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(UsageError, match="can't read"):
        project.load(tmp_path / "plc.toml")
    (tmp_path / "plc.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(UsageError, match="not TOML"):
        project.load(tmp_path / "plc.toml")


def test_what_may_be_named(tmp_path):
    (tmp_path / "b.st").write_text("x")
    (tmp_path / "a.ST").write_text("x")
    (tmp_path / "notes.txt").write_text("x")
    assert [p.name for p in sources.gather(tmp_path)[0]] == ["a.ST", "b.st"]
    assert sources.gather(tmp_path / "b.st")[0] == [tmp_path / "b.st"]
    assert sources.gather("PROGRAM p\nEND_PROGRAM")[0][0].path == "<text>"
    toml = write(tmp_path, '[project]\nfiles=["b.st"]\ninterval="3ms"')
    for named in (tmp_path, toml, str(toml)):
        files, settings = sources.gather(named)
        assert files == [tmp_path / "b.st"] and settings.interval == 3_000_000
    files, settings = sources.gather(tmp_path / "a.ST", config=toml)
    assert files == [tmp_path / "a.ST"] and settings.interval == 3_000_000
    (tmp_path / "empty").mkdir()
    with pytest.raises(UsageError, match="no .st file"):
        sources.gather(tmp_path / "empty")
    with pytest.raises(UsageError, match="no file"):
        sources.gather([])


def test_axes_get_their_first_values():
    settings = project.Project(path=Path("plc.toml"), axes=[project.Axis(2, "X", {"prfPos": 5.0}, {"prfPos": "start"})])
    plc = PLC(program(), project=settings, machine=FakeMachine)
    assert plc.axes["x"].prfPos == 5.0
    plc.reset("origin")
    assert plc.axes[2].prfPos == 5.0
    for member, word in (("ref^.fScalefactor", "needs an AXIS_REF_SM3"), ("nope", "no variable nope")):
        settings.axes[0] = project.Axis(2, "X", {member: 1.0}, {member: "key"})
        with pytest.raises(UsageError, match=f"plc.toml: axis 2: key.*{word}"):
            PLC(program(), project=settings, machine=FakeMachine)


def test_every_key_is_documented():
    page = (ROOT / "docs" / "plc_toml.md").read_text(encoding="utf-8")
    documented = set(re.findall(r"`([a-z_]+)`", page))
    assert {key for section, keys in project.KEYS.items() if section for key in keys} <= documented
    assert set(project.MEMBERS) <= set(project.KEYS["axis"])
    example = re.search(r"```toml\n(.*?)```", page, re.S)[1]
    assert "[[axis]]" in example
