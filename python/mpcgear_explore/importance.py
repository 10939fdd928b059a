"""How much each variable decides each objective."""

import warnings

import optuna
from optuna.importance import PedAnovaImportanceEvaluator
from optuna.trial import create_trial

from mpcgear_explore.records import Record
from mpcgear_explore.storage import distributions
from mpcgear_explore.study import Study

LEAST = 10
"""Gears that are needed to say anything."""


def importances(study: Study, records: list[Record]) -> dict[str, dict[str, float]]:
    """Share of each variable by objective, from the gears among `records` (PED-ANOVA); empty for too few."""
    gears = [r for r in records if r.values(study.objectives) is not None]
    if len(gears) < LEAST:
        return {}
    space = distributions(study)
    found = {}
    for i, objective in enumerate(study.objectives):
        single = optuna.create_study(direction="maximize" if objective.up else "minimize")
        for record in gears:
            values = record.values(study.objectives) or []
            params = {name: record.set[name] for name in space}
            single.add_trial(create_trial(params=params, distributions=space, value=values[i]))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            evaluator = PedAnovaImportanceEvaluator(target_quantile=0.25)
            shares = optuna.importance.get_param_importances(single, evaluator=evaluator)
        found[objective.measure] = {name: float(share) for name, share in shares.items()}
    return found
