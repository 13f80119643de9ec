"""The table of problem codes: one line per problem, message and hint; ``explain`` prints the page of a code.

E01.. lexing and parsing, W01.. mends of printed listings (errors under --strict), E02.. declarations and types,
E03.. names and expressions, W03.. conversions that may lose something, E04.. calls, E05.. statements,
E06.. constants and initial values, E07.. files and projects, F.... faults of a running program.
"""

from __future__ import annotations

from typing import NamedTuple


class Code(NamedTuple):
    message: str
    hint: str = ""


CODES: dict[str, Code] = {
    # --- E01: lexing and parsing (the parser's own table is stcore/parse_codes.py)
    # --- E02: declarations and types
    "E0201": Code("{name} is declared twice; first at line {line}", "rename one of them or remove it"),
    "E0202": Code("unknown type {name}", "{near}"),
    "E0203": Code("{name} contains itself", "use a POINTER TO {name} instead"),
    "E0204": Code("{name} is not a type"),
    "E0205": Code("the range {low}..{high} is empty", "write the lower bound first"),
    "E0206": Code("{address} is no direct address", "for example %IX0.3, %QB2, %MW4, %MD1"),
    "E0207": Code("{name}: ARRAY[*] is for VAR_IN_OUT only", "give the bounds"),
    "E0208": Code("there is no global variable {name}"),
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
    # --- E07: files and projects
    "E0701": Code("there is no PROGRAM to run", "write PROGRAM PLC_PRG ... END_PROGRAM"),
    "E0702": Code("a task runs {name}, which is no PROGRAM", "{near}"),
    "E0703": Code("several programs and no task: {names}", "name one of them PLC_PRG, or configure tasks in plc.toml"),
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
