#!/usr/bin/env python3
"""Stands for `mpcgear` in the tests of the engine: a trial takes a moment, is logged, and left as the program
leaves it. Each trial that is begun and each that is done is one line of the log."""

import fcntl
import hashlib
import json
import os
import sys
import tempfile
import time
from pathlib import Path


def log(word: str, key: str) -> None:
    path = os.environ.get("FAKE_LOG")
    if path:
        with open(path, "a", encoding="utf-8") as file:
            file.write(f"{word} {key}\n")


def value_of(arguments: list[str], name: str) -> str:
    return arguments[arguments.index(name) + 1]


def record(changes: dict[str, float | str], stage: str, key: str) -> dict[str, object]:
    x, y = float(changes["gear.a"]), float(changes["gear.b"])
    state = "poisoned" if changes["gear.c"] == "poison" else "infeasible" if x > 0.95 else "complete"
    better = 0.9 if stage == "design" else 1.0
    figures = {"payload_g": 1000 * x, "plastic_g": better * (10 * x + (y - 5) ** 2), "height_mm": 60 + y}
    return {
        "key": key,
        "base": "base",
        "set": changes,
        "stage": stage,
        "state": state,
        "reason": "" if state == "complete" else f"it is {state}",
        "figures": figures if state == "complete" else {},
        "seconds": 0.05,
        "cpu_seconds": 0.04,
        "memory_mb": 10.0,
    }


def trial(arguments: list[str]) -> dict[str, object]:
    if os.environ.get("FAKE_FULL"):
        print(json.dumps({"error": "study/trials: No space left on device", "exit_code": 2}), file=sys.stderr)
        sys.exit(2)
    pairs = [arguments[i + 1].split("=", 1) for i, word in enumerate(arguments) if word == "--set"]
    changes = {path: json.loads(text) for path, text in pairs}
    stage = "draft" if "--draft" in arguments else "design"
    key = hashlib.sha256(json.dumps([stage, sorted(changes.items())]).encode()).hexdigest()[:24]
    into = Path(value_of(arguments, "--into"))
    found = into / key / "trial.json"
    # As the program does: who is second waits for the first.
    with open(into / f".{key}.lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if found.is_file():
            return {"reused": True, **json.loads(found.read_text(encoding="utf-8"))}
        return made(into, key, changes, stage)


def made(into: Path, key: str, changes: dict[str, float | str], stage: str) -> dict[str, object]:
    log("begun", key)
    time.sleep(float(os.environ.get("FAKE_SECONDS", "0")))
    answer = record(changes, stage, key)
    ready = Path(tempfile.mkdtemp(dir=into, prefix=".ready-"))
    (ready / "trial.json").write_text(json.dumps(answer), encoding="utf-8")
    ready.rename(into / key)
    log("done", key)
    return {"reused": False, **answer}


def main() -> None:
    arguments = sys.argv[1:]
    if arguments[1] == "trial":
        print(json.dumps(trial(arguments)))
    else:
        print(json.dumps({"draws": 1000, "works": 1.0, "play_mm": None, "q_min": None}))


if __name__ == "__main__":
    main()
