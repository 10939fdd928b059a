"""Runs inside freecadcmd: what a user builds on a hub survives changes of the parameters.

The add-on is installed; MPCGEAR_DESIGN is a design.json; exit code 0 when all holds. An arm
with a pocket stands on the mount and a rounded edge on the hub; the teeth are fused outside of them.
"""

import os
import sys
import tempfile
import traceback

import FreeCAD as App
import Part

from freecad.mpcgear import check, datums, files, open_design, parameters, teeth

ARM, POCKET, ROUND = (30.0, 6.0, 4.0), (20.0, 2.0, 3.0), 0.4  # length, width, height; mm
CHANGES = (
    ("clearance", 1.3), ("mount_thickness", 0.9), ("tip", 0.9), ("mount_radius", 0.97), ("root", 0.9),
    ("rib", 0.9), ("mount_bolt_radius", 0.98), ("thickness", 0.95), ("mount_hole_radius", 0.9),
    ("rib_foot", 1.1), ("clearance", 0.8), ("follower_hub_radius", 0.99),
)


def rectangle(document, name, face, low, high):
    """A sketch of a rectangle on a datum plane."""
    sketch = document.addObject("Sketcher::SketchObject", name)
    face.getParentGeoFeatureGroup().addObject(sketch)
    support = "AttachmentSupport" if "AttachmentSupport" in sketch.PropertiesList else "Support"
    setattr(sketch, support, [(face, "")])
    sketch.MapMode = "FlatFace"
    corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    corners = [App.Vector(x, y, 0) for x, y in corners]
    sketch.addGeometry([Part.LineSegment(a, b) for a, b in zip(corners, corners[1:] + corners[:1])])
    return sketch


def extrusion(document, sketch, height, symmetric=False):
    made = document.addObject("Part::Extrusion", sketch.Name + "Solid")
    sketch.getParentGeoFeatureGroup().addObject(made)
    made.Base, made.DirMode, made.Dir = sketch, "Custom", App.Vector(0, 0, 1)
    made.LengthFwd, made.LengthRev, made.Solid = height, (1.0 if symmetric else 0.0), True
    return made


def build_arm(document):
    """An arm on the mount with a pocket in it, and a rounded rim of the mount."""
    part, face = document.Follower, document.MountFace
    rounded = document.addObject("Part::Fillet", "RoundedRim")
    part.addObject(rounded)
    rounded.Base = part.Hub
    rounded.Edges = [(rim(part.Hub.Shape, face.Placement.Base.z), ROUND, ROUND)]
    arm = extrusion(document, rectangle(document, "UserArm", face, (0, -ARM[1] / 2), (ARM[0], ARM[1] / 2)),
                    ARM[2], symmetric=True)
    pocket = extrusion(document, rectangle(
        document, "UserPocket", face, (ARM[0] - 8, -POCKET[1]), (ARM[0] - 2, POCKET[1])), 10)
    union = document.addObject("Part::MultiFuse", "WithArm")
    part.addObject(union)
    union.Shapes = [rounded, arm]
    cut = document.addObject("Part::Cut", "WithPocket")
    part.addObject(cut)
    cut.Base, cut.Tool = union, pocket
    document.recompute()
    assert datums.adopt(document, cut) == part.Result
    document.recompute()


def rim(shape, height):
    """Number of the longest circle at a height."""
    at = [(edge.Length, i) for i, edge in enumerate(shape.Edges, 1)
          if isinstance(edge.Curve, Part.Circle) and edge.isClosed()
          and abs(edge.BoundBox.ZMin - height) < 1e-6 and abs(edge.BoundBox.ZMax - height) < 1e-6]
    return max(at)[1]


def holds(document, what):
    """The sketches stand on the mount, the arm with its pocket and the rounded rim are there."""
    assert check.broken(document) == [], (what, check.broken(document))
    shape = document.Follower.Result.Shape
    assert len(shape.Solids) == 1 and shape.isValid(), what
    sheet = document.FollowerParams
    face = (sheet.mount_bottom_mm + sheet.mount_thickness_mm).Value
    for name in ("UserArm", "UserPocket"):
        z = document.getObject(name).getGlobalPlacement().Base.z - document.Follower.Placement.Base.z
        assert abs(z - face) < 1e-6, (what, name, z, face)
    for x, y, dz, inside in ((ARM[0] - 1, 0, 2, True), (ARM[0] - 5, 0, 2, False), (12, 0, 2, True),
                             (ARM[0] - 5, 0, -0.5, True)):
        assert shape.isInside(App.Vector(x, y, face + dz), 1e-6, True) == inside, (what, x, y, dz)
    edge = sheet.mount_radius_mm.Value - 0.05
    assert not shape.isInside(App.Vector(0, edge, face - 0.02), 1e-6, True), (what, "no rounded rim")
    assert shape.isInside(App.Vector(0, edge, face - 2 * ROUND), 1e-6, True), what


def change(document, alias, factor):
    sheet, cell = parameters.cell_of(document, alias)
    value = factor * getattr(sheet, alias + "_mm").Value
    sheet.set(cell, "=%.9f" % value)
    document.recompute()
    if teeth.stale(document):
        teeth.rebuild(document)
        document.recompute()


def every_edge_can_be_rounded(document):
    """Each edge of either hub where two faces meet at an angle takes a small fillet."""
    for part in (document.Driver, document.Follower):
        shape, done = part.Hub.Shape, 0
        for i, edge in enumerate(shape.Edges, 1):
            faces = shape.ancestorsOfType(edge, Part.Face)
            if edge.Degenerated or len(faces) < 2 or edge.Length < 1.0:
                continue
            made = shape.makeFillet(0.05, [edge])
            assert made.isValid() and len(made.Solids) == 1, (part.Label, i, edge.Curve, edge.Length)
            done += 1
        assert done >= 6, (part.Label, done)
        short = [e.Length for e in shape.Edges if e.Length < 0.05 and not e.Degenerated]
        assert not short, (part.Label, short)
        thin = [f.Area for f in shape.Faces if f.Area < 0.5]
        assert not thin, (part.Label, thin)


def main():
    document = open_design.open_design(os.environ["MPCGEAR_DESIGN"])
    plain = files.solid_of(document.Follower).Volume
    every_edge_can_be_rounded(document)
    # As wide as the drum, the mount has no face of its own above it: FreeCAD counts edges, and an edge more
    # would be another number for the rim.
    change(document, "mount_radius", 0.98)
    build_arm(document)
    holds(document, "built")
    assert files.solid_of(document.Follower).Volume > plain + 300
    for alias, factor in CHANGES:
        change(document, alias, factor)
        holds(document, (alias, factor))
    path = os.path.join(tempfile.mkdtemp(), "arm.FCStd")
    document.saveAs(path)
    App.closeDocument(document.Name)
    document = App.openDocument(path)
    change(document, "mount_thickness", 1.1)
    holds(document, "opened again")


try:
    main()
    code = 0
except BaseException:  # freecadcmd would run the file again and exit with 0
    traceback.print_exc()
    code = 1
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)
