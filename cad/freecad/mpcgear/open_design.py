"""Opens a design.json: the same tree that the design's macro builds."""

import json
import os

import FreeCAD as App

from . import builder

FORMAT = 1
STATION_STEP = 3  # every third contact station carries a section, as in the macro


class DesignError(Exception):
    """The file is not a design that can be built; the text says why and what to do."""


def read(path):
    """The design in `path`, its stations thinned to those that carry sections."""
    try:
        with open(path, encoding="utf-8") as source:
            design = json.load(source)
    except (OSError, ValueError) as error:
        raise DesignError("%s cannot be read: %s" % (path, error))
    if not isinstance(design, dict) or "sub_gear_pairs" not in design:
        raise DesignError("%s is not an mpcgear design: choose the design.json that "
                          "'mpcgear design' wrote" % path)
    if design.get("format") != FORMAT:
        raise DesignError("%s has format %s, this add-on reads format %d: update the older of both"
                          % (path, design.get("format"), FORMAT))
    if not design["sub_gear_pairs"] or not design["recipe"]["bodies"]:
        raise DesignError("%s has no finished solids: %s"
                          % (path, "; ".join(design.get("problems", [])) or "no teeth found"))
    for pair in design["sub_gear_pairs"]:
        for tooth in pair["teeth"]:
            stations = tooth["stations"]
            chosen = set(range(0, len(stations), STATION_STEP)) | {len(stations) - 1}
            tooth["stations"] = [stations[i] for i in sorted(chosen)]
    return design


def open_design(path):
    """Builds the design in `path` in a new document and returns the document."""
    design = read(path)
    name = "".join(c for c in design["name"].title() if c.isalnum())
    document = App.newDocument(name or os.path.splitext(os.path.basename(path))[0])
    document.Label = design["name"]
    builder.build(document, design)
    for problem in design.get("problems", []):
        App.Console.PrintWarning("mpcgear: this design is a draft: %s\n" % problem)
    return document
