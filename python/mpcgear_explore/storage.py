"""Trials in an Optuna storage: one Optuna study for drafts, one for each rung of designs."""

import logging
from collections.abc import Mapping
from dataclasses import asdict

import optuna
from optuna.distributions import (
    BaseDistribution,
    CategoricalDistribution,
    FloatDistribution,
    IntDistribution,
)
from optuna.exceptions import StorageInternalError
from optuna.samplers import BaseSampler, NSGAIISampler, RandomSampler, TPESampler
from optuna.study import StudyDirection
from optuna.trial import FrozenTrial, TrialState
from sqlalchemy.exc import SQLAlchemyError

from mpcgear_explore.records import Record
from mpcgear_explore.study import Study, Value, Variable

RECORD = "record"
"""User attribute of a trial: its record."""
FAILED = "reason"
"""User attribute of a trial that could not be computed: why."""

ERRORS = (StorageInternalError, SQLAlchemyError)
"""What is raised where the storage cannot be read or written: a full disk, a file that is none."""

_STARTUP = 16
"""Trials at random before the sampler learns."""


def quiet() -> None:
    """Warnings of Optuna only."""
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    logging.captureWarnings(True)


def why(study: Study, error: BaseException) -> str:
    """One of ERRORS in a line."""
    cause = error.__cause__ if isinstance(error, StorageInternalError) and error.__cause__ else error
    return f"{study.folder / 'study.db'}: {getattr(cause, 'orig', None) or cause}"


def _distribution(variable: Variable) -> BaseDistribution:
    match variable.kind:
        case "choice":
            return CategoricalDistribution(list(variable.choices))
        case "whole":
            step = int(variable.step or 1)
            return IntDistribution(int(variable.low), int(variable.high), step=step)
        case _:
            return FloatDistribution(variable.low, variable.high, step=variable.step, log=variable.log)


def distributions(study: Study) -> dict[str, BaseDistribution]:
    """Distributions of all variables by path."""
    return {v.path: _distribution(v) for v in study.variables}


def is_within(study: Study, record: Record) -> bool:
    """Whether the study could have asked for this trial."""
    space = distributions(study)
    values = ((space[path], value) for path, value in record.set.items())
    return all(d._contains(d.to_internal_repr(value)) for d, value in values)


def sampler(study: Study, number: int) -> BaseSampler:
    """The sampler for one trial: its draws depend on seed and number alone, so a restart changes nothing."""
    seed = (study.seed * 1_000_003 + number) % 2**32
    match study.sampler:
        case "nsga2":
            return NSGAIISampler(seed=seed, population_size=24)
        case "random":
            return RandomSampler(seed=seed)
        case _:
            return TPESampler(seed=seed, multivariate=True, n_startup_trials=_STARTUP)


def open_rung(study: Study, rung: int) -> optuna.Study:
    """The Optuna study of a rung, made where it is missing."""
    storage = optuna.storages.RDBStorage(study.storage, engine_kwargs={"connect_args": {"timeout": 60}})
    name = f"{study.name}: drafts" if rung == 0 else f"{study.name}: designs {rung}"
    directions = [StudyDirection.MAXIMIZE if o.up else StudyDirection.MINIMIZE for o in study.objectives]
    try:
        # Who only reads does not even try to write.
        return optuna.load_study(storage=storage, study_name=name)
    except KeyError:
        opened = optuna.create_study(storage=storage, study_name=name, directions=directions)
    opened.set_metric_names([o.measure for o in study.objectives])
    return opened


def results(opened: optuna.Study) -> list[tuple[FrozenTrial, Record | None]]:
    """Trials that are finished in the order of their numbers; those that could not be computed have no record."""
    trials = opened.get_trials(deepcopy=False, states=(TrialState.COMPLETE, TrialState.FAIL))
    pairs = [(t, _record(t)) for t in trials if RECORD in t.user_attrs or FAILED in t.user_attrs]
    return sorted(pairs, key=lambda pair: pair[0].number)


def _record(trial: FrozenTrial) -> Record | None:
    raw = trial.user_attrs.get(RECORD)
    return None if raw is None else Record.parse(raw)


def _running(opened: optuna.Study, number: int) -> FrozenTrial:
    trials = opened.get_trials(deepcopy=False, states=(TrialState.RUNNING,))
    return next(trial for trial in trials if trial.number == number)


def finish(study: Study, opened: optuna.Study, number: int, record: Record) -> None:
    """Tells Optuna what came of a running trial."""
    trial = _running(opened, number)
    storage = opened._storage
    storage.set_trial_user_attr(trial._trial_id, RECORD, asdict(record))
    live = optuna.trial.Trial(opened, trial._trial_id)
    for name, violation in record.violations(study.constraints).items():
        live.set_constraint(name, violation)
    opened.tell(number, _values(study, opened, record))


def fail(opened: optuna.Study, number: int, reason: str) -> None:
    """Records a trial that cannot be computed; it is not tried again."""
    trial = _running(opened, number)
    opened._storage.set_trial_user_attr(trial._trial_id, FAILED, reason)
    opened.tell(number, state=TrialState.FAIL)


def add(study: Study, opened: optuna.Study, record: Record) -> None:
    """Adds a trial that was computed without being asked for."""
    params = {v.path: _as_asked(v, record.set[v.path]) for v in study.variables}
    trial = optuna.create_trial(
        params=params,
        distributions=distributions(study),
        values=_values(study, opened, record),
        user_attrs={RECORD: asdict(record)},
        constraints=record.violations(study.constraints),
    )
    opened.add_trial(trial)


def _as_asked(variable: Variable, value: Value) -> Value:
    return float(value) if variable.kind == "number" else value


def _values(study: Study, opened: optuna.Study, record: Record) -> list[float]:
    """The objectives; where there are none the worst so far, which the broken constraint `gear` goes with."""
    values = record.values(study.objectives)
    if values is not None:
        return values
    told = [r.values(study.objectives) for _, r in results(opened) if r is not None]
    rows = [row for row in told if row is not None]
    if not rows:
        return [0.0] * len(study.objectives)
    columns = zip(*rows, strict=True)
    return [min(c) if o.up else max(c) for c, o in zip(columns, study.objectives, strict=True)]


def left_running(study: Study, opened: optuna.Study) -> dict[int, Mapping[str, Value]]:
    """Values of the trials that a killed program left, by number; those that were not asked to the end fail."""
    wanted = {v.path for v in study.variables}
    left: dict[int, Mapping[str, Value]] = {}
    for trial in opened.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
        if set(trial.params) == wanted:
            left[trial.number] = trial.params
        else:
            opened.tell(trial.number, state=TrialState.FAIL)
    return left
