"""The table of problem codes: one line per problem, message and hint; ``explain`` prints the page of a code.

E01.. lexing and parsing, W01.. mends of printed listings (errors under --strict), E02.. declarations and types,
E03.. names and expressions, W03.. conversions that may lose something, E04.. calls, E05.. statements,
E06.. constants and initial values, E07.. files and projects, W08.. mistakes that show while a
program runs, F.... faults of a running program.
"""

from __future__ import annotations

from typing import NamedTuple


class Code(NamedTuple):
    message: str
    hint: str = ""


CODES: dict[str, Code] = {
    # --- E01: lexing and parsing
    "E0101": Code("{found} is not expected here"),
    "E0102": Code("{what} is missing {where}"),
    "E0103": Code("{closer} is missing for the {opener} at line {line}"),
    "E0104": Code("{closer} without {opener}", "remove it, or write the {opener} it belongs to"),
    "E0105": Code("the character {found} means nothing in ST"),
    "E0106": Code("the string {text} is not closed", "a string ends with the quote it began with, on the same line"),
    "E0107": Code("the comment is not closed", "write *) where it ends"),
    "E0108": Code("the pragma is not closed", "write }} where it ends"),
    "E0109": Code("{text} is not a number: {why}"),
    "E0110": Code("{text} is not a duration: {why}"),
    "E0111": Code("{text} is not a date or time: {why}"),
    "E0112": Code("{text} is no escape", "$$ $' $\" $N $L $R $T $P, or $ and the hexadecimal code of a character"),
    "E0113": Code("nested too deeply", "split it into several statements"),
    "E0114": Code("{what} is not supported yet", "write a FUNCTION, a FUNCTION_BLOCK or an ACTION instead"),
    "E0115": Code("{found} is not expected here", "did you mean {keyword}?"),
    "E0116": Code("{found} stands here twice", "remove one"),
    "E0117": Code("{name} is not a name that can be declared", "a dot separates a name from its member"),
    "E0118": Code("{found} without {what}"),
    "E0119": Code("an array needs a lowest and a highest index, not {text}", "write ARRAY[0..{text}]"),
    "E0120": Code("{count} operands in one expression; at most {limit}", "split it into several statements"),
    "E0121": Code("{text} is not an address", "%IX0.0, %QW4, %MD8; a part of a variable is %X, %B, %W, %D or %L"),
    "E0122": Code("the ACTION {name} belongs to no program or function block", "write it after the one it belongs to"),
    "E0123": Code("{text} values are too many to write out"),
    "E0124": Code("a statement before the first label of CASE", "write the value it is for and a colon in front"),
    "E0125": Code("ELSE IF opens a second IF, whose END_IF is missing", "write ELSIF, which needs no END_IF of its own"),
    "E0126": Code("{what} belongs before the statements", "move it up"),
    "E0127": Code("too many errors; the rest of the file is not read"),
    "E0128": Code("{name} is a reserved word and can't be a name", "choose another name"),
    # --- W01: what a printed listing has and ST has not; errors under --strict
    "W0101": Code("typographic quotes in {text} read as '", "write straight quotes"),
    "W0102": Code("= read as :=", "write :="),
    "W0103": Code(": read as :=", "write {name} := ..."),
    "W0104": Code("; is missing at the end of the line", "write ;"),
    "W0105": Code("the line {text} is ignored"),
    "W0106": Code("the placeholder {text} is ignored", "write what it stands for"),
    "W0107": Code("{closer} is missing at the end", "write {closer}"),
    "W0108": Code("statements outside of a program; read as PROGRAM PLC_PRG", "write PROGRAM PLC_PRG ... END_PROGRAM"),
    "W0109": Code("{text} read as {plain}", "write {plain}"),
    "W0110": Code("{name} is left empty: not connected"),
    "W0111": Code("the string {text} is not closed; read up to here", "close it with '"),
    "W0112": Code("the sign {found} read as {plain}", "write {plain}"),
    "W0113": Code("[{text}] read as [0..{high}]", "write [0..{high}]"),
    "W0114": Code("a comma is missing between two arguments", "write ,"),
    # --- W013x: names in printed listings (the checker's part of mending)
    "W0130": Code("{name} read as {meant}", "write {meant}"),
    "W0131": Code("{name} is not declared; read as {meant}, which is not used otherwise", "write one of the two"),
    "W0132": Code("{name} is not declared; its use makes it {type}", "declare  {name} : {type};"),
    "W0133": Code("{name} takes {wanted} arguments: the first of {given} is read as a core number and left out"),
    "W0134": Code("{name} is a block; read as an instance of it", "declare an instance and call that"),
    # --- E02: declarations and types
    "E0201": Code("{name} is declared twice; first at line {line}", "rename one of them or remove it"),
    "E0202": Code("unknown type {name}", "{near}"),
    "E0203": Code("{name} contains itself", "use a POINTER TO {name} instead"),
    "E0204": Code("{name} is not a type"),
    "E0205": Code("the range {low}..{high} is empty", "write the lower bound first"),
    "E0206": Code("{address} is no direct address", "for example %IX0.3, %QB2, %MW4, %MD1"),
    "E0207": Code("{name}: ARRAY[*] is for VAR_IN_OUT only", "give the bounds"),
    "E0208": Code("there is no global variable {name}"),
    "E0209": Code("VAR_CONFIG of {name}: {why}", "the path leads from a program or global variable: PLC_PRG.block.input"),
    "W0202": Code("the CONSTANT {name} has no value; it is 0", "write {name} : TYPE := value;"),
    # --- E03: names and expressions
    "E0301": Code("{name} is not declared", "{near}"),
    "E0302": Code("{source} can't be converted to {target}{what}", ""),
    "E0303": Code("{name} is not a value"),
    "E0304": Code("{what} must be BOOL, not {type}"),
    "E0306": Code("{type} has no member {name}", "{near}"),
    "E0307": Code("{base} is a pointer", "write {base}^.{name} for what it points to"),
    "E0308": Code("{base} is {type} and has no member {name}"),
    "E0309": Code("{type} has no bits to select", "bits can be taken from integers and bit strings"),
    "E0310": Code("{type} has no part {index}", "the last one is {last}"),
    "E0311": Code("{name} is {type}, not an array"),
    "E0312": Code("an index must be an integer, not {type}"),
    "E0313": Code("{name} has {wanted} dimensions, {given} indices are given"),
    "E0314": Code("the index {value} of {name} is outside {low}..{high}"),
    "E0315": Code("{name} is {type}, not a pointer", "^ follows a POINTER TO"),
    "E0316": Code("{op} can't be applied to {type}"),
    "E0317": Code("{op} can't be applied to {left} and {right}"),
    "E0318": Code("{name} can't be written: {why}"),
    "E0319": Code("{name} is not a variable"),
    "W0301": Code("{source} to {target} may lose part of the value", "make it explicit with a conversion function"),
    "W0302": Code("{source} to {target} is rounded", "make it explicit with a conversion function or TRUNC"),
    "W0303": Code("{source} is used as {target}, which has another size"),
    "W0304": Code("the constant {value} does not fit {type} and wraps around"),
    "W0305": Code("a value of {source} is used as {target}"),
    "W0306": Code("{value} is outside {type}; the result is {held}"),
    # --- E04: calls
    "E0401": Code("{name} takes {wanted} arguments, {given} are given"),
    "E0402": Code("{name} has no address of its own: it is a bit"),
    "E0403": Code("{name} has no direct address", "BITADR is for variables AT %..."),
    "E0404": Code("unknown function {name}", "{near}"),
    "E0405": Code("{name} is a type; an instance of it can be called", "declare  inst : {name};  and call inst(...)"),
    "E0406": Code("{name} is {type} and can't be called"),
    "E0407": Code("{name} takes {wanted}, not {given}"),
    "E0408": Code("{name} has no parameter {parameter}"),
    "E0409": Code("{parameter} of {name} is given twice"),
    "E0410": Code("{parameter} of {name} must be connected: it is VAR_IN_OUT", "{parameter} := a variable"),
    "E0411": Code("{what} is {wanted}; a variable of {given} can't be connected"),
    "E0412": Code("{parameter} is an output", "write {parameter} => variable"),
    "W0401": Code("{what}: {given} is shorter than {wanted}"),
    # --- E05: statements
    "E0501": Code("{name} is not a REFERENCE TO"),
    "E0502": Code("{text} is not a statement"),
    "E0503": Code("the selector of CASE must be an integer or an enumeration, not {type}"),
    "E0504": Code("the label {text} of CASE is not a constant"),
    "E0505": Code("the variable of FOR must be an integer, not {type}"),
    "E0506": Code("a step of 0 never ends"),
    "E0507": Code("{word} stands outside a loop"),
    "E0508": Code("there is no label {name} here"),
    "W0501": Code("the label {value} stands at line {line} already; this branch is never taken"),
    # --- E06: constants and initial values
    "E0601": Code("an integer constant is needed here"),
    "E0602": Code("{value} is outside {low}..{high} of {type}"),
    "E0603": Code("{op} by the constant 0"),
    "E0604": Code("a list of values can only be an initial value"),
    "E0605": Code("a list of values can't initialise {type}"),
    "E0606": Code("{given} values for an array of {room}"),
    "E0607": Code("named values can't initialise {type}"),
    "E0608": Code("the constant {name} depends on itself: {way}", "give one of them a value of its own"),
    # --- E07: files and projects
    "E0701": Code("there is no PROGRAM to run", "write PROGRAM PLC_PRG ... END_PROGRAM"),
    "E0702": Code("a task runs {name}, which is no PROGRAM", "{near}"),
    "E0703": Code("several programs and no task: {names}", "name one of them PLC_PRG, or configure tasks in plc.toml"),
    "E0704": Code("{path} can't be read: {why}"),
    "E0705": Code("there is no .st file in the folder {path}"),
    # --- W08: what a running program does wrong with its motion blocks (plcruntime/warnings.py)
    "W0801": Code(
        "{name} moves {axis} and was not called: the axis went to errorstop",
        "call it in every scan until it is done, outside of IF and CASE: Execute starts a motion, the calls keep it up",
    ),
    "W0802": Code(
        "{name} is started in the first scan, when {axis} can't be on yet, and never again",
        "let the Status of MC_Power, or a step of the program, start it: what is TRUE from the start rises only once",
    ),
    "W0803": Code(
        "{name} was started before {axis} was switched on, so nothing moves",
        "start it when MC_Power shows Status; now its command has to fall and rise again",
    ),
    "W0804": Code(
        "{name} is called before {other}, so it sees {axis} ready a scan late",
        "call MC_Power first, then the blocks that move the axis",
    ),
    "W0805": Code(
        "{name} started {axis} and lost it in the same scan to {other}",
        "one command at a time; what shall follow another is called after it and needs a BufferMode",
    ),
    "W0806": Code(
        "{name} is a second MC_Power for {axis}, beside {other}; the one called last counts",
        "one MC_Power an axis",
    ),
    # --- F: faults of a running program
    "F0101": Code("the index {what} is {value}, outside {low}..{high}"),
    "F0102": Code("integer division by zero"),
    "F0103": Code("{what} is NULL", "let the pointer point to something (ADR) before it is used"),
    "F0104": Code("an address outside the memory of the program was used ({what} = {value})"),
    "F0105": Code("the calls are nested too deeply", "does a function call itself without end?"),
    "F0106": Code("an external function failed: {cause}"),
    "F0107": Code("the program stopped"),
    "F0108": Code("the loop does not end, or the run was interrupted in it"),
}
