"""`report.html`: the study on one page without network."""

import base64
import hashlib
import html
import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import mpcgear_explore
from mpcgear_explore import ranking
from mpcgear_explore.importance import importances
from mpcgear_explore.records import Record
from mpcgear_explore.study import Study
from mpcgear_explore.tables import Results

PAGE = "report.html"


def write(study: Study, results: Results) -> Path:
    """Writes the page whole or not at all; its path."""
    path = study.folder / PAGE
    draft = path.with_name(f".{PAGE}.new")
    draft.write_text(page(study, results), encoding="utf-8")
    draft.replace(path)
    return path


def page(study: Study, results: Results) -> str:
    """The page as text."""
    script, style = _part("page.js"), _part("page.css")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = (
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    # Nothing in the data can end its element.
    data = json.dumps(content(study, results), allow_nan=False).replace("<", "\\u003c")
    text = _part("page.html")
    # The data come last: what users wrote is not looked at for our marks.
    for name, value in (
        ("POLICY", policy),
        ("TITLE", html.escape(study.name)),
        ("STYLE", style),
        ("SCRIPT", script),
        ("DATA", data),
    ):
        text = text.replace(f"@@{name}@@", value)
    return text


def content(study: Study, results: Results) -> dict[str, Any]:
    """What the page shows."""
    front = {results.final[i].key for i in ranking.pareto(study, results.final)}
    rows = [
        _row(study, record, rung, record.key in front)
        for rung, made in enumerate(results.rungs)
        for record in made
    ]
    everything = [record for made in results.rungs for record in made]
    known = [r.cpu_seconds for r in everything if r.cpu_seconds is not None]
    return {
        "name": study.name,
        "motion": study.motion.name,
        "variables": [v.path for v in study.variables],
        "objectives": [{"measure": o.measure, "unit": o.unit, "up": o.up} for o in study.objectives],
        "constraints": [{"measure": c.measure, "least": c.least, "most": c.most} for c in study.constraints],
        "rungs": ["drafts"] + [f"designs {i}" for i in range(1, len(results.rungs))],
        "rows": rows,
        "picks": [
            {
                "key": results.final[p.index].key,
                "why": p.why,
                "tolerances": results.tolerances.get(results.final[p.index].key),
            }
            for p in ranking.picks(study, results.final)
        ],
        "importance": importances(study, results.rungs[0]),
        "failed": results.failed,
        "cpu_hours": sum(known) / 3600,
    }


def _row(study: Study, record: Record, rung: int, is_front: bool) -> dict[str, Any]:
    measures = [o.measure for o in study.objectives]
    measures += [c.measure for c in study.constraints if c.measure not in measures]
    figures = {name: _short(record.figures.get(name)) for name in measures}
    return {
        "key": record.key,
        "rung": rung,
        "state": record.state,
        "holds": record.holds(study.constraints),
        "front": is_front,
        "set": {v.path: _short(record.set[v.path]) for v in study.variables},
        "figures": figures,
        "reason": record.reason.splitlines()[0][:200] if record.reason else "",
        "page": f"trials/{record.key}/report.html" if rung > 0 and record.is_gear else None,
    }


def _short(value: Any) -> Any:
    return float(f"{value:.5g}") if isinstance(value, float) else value


def _part(name: str) -> str:
    return files(mpcgear_explore).joinpath("page", name).read_text(encoding="utf-8")
