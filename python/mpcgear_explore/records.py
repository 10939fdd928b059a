"""Records of trials, as `mpcgear trial` writes them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpcgear_explore.study import Constraint, Objective, Study, Value


@dataclass(frozen=True)
class Record:
    """What came of a trial."""

    key: str
    base: str
    set: Mapping[str, Value]
    stage: str
    state: str
    reason: str
    figures: Mapping[str, float | None]
    seconds: float
    cpu_seconds: float | None
    memory_mb: float | None

    @classmethod
    def parse(cls, raw: Mapping[str, Any]) -> "Record":
        """From `trial.json`; fields that are not ours are passed over."""
        return cls(**{name: raw[name] for name in cls.__dataclass_fields__})

    @property
    def is_gear(self) -> bool:
        """Whether a gear came out."""
        return self.state == "complete"

    def values(self, objectives: tuple[Objective, ...]) -> list[float] | None:
        """The objectives; None where one has no figure."""
        found = [self.figures.get(o.measure) for o in objectives]
        return [v for v in found if v is not None] if self.is_gear and None not in found else None

    def violations(self, constraints: tuple[Constraint, ...]) -> dict[str, float]:
        """By how much each constraint is broken, by name; at most 0 where it holds."""
        broken = {c.measure: c.violation(self.figures.get(c.measure)) for c in constraints}
        return {"gear": -1.0 if self.is_gear else 1.0, **broken}

    def holds(self, constraints: tuple[Constraint, ...]) -> bool:
        """Whether it is a gear that keeps every constraint."""
        return all(v <= 0 for v in self.violations(constraints).values())


def found(study: Study) -> list[Record]:
    """Drafts in the study's folder that set its variables and nothing else, by key: what shards computed."""
    wanted = {v.path for v in study.variables}
    records = []
    for path in sorted(study.into.glob("*/trial.json")):
        record = Record.parse(json.loads(path.read_text(encoding="utf-8")))
        if record.base == study.base and record.stage == "draft" and set(record.set) == wanted:
            records.append(record)
    return records
