"""*Redesign*: a document takes over another design of the same class, and what the user has built on its gears
stays. All that mpcgear has made is made anew; sheets, parts and datums stay the objects they are, since others
stand on them."""

import json

import FreeCAD as App

from . import builder, open_design
from .check import update
from .motions import of_design
from .parameters import cell_of, typed

translate = App.Qt.translate
STAY = ("Spreadsheet::Sheet", "App::Part", "App::Origin", "App::Line", "App::Plane", "PartDesign::Line",
        "PartDesign::Plane", "PartDesign::Point")
SUPPORT = "Support"  # a plain group


class NotRedesigned(Exception):
    """The document cannot take over a design; the text says why and what to do."""


def source(document):
    """What the document's gear was designed for: name, class, motion and settings."""
    sheet = document.getObject("Check") if document is not None else None
    if sheet is None or not getattr(sheet, "Source", ""):
        raise NotRedesigned(translate(
            "mpcgear", "This document does not know its motion: open the design.json of its gear with "
            "'Open mpcgear design…', and redesign that."))
    return json.loads(sheet.Source)


def motion_text(document):
    """The motion file of the document's gear. Raises NotRedesigned where it is not known."""
    return of_design(source(document))


def redesign(document, path):
    """Takes over the design.json at `path` in one step that can be undone. Values that the user has typed
    stay, unless the new design itself has another one there."""
    design, before = open_design.read(path), source(document)
    if design["class"] != before["class"]:
        raise NotRedesigned(translate("mpcgear", "This gear is of class %s and the new one of class %s: use "
                                      "'New gear…'.") % (before["class"], design["class"]))
    document.openTransaction("Redesign")
    try:
        replace(document, design)
    except BaseException:
        document.abortTransaction()
        raise
    document.commitTransaction()


def replace(document, design):
    """Makes all that mpcgear has made anew."""
    check = document.Check
    designed = dict(check.Designed)
    changed = {alias: text for alias, text in typed(document).items() if designed.get(alias, text) != text}
    own = [document.getObject(name) for name in check.Made]
    gone = [o for o in own if o is not None and o.TypeId not in STAY and o.Name != SUPPORT]
    users = [o for o in document.Objects if o.Name not in check.Made]
    links = [link for o in users for link in links_to(o, gone)]
    adopted = {part.Name: part.Result.Shapes[0] for part in document.findObjects("App::Part")
               if "Hub" in part.PropertiesList and part.Hub != part.Result
               and part.Result.Shapes[0] != part.Hub}
    check.clearAll()
    for name in [o.Name for o in gone]:
        document.removeObject(name)
    builder.build(document, design)
    check.Made = [name for name in check.Made if document.getObject(name) not in users]
    for owner, key, value in links:
        setattr(owner, key, relinked(document, value))
    for name, feature in adopted.items():
        result = document.getObject(name).Result
        result.Shapes = [feature] + result.Shapes[1:]
        feature.Visibility = False
    for alias, text in changed.items():
        if check.Designed.get(alias) == designed[alias]:
            sheet, cell = cell_of(document, alias)
            sheet.set(cell, text)
    document.recompute()
    update(document)


class Target:
    """An object that goes, known by its name and label."""

    def __init__(self, gone):
        self.name, self.label = gone.Name, gone.Label

    def now(self, document):
        """The object that has taken its place; None where there is none."""
        same = document.getObjectsByLabel(self.label)
        return same[0] if same else document.getObject(self.name)


def links_to(owner, gone):
    """[(owner, property, its value with `Target`s)] of the properties that link to objects that go."""
    found = []
    for key in owner.PropertiesList:
        if "Link" in owner.getTypeIdOfProperty(key) and "ReadOnly" not in owner.getEditorMode(key):
            value = described(getattr(owner, key), gone)
            if value is not None:
                found.append((owner, key, value))
    return found


def described(value, gone):
    """`value` with a `Target` for each object that goes; None where there is none in it."""
    if value in gone:
        return Target(value)
    if isinstance(value, (list, tuple)):
        inner = [described(item, gone) for item in value]
        if any(item is not None for item in inner):
            return type(value)(own if new is None else new for own, new in zip(value, inner))
    return None


def relinked(document, value):
    """`value` with objects in place of targets."""
    if isinstance(value, Target):
        return value.now(document)
    if isinstance(value, (list, tuple)):
        return type(value)(relinked(document, item) for item in value)
    return value
