"""From a motion file to a design: what *New gear…* and *Redesign* do, apart from their window."""

import csv
import os
import tempfile

import FreeCAD as App

from . import program
from .program import INFEASIBLE, INTERRUPTED, ProgramError, Run

MOTION, OUT = "motion.toml", "out"
translate = App.Qt.translate


class Job:
    """One motion file with changes of its settings, in a folder of its own."""

    def __init__(self, text, changes=(), folder=None):
        self.folder = folder or tempfile.mkdtemp(prefix="mpcgear-")
        self.changes = [part for change in changes for part in ("--set", change)]
        self.run = self.out = None
        self.is_draft = False
        with open(os.path.join(self.folder, MOTION), "w", encoding="utf-8") as out:
            out.write(text)

    def course(self):
        """The motion over the driver angle before anything is designed: {column: [values]}. Raises
        ProgramError when it is no motion."""
        text = program.ask(["motion", "show", "--csv", MOTION], self.folder)
        rows = list(csv.reader(text.splitlines()))
        return {name: [float(row[i]) for row in rows[1:]] for i, name in enumerate(rows[0])}

    def figures(self):
        """The same in figures: tilt, slide, sharpness, verdict."""
        return program.parsed(program.ask(["motion", "show", MOTION], self.folder))

    def start(self, draft):
        """Begins to design; `run` tells how far it is."""
        self.is_draft = draft
        self.out = os.path.join(tempfile.mkdtemp(prefix="draft-" if draft else "design-", dir=self.folder), OUT)
        arguments = ["design", "--progress", "--out", self.out] + self.changes + ["--", MOTION]
        if draft:
            arguments.insert(1, "--draft")
        self.run = Run(arguments, self.folder)

    def result(self):
        """(path of the design.json, its figures) of the run that has ended. Raises ProgramError with the
        program's reason where there is no gear to show."""
        code, path = self.run.wait(), os.path.join(self.out, "design.json")
        has_bodies = os.path.isdir(os.path.join(self.out, "meshes"))
        if code == 0 or (code == INTERRUPTED and has_bodies):
            return path, program.parsed(self.run.answer())
        if code == INTERRUPTED:
            raise ProgramError(translate("mpcgear", "Cancelled before there was a gear."))
        words = self.run.complaint() or self.run.answer()
        if code == INFEASIBLE:
            answer = program.parsed(self.run.answer())
            words = "\n".join(answer.get("problems", []) + answer.get("remarks", [])) or words
        raise ProgramError(words)


def example(name):
    """The text of an example's motion file. Raises ProgramError when the program knows none of that name."""
    return written(["new", "--example", name])


def written(arguments):
    """The motion file that `mpcgear new` writes."""
    with tempfile.TemporaryDirectory(prefix="mpcgear-") as folder:
        program.ask(arguments + [MOTION], folder)
        with open(os.path.join(folder, MOTION), encoding="utf-8") as source:
            return source.read()


def state(progress):
    """How far a run is, in words."""
    words = progress.get("stage", translate("mpcgear", "beginning"))
    if progress.get("best_hold") is not None:
        words += translate("mpcgear", ", best hold (min Q) %.3f") % progress["best_hold"]
    return words


def told(summary):
    """The figures of a design, in words."""
    words = translate("mpcgear", "K = %(k)d bands of J = %(j)d teeth") % summary
    for name, key in (("min Q", "q_min"), ("η", "eta_min")):
        if summary.get(key) is not None:
            words += ", %s = %.3f" % (name, summary[key])
    kind = translate("mpcgear", "first look, not proved") if summary.get("draft") else (
        translate("mpcgear", "proved to work") if summary.get("feasible") else translate("mpcgear", "does not work"))
    return "%s: %s" % (kind, words)
