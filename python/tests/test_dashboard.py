"""Optuna's dashboard on the storage of a study that runs."""

import json
import subprocess
import sys
import time
import urllib.request
from pathlib import Path
from typing import Any

import pytest
from conftest import FAKE, MakeStudy, free_port, until


def test_the_dashboard_shows_a_study_while_it_runs(
    make_study: MakeStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = make_study(budget={"trials": 30, "minutes": None})
    monkeypatch.setenv("FAKE_SECONDS", "0.4")
    run = [sys.executable, "-m", "mpcgear_explore", "run", str(folder), "--binary", str(FAKE), "--quiet"]
    driver = subprocess.Popen(run)
    until(lambda: (folder / "study.db").is_file())
    time.sleep(1.0)
    port = str(free_port())
    program = Path(sys.executable).with_name("optuna-dashboard")
    dashboard = subprocess.Popen(
        [program, f"sqlite:///{folder / 'study.db'}", "--host", "127.0.0.1", "--port", port]
    )

    def ask(path: str) -> Any:
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/api/{path}", timeout=10) as answer:
                return json.load(answer)
        except OSError:
            return None

    def finished() -> int:
        told = ask("studies/1?after=0")
        return 0 if told is None else sum(trial["state"] == "Complete" for trial in told["trials"])

    try:
        until(lambda: finished() >= 2)
        assert driver.poll() is None, "the study still runs"
        before = finished()
        until(lambda: finished() > before)
        assert driver.wait() == 0
        names = [study["study_name"] for study in ask("studies")["study_summaries"]]
        assert names == ["small: drafts", "small: designs 1"]
        told = ask("studies/1?after=0")
        assert told["directions"] == ["maximize", "minimize"]
        assert told["objective_names"] == ["payload_g", "plastic_g"]
        assert finished() == 30
    finally:
        for process in (driver, dashboard):
            process.kill()
            process.wait()
