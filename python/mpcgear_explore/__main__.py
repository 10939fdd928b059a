"""`python3 -m mpcgear_explore`: what `mpcgear explore` calls."""

import argparse
import json
import sys
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
    if given.what == "watch":
        return progress.watch(study, lines)
    code, why = (0, "") if given.what == "report" else _run(study, given, lines)
    if why:
        message = {"error": why, "exit_code": code}
        print(json.dumps(message) if given.json else f"error: {why}", file=sys.stderr)
    try:
        results = tables.Results.read(study)
        tables.write(study, results)
        report.write(study, results)
    except OSError as error:
        print(f"error: {error.filename or study.folder}: {error.strerror}", file=sys.stderr)
        return code or STOPPED
    _tell(study, results, given)
    return code


def _run(study: Study, given: argparse.Namespace, lines: progress.Lines) -> tuple[int, str]:
    # Dask and all that takes a second to load; a watcher needs none of it.
    from sqlalchemy.exc import SQLAlchemyError

    from mpcgear_explore.engine import Engine
    from mpcgear_explore.pool import Pool

    try:
        with Pool(given.workers, given.scheduler) as pool:
            Engine(study, given.binary, pool, lines.tell).run()
    except StudyStopped as stopped:
        return STOPPED, str(stopped)
    except SQLAlchemyError as error:
        return STOPPED, f"{study.folder / 'study.db'}: {getattr(error, 'orig', None) or error}"
    except KeyboardInterrupt:
        lines.tell("interrupted; the same command continues")
        return INTERRUPTED, ""
    return 0, ""


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
