"""Results of ST tests as JUnit XML, which CI servers read."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as Xml

from plcruntime.st_tests import Result, report


def write(path: Path, results: list[Result], broken: list[tuple[Path, str]]) -> None:
    """One test case a test, an error for each file that can't be compiled. Raises OSError."""
    failed = sum(not r.passed for r in results)
    counts = {"tests": str(len(results) + len(broken)), "failures": str(failed), "errors": str(len(broken))}
    suites = Xml.Element("testsuites")
    seconds = f"{sum(r.seconds for r in results):.6f}"
    suite = Xml.SubElement(suites, "testsuite", name="scancycle", skipped="0", time=seconds, **counts)
    for result in results:
        test = result.test
        place = {"file": test.file, "line": str(test.line), "time": f"{result.seconds:.6f}"}
        case = Xml.SubElement(suite, "testcase", classname=Path(test.file).stem, name=test.name, **place)
        if not result.passed:
            failure = Xml.SubElement(case, "failure", message=_clean(result.message))
            failure.text = _clean(report(result))
    for file, text in broken:
        case = Xml.SubElement(suite, "testcase", classname=file.stem, name=file.name, file=str(file))
        Xml.SubElement(case, "error", message="can't be compiled").text = _clean(text)
    Xml.indent(suites)
    Xml.ElementTree(suites).write(path, encoding="utf-8", xml_declaration=True)


def _clean(text: str) -> str:
    """Without the characters that XML has no way to write."""
    return "".join(c if c in "\t\n" or ord(c) >= 32 else "\ufffd" for c in text)
