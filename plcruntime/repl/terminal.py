"""The prompt on a terminal: line editing, completion while typing, history."""

from __future__ import annotations

import threading
from collections.abc import Iterator

from prompt_toolkit import PromptSession
from prompt_toolkit.application import get_app
from prompt_toolkit.completion import Completer, Completion
from prompt_toolkit.document import Document
from prompt_toolkit.filters import Condition
from prompt_toolkit.history import FileHistory, History, InMemoryHistory

from plcruntime.repl.completion import candidates
from plcruntime.repl.entry import incomplete
from plcruntime.repl.session import Session
from stcore import cache


class _Completer(Completer):
    def __init__(self, session: Session) -> None:
        self._session = session

    def get_completions(self, document: Document, complete_event) -> Iterator[Completion]:
        for text, replaced in candidates(self._session, document.text_before_cursor):
            yield Completion(text, -replaced)


def _history(session: Session) -> History:
    """In the folder for state; only for this session where that can't be written."""
    file = cache.state_dir() / "repl_history"
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.open("ab").close()
    except OSError as error:
        session.say(f"no history is kept: {file}: {error.strerror}")
        return InMemoryHistory()
    return FileHistory(str(file))


def lines(session: Session) -> Iterator[str]:
    """What the user types, until Ctrl-D. Ctrl-C clears the line."""
    session.interactive = True
    threading.Thread(target=_warm, name="scancycle imports", daemon=True).start()
    prompt = PromptSession(
        history=_history(session), completer=_Completer(session), complete_while_typing=True,
        multiline=Condition(lambda: incomplete(get_app().current_buffer.text)), prompt_continuation=_more,
    )  # fmt: skip
    while True:
        try:
            yield prompt.prompt(_text(session))
        except KeyboardInterrupt:
            continue
        except EOFError:
            return


def _more(width: int, _line: int, _wrapped: int) -> str:
    """In front of the lines of a text that goes on."""
    return "> ".rjust(width)


def _warm() -> None:
    """What the first answers would else wait for."""
    import numpy  # noqa: F401

    import stcore.side  # noqa: F401


def _text(session: Session) -> str:
    """Where the PLC stands, then >."""
    stop = session.debugger.stop
    if stop is not None:
        return f"{stop.site.pou}:{stop.site.line}> "
    return f"{session.plc.scans}{' fault' if session.plc.fault else ''}> "
