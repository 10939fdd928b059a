"""All trials as one table: `study.csv` and `study.parquet`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from mpcgear_explore import ranking, storage
from mpcgear_explore.records import Record
from mpcgear_explore.study import Study


def unique(made: list[Record]) -> list[Record]:
    """Without those that were asked for again; Optuna does so where values are few."""
    return list({record.key: record for record in made}.values())


@dataclass(frozen=True)
class Results:
    """What a study has found so far."""

    rungs: list[list[Record]]
    """Records by rung, each once."""
    failed: int
    """Trials that could not be computed."""
    tolerances: dict[str, Any]
    """Of each pick, by key: how gears come out that are made with errors."""

    @classmethod
    def read(cls, study: Study) -> "Results":
        """Reads the storage."""
        opened = [storage.open_rung(study, rung) for rung in range(len(study.rungs))]
        told = [storage.results(rung) for rung in opened]
        return cls(
            rungs=[unique([r for _, r in rung if r is not None]) for rung in told],
            failed=sum(r is None for rung in told for _, r in rung),
            tolerances=opened[-1].user_attrs.get("tolerances", {}),
        )

    @property
    def final(self) -> list[Record]:
        """Records of the highest rung."""
        return self.rungs[-1]


def frame(study: Study, results: Results) -> pd.DataFrame:
    """A row per trial: where it is from, what was set, the figures, whether it is on the front or a pick."""
    front = {results.final[i].key for i in ranking.pareto(study, results.final)}
    picked = {results.final[p.index].key: p.why for p in ranking.picks(study, results.final)}
    rows = []
    for rung, made in enumerate(results.rungs):
        for number, record in enumerate(made):
            rows.append(
                {
                    "rung": rung,
                    "number": number,
                    "key": record.key,
                    "stage": record.stage,
                    "state": record.state,
                    "holds": record.holds(study.constraints),
                    "front": record.key in front,
                    "pick": picked.get(record.key, ""),
                    **{v.path: record.set[v.path] for v in study.variables},
                    **record.figures,
                    "seconds": record.seconds,
                    "cpu_seconds": record.cpu_seconds,
                    "memory_mb": record.memory_mb,
                    "reason": record.reason,
                }
            )
    table = pd.DataFrame(rows)
    mixed = [c for c in table.columns if table[c].dtype == object]
    return table.astype({c: "string" for c in mixed}) if mixed else table


def write(study: Study, results: Results) -> None:
    """Writes both files, each whole or not at all."""
    table = frame(study, results)
    for name, write_to in (("study.csv", _csv), ("study.parquet", _parquet)):
        path = study.folder / name
        draft = path.with_name(f".{name}.new")
        write_to(table, draft)
        draft.replace(path)


def _csv(table: pd.DataFrame, path: Path) -> None:
    table.to_csv(path, index=False)


def _parquet(table: pd.DataFrame, path: Path) -> None:
    table.to_parquet(path, index=False)
