"""The C subset of motion programs (iDEABOX 3, 10.4): what compiles, and what is said of what does not."""

import re
from pathlib import Path

import pytest

import mclib
from mclib.motion_programs import commands, files
from mclib.motion_programs.code import MotionError
from mclib.motion_programs.compiler import compile_motion

SUM = """int sum;
int add(int begin, int end)
{
 int i;
 int cc;
 i = begin;
lbl_loop:
 cc = i > end;
 if(cc) goto lbl_end;
 sum = sum + i;
 i = i + 1;
 goto lbl_loop;
lbl_end:
 return sum;
}
"""


def test_a_statement_is_a_command():
    unit = compile_motion(SUM)
    assert [c.line for c in unit.commands] == [6, 8, 9, 10, 11, 12, 14, 15]
    assert list(unit.functions["add"].variables) == ["begin", "end", "i", "cc"]


def test_lost_blanks_change_nothing():
    lost = SUM
    for word in ("int", "goto", "return"):
        lost = lost.replace(f"{word} ", word)
    assert "intadd(intbegin, intend)" in lost and "gotolbl_end" in lost and "returnsum" in lost
    assert compile_motion(lost) == compile_motion(SUM)


def test_names_that_only_look_like_it_stay_whole():
    unit = compile_motion("int interval, gotox, returned;\nvoid main(){ interval = 1; gotox = 2; returned = 3; }")
    assert list(unit.variables) == ["interval", "gotox", "returned"]


@pytest.mark.parametrize(
    "statement",
    [
        "i = -5;", "i = 0x7FFFFFFF;", "i = 0xFFFFFFFF;", "i = j;", "i = !j;", "i = ~j;", "i = -j;", "i = i << 3;",
        "i = a[2];", "a[i] = j;", "a[i] = a[j];", "d = 1;", "d = 2.5;", "d = d + 1;", "d = 1 + d;", "d = (double)i;",
        "i = (int)d;", "i = d >= 1.5;", "i = GT_AxisOn(1);", "GT_SetVel(1, d);", "GT_SetVel(1, 5);", "if(i) return;",
        "GT_GetSts(1, &i, 1, &j);", "GT_GetSts(1, a, 8, &j);", "GT_GetSts(1, &a[1], 2, &j);", "GT_SetJogPrm(1, e);",
        ";", "if(i) goto x; x: i = 1;", "GT_SetDo(OUT,0x04);", "i = i / MINUS;",
    ],
)  # fmt: skip
def test_statements(statement):
    head = "#define OUT 12 // outputs\n#define MINUS -3\nint i, j, a[8];\ndouble d, e[3];\n"
    compile_motion(head + "void main()\n{ " + statement + " }")


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("i = j + i * 2;", "two operands"), ("i = d;", "cast"), ("d = i + d;", "cast"), ("i = d & d;", "int"),
        ("d = d > 1.0;", "int"), ("i = k;", "not declared"), ("i = a;", "array"), ("i = j[0];", "no array"),
        ("i = a[8];", "0 to 7"), ("i = a[a[0]];", "index"), ("i = a[d];", "int"), ("goto nowhere;", "nowhere"),
        ("x: i = 1; x: i = 2;", "twice"), ("if(i > 1) goto x; x:", "no expression"), ("if(d) return;", "int"),
        ("if(i) i = 2;", "goto or return"), ("while(i) { }", "while"), ("for(i=0;i<3;i++) { }", "for"),
        ("switch(i) { }", "switch"), ("other();", "functions can't call"), ("GT_FlyToTheMoon();", "Table 10-2"),
        ("GT_AxisOn();", "all its 1"), ("GT_AxisOn(1, 2);", "1 parameters"), ("GT_GetSts(1, &i);", "all its 4"),
        ("GT_GetSts(1, i, 1, &j);", "&i"), ("GT_GetSts(1, &i, 1, NULL);", "must be written"),
        ("GT_SetPos(1, d);", "int, not double"), ("return 1;", "void"), ("i = 4294967296;", "beyond"),
        ("i = 1", "missing"),
        ("int b = 3;", "declared"), ("int i[2][3];", "one dimension"), ("int m, m;", "twice"), ("i = @;", "no meaning"),
        ("i = main();", "can't call"), ("unsigned k;", "no type"), ("GT_SetDo(MC_GPO, 4);", "#define MC_GPO"),
        ("/* i = 1;", "not closed"),
        ("int big[1025];", "1024"), ("int b1[600]; int b2[600];", "1024"),
    ],
)  # fmt: skip
def test_mistakes_are_told_with_their_line(statement, words):
    with pytest.raises(MotionError) as caught:
        compile_motion("int i, j, a[8];\ndouble d;\nvoid main()\n{\n\n" + statement + "\n}\n")
    assert words in caught.value.message
    assert caught.value.line in (6, 7)


