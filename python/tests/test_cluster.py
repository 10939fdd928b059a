"""A scheduler and two workers as processes of their own: a worker or the scheduler is killed, then the driver."""

import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pandas as pd
import pytest
from conftest import FAKE, MakeStudy, free_port, until


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[bytes]]]:
    """Starts processes in groups of their own; they are ended with the test."""
    started: list[subprocess.Popen[bytes]] = []

    def one(*arguments: str) -> subprocess.Popen[bytes]:
        with (tmp_path / "output").open("ab") as output:
            process = subprocess.Popen(
                [sys.executable, "-m", *arguments],
                start_new_session=True,
                stdout=output,
                stderr=output,
                cwd=tmp_path,
            )
        started.append(process)
        return process

    yield one
    for process in started:
        kill(process)


def kill(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


@pytest.mark.parametrize("victim", ["worker", "scheduler"])
def test_nothing_is_lost_and_nothing_computed_twice(
    victim: str,
    make_study: MakeStudy,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    start: Callable[..., subprocess.Popen[bytes]],
) -> None:
    folder, log = make_study(budget={"trials": 16, "minutes": None}), tmp_path / "log"
    monkeypatch.setenv("FAKE_LOG", str(log))
    monkeypatch.setenv("FAKE_SECONDS", "0.3")
    port = str(free_port())
    address = f"tcp://127.0.0.1:{port}"

    def cluster() -> list[subprocess.Popen[bytes]]:
        common = ["--host", "127.0.0.1", "--port", port, "--no-dashboard"]
        worker = ["distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        scheduler = start("distributed.cli.dask_scheduler", *common)
        return [scheduler, start(*worker), start(*worker)]

    def driver() -> subprocess.Popen[bytes]:
        return start("mpcgear_explore", "run", str(folder), "--binary", str(FAKE), "--scheduler", address)

    def output() -> str:
        return (tmp_path / "output").read_text()

    def count(word: str) -> int:
        return log.read_text().count(word) if log.exists() else 0

    def three_more() -> None:
        before = count("done")
        until(lambda: count("done") >= before + 3)

    scheduler, worker, _other = cluster()
    running = driver()
    three_more()
    if victim == "worker":
        kill(worker)
    else:
        kill(scheduler)
        until(lambda: running.poll() is not None)
        assert running.returncode == 2 and "error: the scheduler is gone" in output()
        cluster()
        running = driver()
    three_more()
    kill(running)
    # What the workers still have in hand comes to its end without a driver.
    running = driver()
    until(lambda: running.poll() is not None)
    assert running.returncode == 0, output()

    lines = [line.split() for line in log.read_text().splitlines()]
    done = Counter(key for word, key in lines if word == "done")
    begun = Counter(key for word, key in lines if word == "begun")
    assert max(done.values()) == 1, "nothing is computed twice"
    # Only what a killed worker had in hand was begun again.
    assert sum(begun.values()) - sum(done.values()) <= (victim == "worker")
    assert set(begun) == set(done), "nothing is lost"
    table = pd.read_parquet(folder / "study.parquet")
    assert set(table.key) == set(done)
    assert (table.rung == 0).sum() + 2 >= 16 and (table.rung == 1).sum() == 4
