"""The `mpcgear` program: where it is, how it is run, what its errors mean."""

import json
import os
import shutil
import subprocess
import sysconfig
from collections.abc import Sequence
from pathlib import Path
from typing import Any

VARIABLE = "MPCGEAR_BINARY"
"""Variable of the environment that names another program."""


class MpcgearError(Exception):
    """The program failed; the message is its own."""


class BadInput(MpcgearError):
    """A file, a value or a folder is wrong (exit code 2)."""


class Infeasible(MpcgearError):
    """The motion cannot be made into a gear (exit code 3)."""


def find() -> Path:
    """The program: `MPCGEAR_BINARY`, or the one installed with this package, or the one on the path.

    Raises MpcgearError where there is none.
    """
    named = os.environ.get(VARIABLE)
    if named:
        return Path(named)
    installed = Path(sysconfig.get_path("scripts")) / ("mpcgear.exe" if os.name == "nt" else "mpcgear")
    if installed.is_file():
        return installed
    on_path = shutil.which("mpcgear")
    if on_path is None:
        raise MpcgearError(f"the program `mpcgear` is not installed; install it or set {VARIABLE}")
    return Path(on_path)


def run(arguments: Sequence[str], accepted: Sequence[int] = (0,)) -> Any:
    """Runs the program with `--json` and returns what it answers.

    Raises BadInput, Infeasible or MpcgearError for exit codes that are not `accepted`.
    """
    done = subprocess.run(
        [str(find()), "--json", *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True
    )
    if done.returncode in accepted and done.stdout:
        return json.loads(done.stdout)
    kinds = {2: BadInput, 3: Infeasible}
    raise kinds.get(done.returncode, MpcgearError)(_message(done.stderr))


def _message(stderr: str) -> str:
    try:
        return str(json.loads(stderr)["error"])
    except (json.JSONDecodeError, KeyError, TypeError):
        return stderr.strip()