@pytest.mark.parametrize("text", ["", "int i;", "int f(int){ }", "void f(){", "int f(){} int f(){}", "#define X"])
def test_files_that_are_no_programs(text):
    with pytest.raises(MotionError):
        compile_motion(text)


def test_names_have_room_in_the_symbol_file():
    """What is compiled can be downloaded and asked for; TVarInfo has 32 characters with the closing zero."""
    compile_motion(f"int {'x' * 31};\nvoid f()\n{{\n}}\n")
    for text in (f"\nint {'x' * 32};\nvoid f()\n{{\n}}\n", f"int a;\nvoid {'f' * 32}()\n{{\n}}\n"):
        with pytest.raises(MotionError, match="31 characters") as caught:
            compile_motion(text)
        assert caught.value.line == 2
    function = "void f{}()\n{{\n" + "".join(f"int w{n};" for n in range(1000)) + "\n}}\n"
    compile_motion(function.format(1) + function.format(2))
    with pytest.raises(MotionError, match="2048 functions and variables"):
        compile_motion("".join(function.format(n) for n in range(3)))


def test_files_belong_together(tmp_path):
    source = tmp_path / "sum.c"
    files.write(compile_motion(SUM), source)
    code, functions, variables = files.read(source.with_suffix(".bin"))
    assert len(code) == 8 * files.COMMAND_SIZE and [f.name for f in functions] == ["add"]
    assert [(owner, v.name, v.index) for owner, v in variables] == [
        (-1, "sum", 0), (0, "begin", 0), (0, "end", 1), (0, "i", 2), (0, "cc", 3),
    ]  # fmt: skip
    source.with_suffix(".bin").write_bytes(files.MAGIC + code[:-1])
    with pytest.raises(files.Damaged):
        files.read(source.with_suffix(".bin"))
    source.with_suffix(".ini").unlink()
    with pytest.raises(files.Damaged):
        files.read(source.with_suffix(".bin"))


def inputs(name: str) -> list[str]:
    """The types of the inputs of a library function, without what the compiler gives."""
    (file,) = mclib.LIBRARY.rglob(f"{name}.st")
    section = re.search(r"^VAR_INPUT\n(.*?)^END_VAR", file.read_text(encoding="utf-8"), re.S | re.M).group(1)
    section = section.partition("{attribute 'room_of'")[0]
    return [kind.split(":=")[0].strip() for _, kind in re.findall(r"(\w+) : ([^;]+);", section)]


def test_the_commands_are_those_of_the_library():
    for name, words in commands.COMMANDS.items():
        types = inputs(name)
        assert len(types) == len(words.split()), name
        for word, kind in zip(words.split(), types, strict=True):
            assert (kind[:11] == "POINTER TO ") == (word in commands.POINTERS), (name, word, kind)
            if word == "double":
                assert kind == "LREAL", name


COORDINATES = {"GT_CrdStatus", "GT_CrdStart", "GT_GetCrdVel", "GT_SetOverride", "GT_CrdSpace"}  # of the advanced manual


def test_table_10_2(manuals):
    text = (manuals / "ideabox3.txt").read_text(encoding="utf-8").splitlines()
    table = set(re.findall(r"GT_\w+", "\n".join(text[5381:5447])))
    assert len(table) == 86 and table - set(commands.COMMANDS) == COORDINATES


def test_the_call_of_the_interpreter_is_what_the_table_makes():
    types = {name: inputs(name) for name in commands.COMMANDS if name not in commands.OWN}
    made = Path(mclib.LIBRARY / "motion/GtMotionCall.st").read_text(encoding="utf-8")
    assert made == commands.dispatch(types)
