# --- Without the GUI: check the document and write FCStd, STEP and STL ---------------------------

import json
import os
import sys
import time
import traceback
import zipfile

import FreeCAD as App
import MeshPart

from .check import broken, fault, watch
from .progress import Cancelled
from .printing import TO_PRINT
from .step import write_step
from .teeth import rebuild, stale

COLOURS = {
    "driver": (0.25, 0.45, 0.70),
    "follower": (0.90, 0.55, 0.15),
    "support": (0.72, 0.74, 0.76),
    "slider": (0.45, 0.65, 0.40),
}


def solid_of(part):
    """The one solid of a part, in assembled position; fails with words when it is not one."""
    if fault(part.Result):
        raise RuntimeError("%s: %s: %s" % (part.Label, part.Result.Label, fault(part.Result)))
    solid = part.Result.Shape.Solids[0].copy()
    solid.check(os.environ.get("MPCGEAR_CHECK") == "full")  # True also finds self-intersections
    solid.Placement = where(part).multiply(solid.Placement)
    return solid


def where(part):
    """Placement of a part; the support is a plain group that never moves."""
    return getattr(part, "Placement", App.Placement())


def show_when_opened(path, shown):
    """Adds to a file that was saved without a window what FreeCAD shows of it; it would open with
    everything hidden. `shown` maps names of objects to their colours, or None."""
    rows = []
    for name, colour in shown.items():
        properties = ['<Property name="Visibility" type="App::PropertyBool"><Bool value="true"/></Property>']
        if colour:
            red, green, blue = (round(255 * share) for share in colour)
            properties.append('<Property name="ShapeColor" type="App::PropertyColor">'
                              '<PropertyColor value="%d"/></Property>'
                              % (red << 24 | green << 16 | blue << 8))
        rows.append('<ViewProvider name="%s" expanded="0"><Properties Count="%d">%s</Properties>'
                    '</ViewProvider>' % (name, len(properties), "".join(properties)))
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("GuiDocument.xml", "<?xml version='1.0' encoding='utf-8'?>\n"
                         '<Document SchemaVersion="1"><ViewProviderData Count="%d">%s'
                         '</ViewProviderData><Camera settings=""/></Document>\n'
                         % (len(rows), "".join(rows)))


def write_all(document, parts, stem, folder):
    """Writes STEM.FCStd, STEM.step and STEM-PART.stl; returns facts about every part."""
    failures = broken(document)
    if failures:
        raise RuntimeError("; ".join(failures))
    path, root = os.path.join(folder, stem), document.Label  # which saving sets to the file's name
    document.saveAs(path + ".FCStd")
    solids = [part.Result for part in parts]
    show_when_opened(path + ".FCStd", dict(
        [(part.Name, None) for part in parts]
        + [(solid.Name, COLOURS.get(part.Name.lower())) for part, solid in zip(parts, solids)]))
    facts, named = {}, []
    for part in parts:
        solid = solid_of(part)
        named.append((part.Name.lower(), solid, COLOURS[part.Name.lower()]))
        mesh = MeshPart.meshFromShape(Shape=solid, LinearDeflection=0.01, AngularDeflection=0.2)
        mesh.write(path + "-" + part.Name.lower() + ".stl")
        facts[part.Name.lower()] = {"volume_mm3": solid.Volume, "faces": len(solid.Faces)}
    write_step(root, named, pieces(document, parts), path + ".step")
    return facts


def pieces(document, parts):
    """[(name, solid as it lies on the bed, colour)] of the bodies that are printed in pieces."""
    found = []
    for link in document.Print.Group:
        piece = link.LinkedObject
        if piece in [part.Result for part in parts]:
            continue  # printed whole
        if fault(piece):
            raise RuntimeError("%s: %s" % (piece.Label, fault(piece)))
        solid = piece.Shape.Solids[0].copy()
        solid.Placement = link.Placement.multiply(solid.Placement)
        name = link.Label[:-len(TO_PRINT)].lower().replace(" ", "_")
        found.append((name, solid, COLOURS[piece.Label.split()[0].lower()]))
    return found


def run_headless(build, design, stem, folder):
    """Builds and writes everything, then leaves FreeCAD: exit code 0 and `"ok": true` in
    STEM.result.json, or exit code 1 and the reason there."""
    started = time.time()
    result = {"ok": False, "stage": "build"}
    try:
        document = App.newDocument(stem)
        parts = build(document, design)
        result.update(stage="write", build_s=round(time.time() - started, 1))
        result["parts"] = write_all(document, parts, stem, folder)
        result.update(ok=True, stage="done")
    except BaseException as error:  # FreeCAD would run the file again and exit with 0
        result.update(error=str(error) or repr(error), trace=traceback.format_exc())
    result["seconds"] = round(time.time() - started, 1)
    with open(os.path.join(folder, stem + ".result.json"), "w") as out:
        json.dump(result, out, indent=1, sort_keys=True)
    print("mpcgear: ok" if result["ok"] else "mpcgear: FAILED: " + result["error"])
    sys.stdout.flush()
    os._exit(0 if result["ok"] else 1)


def run_in_window(build, design, stem):
    """Builds a new document and shows it; where the document before you was made so and its teeth are not
    those of the sheets, builds those anew instead. A cancelled run leaves everything as it was."""
    document = App.ActiveDocument
    old = document is not None and document.getObject("ToothParams") is not None and stale(document)
    try:
        if old:
            rebuild(document)
            document.recompute()
            return
        document = App.newDocument(stem)
        build(document, design)
        show(document)
    except Cancelled:
        if not old:
            App.closeDocument(document.Name)
        App.Console.PrintMessage("mpcgear: cancelled\n")


def show(document):
    """With a window: watches the document, shows the whole mechanism, and says in words what is broken."""
    import FreeCADGui as Gui

    watch()
    failures = broken(document)
    if failures:
        App.Console.PrintError("mpcgear: not ok: %s\n" % "; ".join(failures))
    view = Gui.getDocument(document.Name).activeView()
    view.viewIsometric()
    view.fitAll()
