# --- Print layout: every piece flat on z = 0, side by side -----------------------------------------

import FreeCAD as App

TO_PRINT = " to print"  # ends the label of a piece
GAP = 10.0  # mm between pieces
SAME_FACE = 1e-6  # mm; a face that is so close to the lowest point is the one to lie on


def build_print(document, design, builders):
    """The group `Print`: links to the pieces of every body, turned and set down as they are printed;
    of bodies that are printed whole, to their solids. It is hidden at first."""
    layout = document.addObject("App::DocumentObjectGroup", "Print")
    layout.Label = "Print layout"
    pieces = []
    for body, builder in zip(design["recipe"]["bodies"], builders):
        whole = [(body, builder.part.Result, (0, 0, 1), builder.name)]
        parts = [(piece, builder.piece(piece), piece["up"], piece["name"].replace("_", " ").capitalize())
                 for piece in body["pieces"]]
        for piece, solid, up, name in parts or whole:
            link = document.addObject("App::Link", "Print" + "".join(name.title().split()))
            link.LinkedObject, link.LinkTransform, link.Visibility = solid, False, False
            link.Label = name + TO_PRINT
            layout.addObject(link)
            pieces.append((link, solid, piece["features"], up, builder))
    document.recompute()
    reach = 0.0
    for shown, solid, features, up, builder in pieces:
        turned = App.Rotation(App.Vector(*up), App.Vector(0, 0, 1))
        shape = solid.Shape.copy()
        shape.Placement = App.Placement(App.Vector(), turned).multiply(shape.Placement)
        box = shape.BoundBox
        shown.Placement = App.Placement(
            App.Vector(reach - box.XMin, -(box.YMin + box.YMax) / 2, -box.ZMin), turned)
        reach += box.XLength + GAP
        face = lowest_face(features, up, box.ZMin, solid, builder.expression)
        if face:
            shown.setExpression("Placement.Base.z", "-(%s)" % face)
    layout.Visibility = False
    return layout


def lowest_face(features, up, lowest, evaluator, expression):
    """Expression of the flat face of `features` at the height `lowest` along `up`, if it is one of
    the coordinate directions: the piece then stays on the bed when parameters change."""
    direction = [i for i in range(3) if abs(up[i]) == 1]
    for feature in features if direction else []:
        for text in faces(feature["shape"], direction[0], up[direction[0]]):
            face = expression.length(text)
            if abs(evaluator.evalExpression(face).Value - lowest) < SAME_FACE:
                return face
    return None


def faces(shape, i, sign):
    """Expressions of a primitive's flat faces across axis `i`, as heights along it or against it."""
    (kind, sizes), = shape.items()
    found = []
    if kind == "block":
        found = [sizes["min"][i], sizes["max"][i]]
    elif kind in ("cone", "prism") and abs(sizes["axis"][i]) == 1:
        end = "(%s) %s (%s)" % (sizes["base"][i], "+" if sizes["axis"][i] > 0 else "-", sizes["length"])
        found = [sizes["base"][i], end]
    return [text if sign > 0 else "-(%s)" % text for text in found]
