"""`python3 -m mpcgear_explore`: what `mpcgear explore` calls."""

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path

from mpcgear_explore import progress, report, storage, tables
from mpcgear_explore.study import Study
from mpcgear_explore.worker import StudyStopped

STOPPED = 2
INTERRUPTED = 130


def _arguments(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser("mpcgear_explore", description=__doc__)
    parser.add_argument("what", choices=["run", "watch", "report"])
    parser.add_argument("folder", type=Path, help="folder of the study, made by `mpcgear explore`")
    parser.add_argument("--binary", type=Path, default=Path("mpcgear"), help="the mpcgear program")
    parser.add_argument("--workers", type=int, default=1, help="trials at the same time, here")
    parser.add_argument("--scheduler", help="Dask scheduler to use instead, tcp://host:8786")
    parser.add_argument("--quiet", action="store_true")
    parser.add_argument("--json", action="store_true")
    return parser.parse_args(arguments)


def main(arguments: list[str] | None = None) -> int:
    """Runs, watches or reports a study; returns the exit code."""
    given = _arguments(arguments)
    storage.quiet()
    study = Study.read(given.folder)
    lines = progress.Lines(quiet=given.quiet or given.json)
    code, why = _guarded(study, lambda: _do(study, given, lines))
    if given.what != "watch":
        # What was found until then is shown as well.
        shown, problem = _guarded(study, lambda: _show(study, given))
        code, why = code or shown, why or problem
    if why:
        message = {"error": why, "exit_code": code}
        line = why if code == INTERRUPTED else f"error: {why}"
        print(json.dumps(message) if given.json else line, file=sys.stderr)
    return code


def _do(study: Study, given: argparse.Namespace, lines: progress.Lines) -> int:
    if given.what == "watch":
        return progress.watch(study, lines)
    if given.what == "run":
        # Dask and all that takes a second to load; a watcher needs none of it.
        from mpcgear_explore.engine import Engine
        from mpcgear_explore.pool import Pool

        with Pool(given.workers, given.scheduler) as pool:
            Engine(study, given.binary, pool, lines.tell).run()
    return 0


def _show(study: Study, given: argparse.Namespace) -> int:
    results = tables.Results.read(study)
    tables.write(study, results)
    report.write(study, results)
    _tell(study, results, given)
    return 0


def _guarded(study: Study, work: Callable[[], int]) -> tuple[int, str]:
    """The exit code of some work and what stopped it, if anything did."""
    try:
        return work(), ""
    except StudyStopped as stopped:
        return STOPPED, str(stopped)
    except storage.ERRORS as error:
        return STOPPED, storage.why(study, error)
    except OSError as error:
        return STOPPED, f"{error.filename or study.folder}: {error.strerror or error}"
    except KeyboardInterrupt:
        return INTERRUPTED, "interrupted; the same command continues"


def _tell(study: Study, results: tables.Results, given: argparse.Namespace) -> None:
    picks = progress.picks(study, results)
    if given.json:
        counts = [len(rung) for rung in results.rungs]
        answer = {
            "folder": str(study.folder),
            "report": str(study.folder / report.PAGE),
            "trials": counts,
            "poisoned": results.failed,
            "picks": picks,
        }
        print(json.dumps(answer, indent=2))
    elif not given.quiet:
        for pick in picks:
            print(f"{pick['folder']}\n  {pick['why']}")
        print(f"written: {study.folder / report.PAGE}, study.csv, study.parquet")


if __name__ == "__main__":
    sys.exit(main())
