"""What a compilation yields: the module, the first memory image, and where every variable lives in it.

A Program is all that the soft PLC needs to run, show and inspect a program; it holds no syntax tree and can be
pickled. One memory image holds every variable of every instance:

    0 .. 1023            the system area (addresses below): never a variable, so a NULL pointer is always caught
    1024 .. image_end    %I, %Q, %M, then globals, programs and their instances: the image that snapshots copy
    image_end .. limit   SIDE_SIZE bytes for side modules (stcore/side.py), above them the stack of functions' own
                         arrays, strings and structures
    then                 in a probed build: a count and a flag for each site; a flag above 1 is a slot in the table of
                         hooks, whose function tells whether to stop
    limit ..             what the host allocates: trace buffers and tables
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from stcore.diagnostics import Diagnostic
from stcore.types import Block, Type

# The system area: little-endian words that the module and the host share.
NOW = 16  # LINT, virtual time in ns since the start, as the running scan sees it
SCAN = 24  # LINT, number of scans finished
INTERVAL = 32  # LINT, length of a scan in ns
INTERRUPT = 40  # DINT, set by the host to stop a loop that does not end
HOST_FAILED = 44  # DINT, set by the host when an external function failed: the call then is a fault
FAULT_A = 48  # LINT, values of the check that failed (index, pointer)
FAULT_LOW = 56  # LINT, lower bound
FAULT_HIGH = 64  # LINT, upper bound
FORCES = 72  # UDINT address, UDINT count: table of (UDINT address, UDINT size 1 or 8, 8 bytes value, mask)
TRACE = 80  # UDINT address of the control words of the recorder (plcruntime/recorder.py); 0 when nothing is recorded
UNTIL = 96  # DINT, number of conditions that end a run: those in the first slots of the table
STOP = 100  # DINT, probed builds: 0 run on, 1 stop at flagged sites, 2 at every statement that is not too deep
DEPTH = 104  # DINT, probed builds: calls of POUs that are under way
STOP_DEPTH = 108  # DINT, probed builds: the depth up to which STOP = 2 stops
ALONE = 112  # DINT, the number (from 1) of the test that runs; 0 none
ASKING = 116  # DINT, probed builds: 1 while the condition of a breakpoint is asked: a fault is then its own
TASK_RATIOS = 128  # DINT for each task: it runs when SCAN MOD ratio = 0
NULL_PAGE = 1024
HOOK_SLOTS = range(48, 64)  # of the table of hooks: conditions of breakpoints; those below are conditions of a run
SIDE_SIZE = 64 * 1024  # bytes below the stack for the constants of side modules


@dataclass(slots=True)
class Variable:
    """A global variable, or the instance of a program. path as a user types it: 'PLC_PRG', 'GVL.x', 'x'."""

    name: str
    path: str
    type: Type
    address: int
    constant: bool = False
    retain: bool = False
    persistent: bool = False
    library: bool = False
    direct: str | None = None  # %IX0.0
    bit: int | None = None  # of a BOOL at a bit address
    file: str = ""
    line: int = 0
    attributes: dict = field(default_factory=dict)


@dataclass(slots=True)
class Site:
    """A place in the source that a fault or a stop can name: one for each statement and check."""

    file: str
    line: int
    column: int
    pou: str
    code: str = ""  # of the fault that a check here raises: 'F0101' ...; '' for a statement
    note: str = ""  # what the check looks at: the text of the index or pointer; the callee's for a call
    within: int = -1  # the site of the call, for code that was taken into its caller; -1 if it was not


class Sites(Sequence[Site]):
    """The sites of a module by their numbers. They are kept as tuples, which are read back ten times as fast."""

    __slots__ = ("_rows",)

    def __init__(self) -> None:
        self._rows: list[tuple] = []

    def add(self, *fields) -> int:
        """The number of a new site, from the fields of Site."""
        self._rows.append(fields)
        return len(self._rows) - 1

    def __getitem__(self, number: int) -> Site:
        return Site(*self._rows[number])

    def __len__(self) -> int:
        return len(self._rows)


@dataclass(slots=True)
class External:
    """A FUNCTION of the library that the host provides (``{attribute 'external'}``).

    parameters: (name, Type); elementary values arrive as Python numbers, anything else as its address.
    """

    name: str
    parameters: list[tuple[str, Type]]
    result: Type | None


@dataclass(slots=True)
class Parameter:
    """A parameter of a function. default: the bytes of its initial value, b'' when they are all zero. room_of: as of
    its variable."""

    name: str
    type: Type
    section: str
    constant: bool = False
    default: bytes = b""
    room_of: str = ""


@dataclass(slots=True)
class Routine:
    """The code of a POU under the name by which the module exports it, for side modules and tests; no name where all
    of it was taken into its callers.

    parameters, result: of a FUNCTION or METHOD; a block has its own in its type. actions: upper-case name -> export.
    chooser: the export that finds out which code an instance has in the place of this method or body; '' where there is
    only this one.
    test: of a method that is a test, the export that runs it on an instance of its own.
    """

    name: str
    kind: str
    export: str
    parameters: list[Parameter] = field(default_factory=list)
    result: Type | None = None
    actions: dict[str, str] = field(default_factory=dict)
    library: bool = False
    file: str = ""
    line: int = 0
    attributes: dict = field(default_factory=dict)
    chooser: str = ""
    test: str = ""


@dataclass(slots=True)
class Branch:
    """A way that an IF, a CASE or a loop can take, counted in a probed build.

    site: of the statement; kind: IF, CASE or LOOP; label: the condition, the labels of a CASE, ELSE (written or not)
    or what a loop did; line: where the label stands."""

    site: int
    kind: str
    label: str
    line: int


@dataclass(slots=True)
class Body:
    """The code of a POU or an action in a probed build: what can be seen when it stops there.

    block: the type of its instance, None for a function. address: of a program's one instance. locals: name, type,
    offset in the stack frame, and whether the frame holds the variable's address. hook: called after the tasks.
    """

    pou: str
    block: Block | None
    address: int | None
    locals: list[tuple[str, Type, int, bool]]
    library: bool
    hook: bool


@dataclass(slots=True)
class TaskSpec:
    """A task of the configuration: programs in order, every `interval` ns, highest priority (lowest number) first.

    test: it runs in every scan while the host has chosen it, and never else. Tests come after the other tasks.
    """

    name: str
    programs: list[str]
    interval: int | None = None
    priority: int = 0
    test: bool = False


@dataclass(slots=True)
class Program:
    """A compiled program. See the module's docstring for the memory."""

    wasm: bytes
    image: bytes  # the first memory image, from 0 to image_end
    image_end: int
    limit: int
    inputs: tuple[int, int] = (0, 0)  # address and size of %I
    outputs: tuple[int, int] = (0, 0)  # of %Q
    markers: tuple[int, int] = (0, 0)  # of %M
    variables: dict[str, Variable] = field(default_factory=dict)  # upper-case path -> global or program instance
    aliases: dict[str, str] = field(default_factory=dict)  # upper-case name -> the path that it stands for
    accesses: dict[str, tuple[str, bool]] = field(default_factory=dict)  # VAR_ACCESS: name -> path, whether read only
    types: dict[str, Type] = field(default_factory=dict)  # upper-case name -> named type (struct, enum, block)
    functions: dict[int, str] = field(default_factory=dict)  # index of a function of the module -> POU name
    sites: Sequence[Site] = field(default_factory=Sites)
    externals: list[External] = field(default_factory=list)
    tasks: list[TaskSpec] = field(default_factory=list)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    files: list[str] = field(default_factory=list)  # of the user, then of the library
    libraries: list[str] = field(default_factory=list)  # folders that library names come from
    routines: dict[str, Routine] = field(default_factory=dict)  # upper-case name -> POU in the module, the user's first
    bodies: list[Body] = field(default_factory=list)  # of a probed build
    probed: dict[int, int] = field(default_factory=dict)  # statements, where a probed build can stop: site -> body
    branches: list[Branch] = field(default_factory=list)  # of a probed build
    taken: set[tuple[int, int]] = field(default_factory=set)  # where variables begin and end whose address is taken
    constants_at: int = 0  # where strings and templates begin, behind all variables; 0: at image_end
    digest: str = ""  # of all texts that it was made of; the same in a probed build
    probes: int = 0  # address of the counts of sites, then of branches (4 bytes each), then the flags; 0: not probed

    @property
    def flags(self) -> int:
        """Where the flags of the sites begin in a probed build, a byte each."""
        return self.probes + 4 * (len(self.sites) + len(self.branches))

    @property
    def state_end(self) -> int:
        """The end of what a program changes in its image; the same in a probed build, unlike what comes behind it."""
        return self.constants_at or self.image_end

    @property
    def timed(self) -> list[TaskSpec]:
        """The tasks that are not tests."""
        return [task for task in self.tasks if not task.test]

    @property
    def stack_top(self) -> int:
        """The end of the stack, and of all memory that the program may use."""
        return self.probes or self.limit

    def programs(self) -> list[Variable]:
        """The user's program instances, in order."""
        return [
            v for v in self.variables.values()
            if isinstance(v.type, Block) and v.type.kind == "PROGRAM" and not v.library
        ]  # fmt: skip
