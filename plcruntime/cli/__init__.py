"""The command line: ``scancycle`` (or ``scy``). One module a subcommand, imported when it is called for."""

from __future__ import annotations

import argparse
import importlib
import os
import sys

DONE, FAILED, USAGE, NOT_REACHED, INTERRUPTED = 0, 1, 2, 3, 130
VALUE_HELP = "VAR=VALUE[@TIME]: VALUE as in ST, TIME as 10ms or #120 (scans)"


def main(argv: list[str] | None = None) -> int:
    """Run a command; gives the exit code: 0 done, 1 errors or a fault, 2 usage, 3 --until not reached."""
    for stream in (sys.stdout, sys.stderr):  # a name that the terminal's encoding lacks is no reason to fail
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    arguments = _parser().parse_args(argv)
    from plcruntime.errors import UsageError

    try:
        module = importlib.import_module(f"plcruntime.cli.{arguments.module}")
        code = module.execute(arguments)
        _tell_about_the_cache(arguments.module)
        return code
    except UsageError as error:
        print(f"scancycle: {error}", file=sys.stderr)
        return USAGE
    except ModuleNotFoundError as error:
        if _is_ours(error.name or ""):
            raise
        print(
            f"scancycle: the Python package {error.name} is missing: pip install {error.name}; "
            "scancycle doctor tells what else is", file=sys.stderr,
        )  # fmt: skip
        return USAGE
    except KeyboardInterrupt:
        print("scancycle: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output has enough, as in `scancycle list | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE


def _tell_about_the_cache(command: str) -> None:
    """A cache that can't be written makes every start slow: told once a start, where something was compiled."""
    cache = sys.modules.get("stcore.cache")
    if cache is not None and command != "doctor" and (problem := cache.problem()):
        print(f"scancycle: {problem}; every start compiles anew (SCANCYCLE_CACHE names another)", file=sys.stderr)


def _is_ours(name: str) -> bool:
    """Whether a module should be there in any case: then its absence is a mistake of ours."""
    top = name.split(".")[0]
    return not top or top in ("stcore", "mclib", "plcruntime") or top in sys.stdlib_module_names


class _Version(argparse.Action):
    """Looks the version up only when it is asked for."""

    def __call__(self, parser, *_) -> None:
        from importlib.metadata import version

        print(f"scancycle {version('scancycle')}")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="scancycle", description="Runs IEC 61131-3 Structured Text on a soft PLC with simulated axes.",
        epilog="scancycle COMMAND --help tells more; scancycle demo is the two-minute tour.",
    )  # fmt: skip
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    _add_run(commands)
    check = _command(commands, "check", "check", "parse and type-check; exit code 0 clean or warnings, 1 errors")
    check.add_argument("files", nargs="+", metavar="FILE", help="an .st file, a folder or a plc.toml")
    check.add_argument("--config", metavar="PLC.TOML", help="project settings")
    check.add_argument("--format", choices=("text", "gcc", "json"), default="text", help="of the messages")
    check.add_argument("--strict", action="store_true", help="a mended misprint is an error")
    test = _command(commands, "test", "test", "run the ST tests found in files and folders")
    test.add_argument("paths", nargs="*", metavar="PATH", help="files, or folders with test_*.st (the present one)")
    test.add_argument("-k", metavar="EXPR", help="only tests whose name has these words: timer and not slow")
    test.add_argument("-x", action="store_true", help="stop at the first failure")
    test.add_argument("--watch", action="store_true", help="run again whenever an ST file changes")
    test.add_argument("--junit", metavar="OUT.xml", help="write the results as JUnit XML")
    test.add_argument("--coverage", action="store_true", help="show which statements, branches and CASE states ran")
    test.add_argument("--lcov", metavar="OUT.info", help="write the coverage for LCOV")
    test.add_argument("--cobertura", metavar="OUT.xml", help="write the coverage as Cobertura XML")
    repl = _command(commands, "repl", "repl", "load, stop before the first scan, prompt")
    repl.add_argument("files", nargs="+", metavar="FILE", help="an .st file, a folder or a plc.toml")
    repl.add_argument("--config", metavar="PLC.TOML", help="project settings")
    repl.add_argument("--task-interval", metavar="TIME", help="length of a scan where no task says otherwise (1ms)")
    listing = _command(commands, "list", "listing", "functions and blocks of the library")
    listing.add_argument("pattern", nargs="?", default="*", metavar="PATTERN", help="as MC_* or torque; all without")
    listing.add_argument("--json", action="store_true", help="a list of objects")
    explain = _command(commands, "explain", "explain", "the page of a diagnostic or a fault")
    explain.add_argument("code", metavar="CODE", help="as E0302 or F0101")
    _command(commands, "doctor", "doctor", "versions, cache, processor, what is missing")
    _command(commands, "demo", "demo", "a move, its plot, and what to type next")
    return parser


def _command(commands, name: str, module: str, text: str) -> argparse.ArgumentParser:
    command = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    command.set_defaults(module=module)
    return command


def _add_run(commands) -> None:
    run = _command(commands, "run", "run", "compile and run a program in virtual time")
    add = run.add_argument
    add("files", nargs="+", metavar="FILE", help="an .st file, a folder or a plc.toml")
    add("--config", metavar="PLC.TOML", help="project settings")
    add("--task-interval", metavar="TIME", help="length of a scan where no task says otherwise (1ms)")
    add("--for", dest="duration", metavar="TIME", help="virtual time to run (5s; with --until: its limit, 60s)")
    add("--scans", type=int, metavar="N", help="scans to run")
    add("--until", metavar="EXPR", help="stop when this ST expression is TRUE at the end of a scan; else exit code 3")
    add("--set", action="append", default=[], metavar="VAR=VALUE[@TIME]", help=VALUE_HELP + "; written once")
    add("--force", action="append", default=[], metavar="VAR=VALUE[@TIME]", help="the same, held from then on")
    add("--watch", action="append", default=[], metavar="VAR[,VAR]", help="what to show at the end, trace and plot")
    add(
        "--trace",
        metavar="OUT",
        help="one row a scan into .csv, .npz or .html: the watched variables, else all scalars; --watch '*': every one",
    )
    add("--plot", metavar="OUT", help="draw into .png, .svg or .html: the axes that moved and the watched variables")
    add("--stimuli", action="append", default=[], metavar="FILE", help="a .csv or .toml of times, variables and values")
    add("--trigger", metavar="EXPR", help="trace and plot only around the scan in which this ST expression first holds")
    add("--pre", metavar="TIME", default="50ms", help="virtual time before the trigger (50ms)")
    add("--post", metavar="TIME", default="200ms", help="virtual time after the trigger (200ms)")
    add("--report", metavar="OUT.html", help="a page with plots, cursors, events and the program; needs no network")
    add("--overlay", metavar="RUN.npz", help="draw the trace of another run behind that of the report")
    add("--log-returns", action="store_true", help="show every command that did not return 0: when, where, why")
    add("--retain", metavar="FILE", help="read and keep RETAIN and PERSISTENT variables")
    add("--json", action="store_true", help="print one JSON object")
    add("--strict", action="store_true", help="a mended misprint is an error")
    add("--realtime", action="store_true", help="one second takes one second")
    add(
        "--watchdog",
        metavar="TIME",
        help="wall clock that one scan may take before it is an endless loop (2s; 0s: none)",
    )


if __name__ == "__main__":
    sys.exit(main())
