"""The study as `mpcgear explore` has checked it (`study.json`)."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Value = float | int | str | bool


@dataclass(frozen=True)
class Objective:
    """A figure and the way that it should go."""

    measure: str
    unit: str
    up: bool

    @property
    def label(self) -> str:
        """Name and unit, for axes."""
        return f"{self.measure} ({'more' if self.up else 'less'} is better)"


@dataclass(frozen=True)
class Constraint:
    """A figure and its limits."""

    measure: str
    least: float | None
    most: float | None

    def violation(self, value: float | None) -> float:
        """By how much it is broken, as a share of the limit; at most 0 where it holds."""
        if value is None:
            return 1.0
        broken = [-1.0]
        if self.least is not None:
            broken.append((self.least - value) / max(abs(self.least), 1e-9))
        if self.most is not None:
            broken.append((value - self.most) / max(abs(self.most), 1e-9))
        return max(broken)


@dataclass(frozen=True)
class Rung:
    """One rung of the successive halving: drafts, then designs of the best share of the rung below."""

    stage: str
    effort: float | None
    keep: float


@dataclass(frozen=True)
class Variable:
    """A field of the motion file and its values."""

    path: str
    kind: str
    low: float = 0.0
    high: float = 0.0
    step: float | None = None
    log: bool = False
    choices: tuple[Value, ...] = ()


@dataclass(frozen=True)
class Limits:
    """What one trial may take."""

    draft_s: float
    design_s: float
    memory_mb: int
    threads: int


@dataclass(frozen=True)
class Study:
    """A study and its folder."""

    folder: Path
    name: str
    seed: int
    sampler: str
    motion: Path
    base: str
    variables: tuple[Variable, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    rungs: tuple[Rung, ...]
    trials: int | None
    minutes: float | None
    limits: Limits

    @classmethod
    def read(cls, folder: Path) -> "Study":
        """Reads `study.json` in `folder`."""
        raw: Mapping[str, Any] = json.loads((folder / "study.json").read_text(encoding="utf-8"))
        return cls(
            folder=folder,
            name=raw["name"],
            seed=raw["seed"],
            sampler=raw["sampler"],
            motion=Path(raw["motion"]),
            base=raw["base"],
            variables=tuple(_variable(v) for v in raw["variables"]),
            objectives=tuple(Objective(**o) for o in raw["objectives"]),
            constraints=tuple(Constraint(**c) for c in raw["constraints"]),
            rungs=tuple(Rung(**r) for r in raw["rungs"]),
            trials=raw["budget"]["trials"],
            minutes=raw["budget"]["minutes"],
            limits=Limits(**raw["limits"]),
        )

    @property
    def into(self) -> Path:
        """Folder of the trials."""
        return self.folder / "trials"

    @property
    def storage(self) -> str:
        """Address of the Optuna storage."""
        return f"sqlite:///{self.folder / 'study.db'}"


def _variable(raw: Mapping[str, Any]) -> Variable:
    return Variable(**{**raw, "choices": tuple(raw.get("choices", ()))})
