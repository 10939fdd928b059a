# --- STEP: bodies and pieces as named, coloured solids below a root that has the design's name ----------
# Without a window FreeCAD writes no colours, so they are added to what it has written.

import re

import FreeCAD as App
import Import

SOLID = re.compile(r"ADVANCED_BREP_SHAPE_REPRESENTATION\s*\(\s*'[^']*'\s*,\s*\(([^)]*)\)\s*,\s*(#\d+)\s*\)")
BESIDE = 10.0  # mm between the bodies and the pieces
# What gives the solid {solid} a colour; {0} to {8} are numbers of entities, {context} is the solid's own.
STYLE = """#{0}=COLOUR_RGB('',{red:.4f},{green:.4f},{blue:.4f});
#{1}=FILL_AREA_STYLE_COLOUR('',#{0});
#{2}=FILL_AREA_STYLE('',(#{1}));
#{3}=SURFACE_STYLE_FILL_AREA(#{2});
#{4}=SURFACE_SIDE_STYLE('',(#{3}));
#{5}=SURFACE_STYLE_USAGE(.BOTH.,#{4});
#{6}=PRESENTATION_STYLE_ASSIGNMENT((#{5}));
#{7}=STYLED_ITEM('color',(#{6}),{solid});
#{8}=MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#{7}),{context});
"""


def write_step(root, bodies, pieces, path):
    """Writes `bodies` where they are assembled and, where there are any, `pieces` to print beside them; each
    [(name, solid, (red, green, blue))], AP214, mm, whatever the user's preferences are."""
    scratch = App.newDocument("Step", hidden=True)
    whole = scratch.addObject("App::Part", "Root")
    whole.Label = root
    add_solids(whole, bodies)
    if pieces:
        beside = whole.newObject("App::Part", "Pieces")
        beside.Label = "pieces to print"
        room = min(solid.BoundBox.YMin for _, solid, _ in bodies) - max(s.BoundBox.YMax for _, s, _ in pieces)
        beside.Placement.Base.y = room - BESIDE
        add_solids(beside, pieces)
    preferences = App.ParamGet("User parameter:BaseApp/Preferences/Mod/Part/STEP")
    before = preferences.GetString("Scheme", "AP214IS")
    preferences.SetString("Scheme", "AP214IS")
    try:
        Import.export([whole], path)
    finally:
        preferences.SetString("Scheme", before)
        App.closeDocument(scratch.Name)
    paint(path, [colour for _, _, colour in bodies + pieces])


def add_solids(part, solids):
    """Named solids in a part."""
    for name, solid, _ in solids:
        made = part.newObject("Part::Feature", name)
        made.Label, made.Shape = name, solid


def paint(path, colours):
    """Gives the solids of a STEP file without colours theirs, in order."""
    with open(path, encoding="latin-1") as source:
        text = source.read()
    found = SOLID.findall(text)
    if len(found) != len(colours) or "STYLED_ITEM" in text:
        return  # another FreeCAD has written it in another way, perhaps with colours of its own
    number, styles = max(int(n) for n in re.findall(r"^#(\d+)", text, re.MULTILINE)), ""
    for (items, context), (red, green, blue) in zip(found, colours):
        solid = items.split(",")[-1].strip()
        styles += STYLE.format(*range(number + 1, number + 10), solid=solid, context=context,
                               red=red, green=green, blue=blue)
        number += 9
    head, tail = text.rsplit("ENDSEC;", 1)
    with open(path, "w", encoding="latin-1") as out:
        out.write(head + styles + "ENDSEC;" + tail)
