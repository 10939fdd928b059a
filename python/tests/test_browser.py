"""The page in a browser: what a person can click, filter and drag does what it says."""

import base64
import hashlib
import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from conftest import FAKE, STUDY, MakeStudy

from mpcgear_explore.__main__ import main

PROBE = Path(__file__).with_name("probe.js")
ERRORS = """window.errors = [];
addEventListener('error', (e) => errors.push(e.message));
addEventListener('securitypolicyviolation', (e) => errors.push(e.effectiveDirective + ' blocks ' + e.blockedURI));"""


def in_browser(page: Path, profile: Path) -> Any:
    """What the probe saw on the page, in Debian's Chromium without a display."""
    text = page.read_text(encoding="utf-8")
    for script, place in ((ERRORS, "<head>"), (PROBE.read_text(encoding="utf-8"), "</body>")):
        element = f"<script>{script}</script>"
        text = text.replace(place, place + element if place == "<head>" else element + place, 1)
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        text = text.replace("script-src ", f"script-src 'sha256-{digest}' ", 1)
    probed = page.with_name("probed.html")
    probed.write_text(text, encoding="utf-8")
    done = subprocess.run(
        ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1240,1000"]
        + ["--virtual-time-budget=5000", "--dump-dom", f"--user-data-dir={profile}", probed.as_uri()],
        capture_output=True,
        text=True,
        timeout=120,
    )
    found = re.search(r"&lt;&lt;([\w+/=]+)&gt;&gt;", done.stdout)
    assert found, done.stderr
    return json.loads(base64.b64decode(found[1]))


@pytest.fixture
def seen(make_study: MakeStudy, tmp_path: Path) -> tuple[Any, list[dict[str, Any]]]:
    """What the probe saw, and the rows that the page shows."""
    three = [*STUDY["objectives"], {"measure": "height_mm", "unit": "mm", "up": False}]
    folder = make_study(seed=5, objectives=three, budget={"trials": 24, "minutes": None})
    assert main(["run", str(folder), "--binary", str(FAKE), "--quiet"]) == 0
    text = (folder / "report.html").read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text)
    assert found
    return in_browser(folder / "report.html", tmp_path / "profile"), json.loads(found[1])["rows"]


def test_a_browser_shows_links_filters_and_opens(seen: tuple[Any, list[dict[str, Any]]]) -> None:
    saw, rows = seen
    gears = [r for r in rows if r["state"] == "complete"]
    designs = [r for r in gears if r["rung"] == 1]

    def look(kept: list[dict[str, Any]]) -> dict[str, Any]:
        drawn = [r for r in kept if r["state"] == "complete"]
        told = f"{len(kept)} of {len(rows)}"
        return {"rows": len(kept), "told": told, "dots": 3 * len(drawn), "paths": len(drawn)}

    assert saw["errors"] == [] and saw["requests"] == []
    assert len(gears) < len(rows) and designs
    # What there is to see.
    assert saw["all"] == look(gears)
    assert len(saw["plots"]) == 3 and "plastic_g over payload_g" in saw["plots"]
    assert saw["axes"] == 6 and saw["bars"] == [3, 3, 3]
    # Clicks: a design's dot, one in each plot, opens its report; a draft has none.
    assert saw["draftsOpened"] == 0
    assert sorted(saw["opened"]) == sorted(3 * [f"trials/{r['key']}/report.html" for r in designs])
    assert set(saw["picks"]) <= set(saw["opened"]) and len(saw["picks"]) == 3
    # Links between the plots.
    assert saw["linked"] == {"dots": 3, "paths": 1, "lines": 1}
    assert "designs 1" in saw["tip"] and "on the front" in saw["tip"] and "payload_g: " in saw["tip"]
    # Filters.
    assert saw["words"] == look([r for r in gears if r["figures"]["payload_g"] >= 500])
    assert saw["designs"] == look(designs)
    assert saw["noGears"] == look(rows)
    values = [r["set"]["gear.a"] for r in rows]  # axes of variables show what was asked for
    middle = (min(values) + max(values)) / 2
    assert saw["brushed"] == look([r for r in gears if r["set"]["gear.a"] <= middle])
    assert 0 < saw["brushed"]["rows"] < len(gears)
    assert saw["cleared"] == look(gears)
    # Order of the table.
    payloads = sorted(float(f"{r['figures']['payload_g']:.4g}") for r in gears)
    assert saw["up"] == payloads and saw["down"] == payloads[::-1]
