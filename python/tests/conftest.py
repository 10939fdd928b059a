"""A small study of the fake program."""

import json
import socket
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import mpcgear_explore

FAKE = Path(__file__).with_name("fake_mpcgear.py")

STUDY: dict[str, Any] = {
    "motion": "my.toml",
    "base": "base",
    "name": "small",
    "seed": 3,
    "sampler": "tpe",
    "variables": [
        {"path": "gear.a", "kind": "number", "low": 0.0, "high": 1.0, "step": None, "log": False},
        {"path": "gear.b", "kind": "whole", "low": 1, "high": 9, "step": 1},
        {"path": "gear.c", "kind": "choice", "choices": ["good", "better"]},
    ],
    "objectives": [
        {"measure": "payload_g", "unit": "g", "up": True},
        {"measure": "plastic_g", "unit": "g", "up": False},
    ],
    "constraints": [{"measure": "height_mm", "least": None, "most": 68.0}],
    "rungs": [
        {"stage": "draft", "effort": None, "keep": 1.0},
        {"stage": "design", "effort": None, "keep": 0.25},
    ],
    "budget": {"trials": 8, "minutes": None},
    "limits": {"draft_s": 10.0, "design_s": 10.0, "memory_mb": 500, "threads": 1},
}

MakeStudy = Callable[..., Path]

LONGEST_S = 60.0


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + LONGEST_S
    while not holds():
        assert time.monotonic() < end, "took too long"
        time.sleep(0.02)


@pytest.fixture(autouse=True)
def packages(monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes that tests start know the packages too."""
    monkeypatch.setenv("PYTHONPATH", str(Path(mpcgear_explore.__file__).parents[1]))


@pytest.fixture
def make_study(tmp_path: Path) -> MakeStudy:
    """Makes a study folder; keywords change the study."""

    def make(name: str = "study", **changes: Any) -> Path:
        folder = tmp_path / name
        (folder / "trials").mkdir(parents=True)
        (folder / "study.json").write_text(json.dumps({**STUDY, **changes}), encoding="utf-8")
        return folder

    return make
