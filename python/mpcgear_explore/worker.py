"""What a worker does: it asks the program for one trial and waits. Imports nothing heavy."""

import json
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

RETRIES = 2
"""How often a trial is asked for again when the program that watches over it was killed."""


class StudyStopped(Exception):
    """Something that is not the trial's fault and would meet all others too: a full disk, a bad file."""


@dataclass(frozen=True)
class Request:
    """A trial to be computed."""

    binary: str
    motion: str
    into: str
    set: Mapping[str, float | int | str | bool]
    draft: bool
    timeout_s: float
    memory_mb: int
    threads: int

    def command(self) -> list[str]:
        """The command that computes it."""
        command = [self.binary, "--json", "trial", "--into", self.into]
        command += ["--timeout", repr(self.timeout_s), "--memory-mb", str(self.memory_mb)]
        command += ["--threads", str(self.threads)]
        if self.draft:
            command.append("--draft")
        for path, value in self.set.items():
            command += ["--set", f"{path}={json.dumps(value)}"]
        return [*command, "--", self.motion]


def compute(request: Request) -> dict[str, Any]:
    """The record of a trial, computed or found. Raises StudyStopped."""
    return ask(request.command())


def ask(command: list[str]) -> dict[str, Any]:
    """What the program answers to a command with `--json`. Raises StudyStopped."""
    for _ in range(RETRIES + 1):
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
        except OSError as error:
            raise StudyStopped(f"{command[0]}: {error.strerror}") from error
        if done.returncode == 0:
            answer: dict[str, Any] = json.loads(done.stdout)
            return answer
        if done.returncode >= 0:
            break
    try:
        message = json.loads(done.stderr)["error"]
    except (json.JSONDecodeError, KeyError, TypeError):
        message = done.stderr.strip() or f"`{command[0]}` ended with {done.returncode}"
    raise StudyStopped(message)
