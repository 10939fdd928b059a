"""One worker: the same trials every time, whatever came between."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pandas as pd
import pytest
from conftest import FAKE, STUDY, MakeStudy

from mpcgear_explore import progress
from mpcgear_explore.__main__ import main

COLUMNS = ["gear.a", "gear.b", "gear.c"]


def explore(folder: Path, *more: str) -> int:
    return main(["run", str(folder), "--binary", str(FAKE), "--workers", "1", "--quiet", *more])


def drafts(folder: Path) -> list[tuple[object, ...]]:
    table = pd.read_parquet(folder / "study.parquet")
    return [tuple(row) for row in table[table.rung == 0][COLUMNS].to_numpy()]


def test_the_same_seed_gives_the_same_trials(make_study: MakeStudy) -> None:
    budget = {"trials": 20, "minutes": None}  # the first 16 are at random
    one, two = make_study("one", budget=budget), make_study("two", budget=budget)
    other = make_study("other", seed=4)
    assert [explore(f) for f in (one, two, other)] == [0, 0, 0]
    assert len(drafts(one)) >= 18
    assert drafts(one) == drafts(two)
    assert drafts(one) != drafts(other)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_an_ended_driver_goes_on_with_the_same_trials(
    how: signal.Signals, make_study: MakeStudy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, killed = make_study("whole"), make_study("killed")
    assert explore(whole) == 0
    log = tmp_path / "log"
    monkeypatch.setenv("FAKE_LOG", str(log))
    monkeypatch.setenv("FAKE_SECONDS", "0.1")
    command = [sys.executable, "-m", "mpcgear_explore", "run", str(killed), "--binary", str(FAKE)]
    driver = subprocess.Popen([*command, "--quiet"], start_new_session=True)
    while not log.exists() or log.read_text().count("done") < 4:
        assert driver.poll() is None
        time.sleep(0.02)
    os.killpg(driver.pid, how)
    assert driver.wait() == (130 if how == signal.SIGINT else -how)
    monkeypatch.setenv("FAKE_SECONDS", "0")
    assert explore(killed) == 0
    assert drafts(killed) == drafts(whole)
    done = Counter(line for line in log.read_text().splitlines() if line.startswith("done"))
    assert max(done.values()) == 1


def test_a_finished_study_is_not_computed_again_and_grows_with_its_budget(
    make_study: MakeStudy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = make_study()
    log = tmp_path / "log"
    monkeypatch.setenv("FAKE_LOG", str(log))
    assert explore(folder) == 0
    first, before = drafts(folder), log.read_text()
    assert explore(folder) == 0
    assert log.read_text() == before
    budget = {"trials": 10, "minutes": None}
    (folder / "study.json").write_text(json.dumps({**STUDY, "budget": budget}))
    assert explore(folder) == 0
    assert drafts(folder)[: len(first)] == first and len(drafts(folder)) > len(first)


def test_poisoned_trials_are_recorded_and_passed_over(
    make_study: MakeStudy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    variables = [*STUDY["variables"][:2], {"path": "gear.c", "kind": "choice", "choices": ["good", "poison"]}]
    folder = make_study(variables=variables)
    assert explore(folder) == 0
    log = tmp_path / "log"
    monkeypatch.setenv("FAKE_LOG", str(log))
    table = pd.read_parquet(folder / "study.parquet")
    poisoned = table[table.state == "poisoned"]
    assert len(poisoned) > 0 and set(poisoned.reason) == {"it is poisoned"}
    assert not poisoned.holds.any() and (poisoned.rung == 0).all()
    assert "complete" in set(table.state)
    assert explore(folder) == 0 and not log.exists()


def test_drafts_of_shards_are_taken_over(
    make_study: MakeStudy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, two = make_study("one"), make_study("two", sampler="random", seed=9)
    assert explore(one) == 0
    for path in one.glob("trials/*"):
        path.rename(two / "trials" / path.name)
    log = tmp_path / "log"
    monkeypatch.setenv("FAKE_LOG", str(log))
    assert explore(two) == 0
    assert sorted(drafts(two)) == sorted(drafts(one))
    assert not log.exists()


def test_a_full_disk_is_named_and_nothing_is_lost(
    make_study: MakeStudy, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    whole, full = make_study("whole"), make_study("full")
    assert explore(whole) == 0
    monkeypatch.setenv("FAKE_FULL", "1")
    assert explore(full) == 2
    assert "No space left on device" in capsys.readouterr().err
    monkeypatch.delenv("FAKE_FULL")
    assert explore(full) == 0
    assert drafts(full) == drafts(whole)


def test_a_full_disk_under_the_storage_is_named_too(make_study: MakeStudy) -> None:
    whole, full = make_study("whole"), make_study("full")
    assert explore(whole) == 0
    # Files of at most 100 kB, less than the empty storage takes, are as good as a full disk.
    limited = (
        f"trap '' XFSZ; ulimit -f 200; exec {sys.executable} -m mpcgear_explore run {full} --binary {FAKE}"
    )
    stopped = subprocess.run(["sh", "-c", f"{limited} --quiet"], capture_output=True, text=True)
    assert stopped.returncode == 2
    lines = stopped.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith(f"error: {full / 'study.db'}: "), stopped.stderr
    assert explore(full) == 0
    assert drafts(full) == drafts(whole)


def test_a_program_that_is_not_there_is_named(
    make_study: MakeStudy, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", str(make_study()), "--binary", "no/such/program", "--quiet"]) == 2
    assert "error: no/such/program: No such file or directory" in capsys.readouterr().err


def test_time_ends_a_study(make_study: MakeStudy, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FAKE_SECONDS", "0.2")
    folder = make_study(budget={"trials": 100_000, "minutes": 0.05})
    assert explore(folder) == 0
    assert 0 < len(drafts(folder)) < 20


def test_drafts_of_a_wider_study_are_left_out(make_study: MakeStudy) -> None:
    wide, narrow = make_study("wide"), make_study(
        "narrow",
        variables=[STUDY["variables"][0], {**STUDY["variables"][1], "high": 5}, STUDY["variables"][2]],
    )
    assert explore(wide) == 0
    for path in wide.glob("trials/*"):
        path.rename(narrow / "trials" / path.name)
    assert explore(narrow) == 0
    assert {b for _, b, _ in drafts(narrow)} <= {1, 2, 3, 4, 5}
    wider = {b for _, b, _ in drafts(wide)}
    assert wider - {1, 2, 3, 4, 5}


def test_a_watcher_tells_where_the_study_is_and_ends_with_it(
    make_study: MakeStudy, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = make_study(budget={"trials": 20, "minutes": None})
    monkeypatch.setenv("FAKE_SECONDS", "0.4")
    monkeypatch.setattr(progress, "_EVERY_S", 0.0)
    monkeypatch.setattr(progress, "_LOOK_S", 0.3)
    command = [sys.executable, "-m", "mpcgear_explore", "run", str(folder), "--binary", str(FAKE), "--quiet"]
    driver = subprocess.Popen(command)
    # It is there before the study has anything.
    assert main(["watch", str(folder)]) == 0
    assert driver.wait() == 0
    told = [line.split(" s  ", 1)[1] for line in capsys.readouterr().err.splitlines()]
    assert len(set(told)) >= 5, told
    counts = [int(line.split()[1]) for line in told]
    assert counts == sorted(counts) and counts[0] < 5
    table = pd.read_parquet(folder / "study.parquet")
    drafted, designed = (table.rung == 0).sum(), (table.rung == 1).sum()
    assert told[-1].startswith(f"drafts {drafted} of 20") and f"designs {designed} " in told[-1]
