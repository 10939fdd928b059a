"""Fronts and picks against their definitions."""

import json

import numpy as np
from conftest import MakeStudy

from mpcgear_explore import ranking
from mpcgear_explore.records import Record
from mpcgear_explore.study import Study


def record(key: str, payload: float, plastic: float, height: float = 60.0, state: str = "complete") -> Record:
    figures = {"payload_g": payload, "plastic_g": plastic, "height_mm": height}
    return Record(key, "base", {}, "design", state, "", figures, 1.0, 1.0, 10.0)


def test_a_front_has_all_rows_that_no_other_beats() -> None:
    rows = np.random.default_rng(1).random((60, 3))
    ranks = ranking.fronts(rows)
    for i, row in enumerate(rows):
        beaten = [(other <= row).all() and (other < row).any() for other in rows]
        assert (ranks[i] == 0) == (not any(beaten))
    assert set(ranks) == set(range(ranks.max() + 1))


def test_constraints_come_before_objectives(make_study: MakeStudy) -> None:
    study = Study.read(make_study())
    records = [
        record("far", 2000, 1, height=80),
        record("near", 2000, 1, height=70),
        record("worse", 10, 90),
        record("better", 20, 80),
        record("none", 0, 0, state="infeasible"),
    ]
    assert [records[i].key for i in ranking.best_first(study, records)] == ["better", "worse", "near", "far"]
    assert [records[i].key for i in ranking.pareto(study, records)] == ["better"]


def test_picks_are_the_balanced_design_and_the_ends(make_study: MakeStudy) -> None:
    study = Study.read(make_study())
    records = [record("light", 100, 10), record("middle", 900, 20), record("strong", 1000, 90)]
    picked = ranking.picks(study, records)
    assert [records[p.index].key for p in picked] == ["middle", "strong", "light"]
    assert picked[0].why.startswith("balanced") and "most payload_g" in picked[1].why
    assert "least plastic_g" in picked[2].why
    assert ranking.picks(study, records[:0]) == []
    json.dumps([p.why for p in picked])
