# --- The sheet Check: whether what is shown is what the sheets say ---------------------------------

import FreeCAD as App

from .parameters import TEETH, kept_sheet
from .teeth import SAME, aliases, features

GOOD, BAD = (0.75, 0.93, 0.75, 1.0), (0.95, 0.45, 0.4, 1.0)
SAYS_TEETH, SAYS_SOLIDS = "B2", "B3"


def build_check(document):
    """Builds the sheet; no other object follows it."""
    sheet = kept_sheet(document, "Check")
    for column, width in zip("AB", (190, 520)):
        sheet.setColumnWidth(column, width)
    sheet.set("A1", "Check")
    sheet.setStyle("A1:B1", "bold", "add")
    sheet.set("A2", "Teeth")
    terms = ["abs(%s.%s / 1 mm - %s.Built[%d])" % (TEETH, alias, feature.Name, i)
             for feature in features(document) for i, alias in enumerate(aliases(document))]
    sheet.set(SAYS_TEETH, "=max(%s) > %g ? <<NOT REBUILT: choose 'Rebuild teeth', or run the macro again>> : "
              "<<ok>>" % ("; ".join(terms), SAME))
    sheet.set("A3", "Solids")
    sheet.recompute()
    update(document)


def fault(solid):
    """What is wrong with a feature that has to be one solid; None where nothing is."""
    if not solid.isValid():
        return "does not recompute: " + solid.getStatusString()
    if len(solid.Shape.Solids) != 1:
        return "%d separate solids instead of one" % len(solid.Shape.Solids)
    return None if solid.Shape.isValid() else "the solid is not valid"


def broken(document):
    """Labels of all objects that did not recompute, with FreeCAD's reason, and of bodies that are not one
    valid solid each."""
    said = ["%s: %s" % (o.Label, o.getStatusString()) for o in document.Objects if not o.isValid()]
    bodies = [o.Result for o in document.Objects if "Result" in o.PropertiesList and o.Result.isValid()]
    return said + ["%s: %s" % (solid.Label, fault(solid)) for solid in bodies if fault(solid)]


def update(document):
    """Writes into the sheet what is broken, red where anything is; returns those labels."""
    sheet, failures = document.getObject("Check"), broken(document)
    words = "NOT OK: " + "; ".join(failures) if failures else "ok"
    if sheet.getContents(SAYS_SOLIDS).lstrip("'=") != words:
        sheet.set(SAYS_SOLIDS, words)
        sheet.recompute()
    good = {cell: sheet.get(cell) == "ok" for cell in (SAYS_TEETH, SAYS_SOLIDS)}
    for cell, is_good in good.items():
        sheet.setBackground(cell, GOOD if is_good else BAD)
    sheet.Label = "Check: ok" if all(good.values()) else "Check: NOT OK"
    sheet.purgeTouched()
    return failures


class Watch:
    """Keeps the sheets Check of all documents up to date in a session with a window."""

    watching = None

    def slotRecomputedDocument(self, document):
        """FreeCAD calls it after every recompute."""
        sheet = document.getObject("Check")
        if sheet is not None and sheet.getContents("A1"):  # it is empty while a gear is built
            update(document)


def watch():
    """Begins to watch; once per session."""
    if Watch.watching is None:
        Watch.watching = Watch()
        App.addDocumentObserver(Watch.watching)
