"""The search: drafts as Optuna asks for them, then designs of the best, rung by rung."""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import optuna
from distributed import Future

from mpcgear_explore import ranking, records, storage, tables
from mpcgear_explore.pool import Crashed, Pool
from mpcgear_explore.records import Record
from mpcgear_explore.study import Rung, Study, Value
from mpcgear_explore.worker import Request, ask, compute

Tell = Callable[[str], None]

_DRAFTS = 0.5
"""Share of the time that drafts may take."""
TOLERANCE_DRAWS = 1000
"""Gears that are made at random of each pick."""


class Engine:
    """One run of a study."""

    def __init__(self, study: Study, binary: Path, pool: Pool, tell: Tell) -> None:
        self._study = study
        self._binary = binary
        self._pool = pool
        self._tell = tell
        self._started = time.monotonic()
        self._designs: list[float] = []

    def run(self) -> None:
        """Computes what is missing. Raises StudyStopped; what is done by then stays."""
        limits, workers = self._study.limits, self._pool.workers
        self._tell(
            f"{workers} trials at a time, each with {limits.threads} thread(s) and at most {limits.memory_mb} MB"
        )
        self._drafts()
        for rung in range(1, len(self._study.rungs)):
            self._promote(rung)
        self._tolerances()

    def _request(self, values: Mapping[str, Value], rung: Rung) -> Request:
        limits = self._study.limits
        effort = {} if rung.effort is None else {"search.effort": rung.effort}
        is_draft = rung.stage == "draft"
        return Request(
            binary=str(self._binary),
            motion=str(self._study.motion),
            into=str(self._study.into.absolute()),
            set={**values, **effort},
            draft=is_draft,
            timeout_s=limits.draft_s if is_draft else limits.design_s,
            memory_mb=limits.memory_mb,
            threads=limits.threads,
        )

    def _is_late(self, share: float, more_s: float = 0.0) -> bool:
        minutes = self._study.minutes
        return minutes is not None and time.monotonic() - self._started + more_s > share * minutes * 60

    def _slots(self) -> int:
        """Tasks to have under way: a few more than workers, so that none waits for the driver. One worker gets
        one, so that Optuna knows all earlier answers before each question."""
        workers = self._pool.workers
        return 1 if workers == 1 else workers + math.ceil(workers / 2)

    def _flow(self, work: Iterator[tuple[int, Request]]) -> Iterator[tuple[int, Record | str]]:
        """Answers to `work`, which is asked for more only when there is room; a text is why there is none."""
        pending: dict[Future[Any], int] = {}
        more = True
        while more or pending:
            while more and len(pending) < self._slots():
                item = next(work, None)
                more = item is not None
                if item is not None:
                    pending[self._pool.submit(compute, item[1])] = item[0]
            done = self._pool.finished(pending) if pending else set()
            for future in sorted(done, key=lambda f: pending[f]):
                number = pending.pop(future)
                try:
                    yield number, Record.parse(self._pool.result(future))
                except Crashed as crash:
                    yield number, str(crash)

    def _drafts(self) -> None:
        study = self._study
        opened = storage.open_rung(study, 0)
        left = storage.left_running(study, opened)
        told = storage.results(opened)
        done = len(told)
        gears = sum(r is not None and r.is_gear for _, r in told)
        known = {_values(t.params) for t, _ in told} | {_values(values) for values in left.values()}
        for record in records.found(study):
            if self._is_enough(done + len(left)):
                break
            if _values(record.set) not in known and storage.is_within(study, record):
                storage.add(study, opened, record)
                done += 1
                gears += record.is_gear
        for number, answer in self._flow(self._asked(opened, left, done)):
            if isinstance(answer, str):
                storage.fail(opened, number, answer)
            else:
                storage.finish(study, opened, number, answer)
                gears += answer.is_gear
            done += 1
            self._tell(f"drafts {done}{self._of()}: {gears} gears")

    def _of(self) -> str:
        return "" if self._study.trials is None else f" of {self._study.trials}"

    def _is_enough(self, count: int) -> bool:
        return self._study.trials is not None and count >= self._study.trials

    def _asked(
        self, opened: optuna.Study, left: Mapping[int, Mapping[str, Value]], done: int
    ) -> Iterator[tuple[int, Request]]:
        """Trials that an earlier run left, then new ones until the budget is spent."""
        rung = self._study.rungs[0]
        space = storage.distributions(self._study)
        for number, values in left.items():
            done += 1
            yield number, self._request(values, rung)
        while not self._is_enough(done) and not self._is_late(_DRAFTS):
            opened.sampler = storage.sampler(self._study, done)
            trial = opened.ask(space)
            done += 1
            yield trial.number, self._request(trial.params, rung)

    def _promote(self, rung: int) -> None:
        """Designs of the best of the rung below, the best first."""
        study = self._study
        below = tables.unique(
            [r for _, r in storage.results(storage.open_rung(study, rung - 1)) if r is not None]
        )
        count = math.ceil(study.rungs[rung].keep * len(below))
        chosen = [below[i] for i in ranking.best_first(study, below)[:count]]
        paths = [v.path for v in study.variables]
        opened = storage.open_rung(study, rung)
        tried = {_values(trial.params) for trial, _ in storage.results(opened)}
        done = len(tried)
        todo = [r for r in chosen if _values({p: r.set[p] for p in paths}) not in tried]

        def work() -> Iterator[tuple[int, Request]]:
            for number, record in enumerate(todo):
                mean = sum(self._designs) / len(self._designs) if self._designs else 0.0
                if self._is_late(1.0, mean):
                    self._tell("the time is over: the rest stays as drafts")
                    return
                values = {p: record.set[p] for p in paths}
                yield number, self._request(values, study.rungs[rung])

        for _, answer in self._flow(work()):
            done += 1
            if isinstance(answer, str):
                self._tell(f"design {done} of {len(chosen)} cannot be computed: {answer}")
                continue
            self._designs.append(answer.seconds)
            storage.add(study, opened, answer)
            word = "works" if answer.holds(study.constraints) else answer.reason or "breaks a constraint"
            self._tell(f"designs {done} of {len(chosen)}: {answer.key} {word}")

    def _tolerances(self) -> None:
        """Makes gears of every pick at random within the tolerances."""
        study = self._study
        opened = storage.open_rung(study, len(study.rungs) - 1)
        if study.rungs[-1].stage != "design":
            return
        made = [r for _, r in storage.results(opened) if r is not None]
        known: dict[str, Any] = opened.user_attrs.get("tolerances", {})
        keys = [made[pick.index].key for pick in ranking.picks(study, made)]
        futures = {
            key: self._pool.submit(
                ask,
                [str(self._binary), "--json", "load", str(study.into.absolute() / key)]
                + ["--tolerances", str(TOLERANCE_DRAWS), "--seed", str(study.seed)],
            )
            for key in keys
            if key not in known
        }
        spread = {key: self._pool.result(future) for key, future in futures.items()}
        opened.set_user_attr("tolerances", {**known, **spread})


def _values(params: Mapping[str, Value]) -> tuple[tuple[str, Value], ...]:
    """The values of a trial, to be compared: 25 is 25.0."""
    return tuple(sorted(params.items()))
