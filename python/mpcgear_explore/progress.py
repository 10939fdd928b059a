"""What the user sees while a study runs."""

import sqlite3
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import Any

from mpcgear_explore import ranking
from mpcgear_explore.study import Study
from mpcgear_explore.tables import Results

_EVERY_S = 5.0
_LOOK_S = 2.0


class Lines:
    """Lines on standard error: on a terminal the last one is replaced, elsewhere a line every few seconds."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self._is_terminal = sys.stderr.isatty()
        self._started = time.monotonic()
        self._last = -_EVERY_S
        self._kind = ""

    def tell(self, text: str, *, is_last: bool = False) -> None:
        """Shows where the study is; the last line always."""
        now = time.monotonic() - self._started
        kind = text.split(" ", 1)[0]
        is_soon = not self._is_terminal and kind == self._kind and now - self._last < _EVERY_S
        if self._quiet or (is_soon and not is_last):
            return
        end = "\x1b[K\r" if self._is_terminal and kind == "drafts" and not is_last else "\n"
        print(f"{now:7.1f} s  {text}", end=end, file=sys.stderr, flush=True)
        self._last, self._kind = now, kind


def state(study: Study, results: Results) -> str:
    """Where a study is, in one line."""
    drafts, designs = results.rungs[0], [r for rung in results.rungs[1:] for r in rung]
    of = f" of {study.trials}" if study.trials else ""
    holding = sum(r.holds(study.constraints) for r in designs)
    front = len(ranking.pareto(study, results.final))
    return (
        f"drafts {len(drafts)}{of} ({sum(r.is_gear for r in drafts)} gears), designs {len(designs)} "
        f"({holding} work and keep all constraints), {front} on the front, {results.failed} poisoned"
    )


def is_done(study: Study) -> bool:
    """Whether the report is newer than the last trial: it is written at the end of a run. There is a storage."""
    report, database = study.folder / "report.html", study.folder / "study.db"
    return report.is_file() and report.stat().st_mtime >= database.stat().st_mtime


def is_made(database: Path) -> bool:
    """Whether Optuna's storage is there and complete: who opens it earlier completes it, in the way of its maker."""
    if not database.is_file():
        return False
    try:
        with closing(sqlite3.connect(f"{database.absolute().as_uri()}?mode=ro", uri=True)) as storage:
            return storage.execute("SELECT version_num FROM alembic_version").fetchone() is not None
    except sqlite3.OperationalError:
        return False


def watch(study: Study, lines: Lines) -> int:
    """Shows where a study is until its run ends. Returns the exit code."""
    told, done = "", False
    try:
        while not done:
            # Before the first trial there is nothing to read, and a watcher makes nothing.
            if is_made(study.folder / "study.db"):
                done = is_done(study)
                text = state(study, Results.read(study))
                if text != told or done:
                    lines.tell(text, is_last=done)
                told = text
            time.sleep(0.0 if done else _LOOK_S)
        return 0
    except KeyboardInterrupt:
        return 0


def picks(study: Study, results: Results) -> list[dict[str, Any]]:
    """The picked designs: folder, reason, objectives, tolerances."""
    made = []
    for pick in ranking.picks(study, results.final):
        record = results.final[pick.index]
        made.append(
            {
                "folder": str(study.into / record.key),
                "why": pick.why,
                "set": dict(record.set),
                "figures": dict(record.figures),
                "tolerances": results.tolerances.get(record.key),
            }
        )
    return made
