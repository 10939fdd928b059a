# --- The sheet Check: whether what is shown is what the sheets say ---------------------------------

import FreeCAD as App

from .parameters import TEETH
from .teeth import SAME, aliases, features

GOOD, BAD = (0.75, 0.93, 0.75, 1.0), (0.95, 0.45, 0.4, 1.0)
SAYS_RECOMPUTED = "B3"


def build_check(document):
    """Builds the sheet; no other object follows it."""
    sheet = document.addObject("Spreadsheet::Sheet", "Check")
    for column, width in zip("AB", (190, 520)):
        sheet.setColumnWidth(column, width)
    sheet.set("A1", "Check")
    sheet.setStyle("A1:B1", "bold", "add")
    sheet.set("A2", "Teeth")
    terms = ["abs(%s.%s / 1 mm - %s.Built[%d])" % (TEETH, alias, feature.Name, i)
             for feature in features(document) for i, alias in enumerate(aliases(document))]
    sheet.set("B2", "=max(%s) > %g ? <<NOT REBUILT: choose 'Rebuild teeth', or run the macro again>> : "
                    "<<ok>>" % ("; ".join(terms), SAME))
    sheet.set("A3", "Recomputed")
    update(document)


def broken(document):
    """Labels of all objects that did not recompute, with FreeCAD's reason."""
    return ["%s: %s" % (o.Label, o.getStatusString()) for o in document.Objects if not o.isValid()]


def update(document):
    """Writes into the sheet what did not recompute, red where anything did not; returns those labels."""
    sheet, failures = document.getObject("Check"), broken(document)
    words = "NOT RECOMPUTED: " + "; ".join(failures) if failures else "ok"
    if sheet is not None and sheet.getContents(SAYS_RECOMPUTED).lstrip("'=") != words:
        sheet.set(SAYS_RECOMPUTED, words)
        sheet.recompute()
    if sheet is not None:
        for row in (2, 3):
            good = str(sheet.get("B%d" % row)) == "ok" if sheet.getContents("B%d" % row) else False
            sheet.setBackground("B%d" % row, GOOD if good else BAD)
    return failures


class Watch:
    """Keeps the sheets Check of all documents up to date in a session with a window."""

    watching = None

    def slotRecomputedDocument(self, document):
        """FreeCAD calls it after every recompute."""
        if document.getObject("Check") is not None:
            update(document)


def watch():
    """Begins to watch; once per session."""
    if Watch.watching is None:
        Watch.watching = Watch()
        App.addDocumentObserver(Watch.watching)
