"""The page is whole, small and asks the network for nothing."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path

from conftest import FAKE, MakeStudy

from mpcgear_explore.__main__ import main


class Parser(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [v or "" for name, v in attrs if name in ("src", "href")]


def made(folder: Path) -> str:
    assert main(["run", str(folder), "--binary", str(FAKE), "--quiet"]) == 0
    return (folder / "report.html").read_text(encoding="utf-8")


def test_the_page_has_everything_in_it(make_study: MakeStudy) -> None:
    text = made(make_study(seed=5, budget={"trials": 16, "minutes": None}))
    parser = Parser()
    parser.feed(text)
    assert parser.links == ["data:,"]
    assert not re.search(r"@@[A-Z]+@@|https?://(?!www\.w3\.org/)", text)
    match = re.search(r'<script type="application/json" id="data">(.*?)</script>', text)
    assert match is not None
    data = json.loads(match[1])
    assert len(data["picks"]) == 3 and all(p["tolerances"]["works"] == 1 for p in data["picks"])
    assert set(data["importance"]) == {"payload_g", "plastic_g"}
    front = [row for row in data["rows"] if row["front"]]
    assert front and all(row["rung"] == 1 and row["page"].startswith("trials/") for row in front)


def test_users_text_cannot_leave_its_place(make_study: MakeStudy) -> None:
    folder = make_study()
    study = json.loads((folder / "study.json").read_text())
    study["name"] = "</script><b>@@DATA@@"
    (folder / "study.json").write_text(json.dumps(study))
    text = made(folder)
    assert "</script><b>" not in text and "&lt;/script&gt;&lt;b&gt;" in text
