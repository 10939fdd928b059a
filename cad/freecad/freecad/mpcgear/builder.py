# --- The tree: parameters, sections, hubs, teeth, joints, one part per body -----------------
# Everything is built of plain Spreadsheet, Sketcher and Part objects, so that the document opens and
# hubs recompute wherever FreeCAD runs, with nothing of mpcgear installed. Lengths are mm.

import json
import math
import re

import FreeCAD as App

from .check import build_check
from .datums import build_datums
from .files import COLOURS
from .options import OptionTools, build_options, option_rows
from .parameters import Expression, build_parameters, kept, number, typed
from .poses import build_poses, follower_poses, place, vector
from .printing import build_print
from .sections import build_sections
from .teeth import bands, rebuild, store

MESH_OVERLAP = " + 0.01"  # mm; how far the recipe's cones reach into drums, for the sake of meshes


def build(document, design):
    """Fills `document` with the mechanism of `design` (the content of design.json)."""
    document.Label = design["name"]
    names = build_parameters(document, design)
    build_options(document, design, names)
    build_poses(document, design)
    build_sections(document, design)
    document.recompute()
    builders = [BodyBuilder(document, design, names) for _ in design["recipe"]["bodies"]]
    parts = [builder.build(body) for builder, body in zip(builders, design["recipe"]["bodies"])]
    build_datums(document, design, names)
    rebuild(document)
    build_print(document, design, builders)
    build_check(document)
    phi, pose = follower_poses(design)[0]
    place(document, design["settings"]["gear"]["center_distance_mm"], phi, pose)
    remember(document, design)
    document.recompute()
    return parts


def remember(document, design):
    """Keeps in the sheet Check what a redesign asks for: what was built, the values before anybody changed
    them, and what the gear was designed for (where the design tells)."""
    wanted = {key: design[key] for key in ("name", "class", "motion", "settings")} if "motion" in design else {}
    for kind, name, value, words in (
        ("App::PropertyStringList", "Made", [o.Name for o in document.Objects], "Objects that mpcgear has made"),
        ("App::PropertyMap", "Designed", typed(document), "Values as designed"),
        ("App::PropertyString", "Source", json.dumps(wanted) if wanted else "", "What the gear was designed for"),
    ):
        if name not in document.Check.PropertiesList:
            document.Check.addProperty(kind, name, "mpcgear", words)
            document.Check.setEditorMode(name, 2)
        setattr(document.Check, name, value)


class BodyBuilder:
    """Builds one body of the recipe as a part of plain Part objects."""

    def __init__(self, document, design, names):
        self.document, self.design, self.names = document, design, names
        self.expression = Expression(names)
        self.primitives = {}

    def build(self, body):
        """The part of `body`. Its `Hub` is the body without teeth, which the user's own features
        build on; its `Result` is the finished solid: what the user has made of the hub, with teeth."""
        self.name = body["name"].title()
        self.colour = COLOURS.get(body["name"], (0.8, 0.8, 0.8))
        moves = body["name"] != "support"  # a plain group has no origin: seven objects less
        kind = "App::Part" if moves else "App::DocumentObjectGroup"
        self.part = kept(self.document, kind, self.name)
        steps = runs(body["features"])
        if body["name"] in option_rows(self.design):
            options = OptionTools(self, body["name"])
            steps[0][1].extend(options.first(*bands(self.design, body.get("teeth"))))
            for operation, tools in (("add", options.last()), ("cut", options.cut())):
                if tools and steps[-1][0] != operation:
                    steps.append((operation, []))
                steps[-1][1].extend(tools)
        hub = solid = self.combined(steps, self.name)
        hub.Label = self.name + (" hub" if body.get("teeth") else " solid")
        if body.get("teeth"):
            teeth = self.new("Part::Feature", self.name + " Teeth")
            teeth.Label = self.name + " teeth"
            store(teeth, self.design, body["teeth"])
            solid = self.boolean("MultiFuse", self.name + " Solid", Shapes=[hub, teeth])
            solid.Refine = False  # the hub is refined, teeth have no flat faces: it would find nothing
            solid.Label = self.name + " solid"
        solid.Visibility = True
        for key, value, words in (("Result", solid, "The finished solid"),
                                  ("Hub", hub, "The body without teeth, to build on")):
            if key not in self.part.PropertiesList:
                self.part.addProperty("App::PropertyLinkChild", key, "mpcgear", words)
            setattr(self.part, key, value)
        return self.part

    def piece(self, piece):
        """The solid of a piece to print, in the body's part; it shares primitives with the body."""
        name = "%s %s" % (self.name, piece["name"].replace("_", " "))
        solid = self.combined(runs(piece["features"]), name)
        solid.Label = name
        return solid

    def combined(self, steps, name):
        """One refined solid of (operation, recipe features or finished tools)."""
        solid = None
        for operation, features in steps:
            made = [self.primitive(f) if isinstance(f, dict) else f for f in features]
            solid = self.combine(operation, solid, made, name)
        return solid

    def new(self, kind, name):
        """A new hidden object in the part."""
        made = self.document.addObject(kind, re.sub(r"\W+", "", name.title()) or "Object")
        self.part.addObject(made)
        made.Visibility = False
        if App.GuiUp and hasattr(made.ViewObject, "ShapeColor"):
            made.ViewObject.ShapeColor = self.colour  # booleans take theirs from their inputs
        return made

    def combine(self, operation, solid, tools, name):
        """`solid` with all `tools` added, cut away, or kept in common."""
        if operation == "add":
            shapes = ([solid] if solid else []) + tools
            if len(shapes) == 1:
                return shapes[0]
            return self.boolean("MultiFuse", name + " Union", Shapes=shapes)
        if operation == "keep":
            for tool in tools:
                solid = self.boolean("MultiCommon", name + " Common", Shapes=[solid, tool])
            return solid
        tool = tools[0]
        if len(tools) > 1:
            tool = self.boolean("MultiFuse", name + " Cutters", Shapes=tools)
        return self.boolean("Cut", name + " Cut", Base=solid, Tool=tool)

    def boolean(self, kind, name, **inputs):
        """A boolean feature with its inputs, whose faces are whole whatever the user's preferences."""
        made = self.new("Part::" + kind, name)
        made.Refine = True
        for key, value in inputs.items():
            setattr(made, key, value)
        return made

    def primitive(self, feature):
        """One recipe feature as a parametric Part primitive; equal ones of a body are one."""
        key = repr(sorted(feature["shape"].items()))
        if key not in self.primitives:
            (kind, shape), = feature["shape"].items()
            makers = {"cone": self.cone, "block": self.block, "ball": self.ball, "prism": self.prism}
            if kind not in makers:
                raise ValueError("feature %s of the design has an unknown shape: %s"
                                 % (feature["name"], kind))
            made = makers[kind](feature["name"], shape)
            made.Label = "%s %s" % (self.name, feature["name"])
            self.primitives[key] = made
        return self.primitives[key]

    def follow(self, made, key, text):
        """Lets a property of `made` follow a recipe expression. Constants are set instead: FreeCAD
        0.20 skips constant expressions of a primitive at times."""
        expression = self.expression.length(text)
        if "Params." in expression:
            made.setExpression(key, expression)
            return
        value = made.evalExpression(expression)
        if key.startswith("Placement.Base."):
            base = made.Placement.Base
            setattr(base, key[-1], value.Value)
            made.Placement.Base = base
        else:
            setattr(made, key, value)

    def stand(self, made, base, axis=(0, 0, 1)):
        """Puts `made` at `base` with its z along `axis`: turned about y, then about z."""
        axis = vector(axis).normalize()
        polar = math.degrees(math.acos(max(-1.0, min(1.0, axis.z))))
        azimuth = math.degrees(math.atan2(axis.y, axis.x))
        made.Placement.Rotation = App.Rotation(App.Vector(0, 0, 1), azimuth).multiply(
            App.Rotation(App.Vector(0, 1, 0), polar))
        for coordinate, text in zip("xyz", base):
            self.follow(made, "Placement.Base." + coordinate, text)

    def cone(self, name, shape):
        """Part::Cylinder where both radii are the same expression, else Part::Cone."""
        if shape["r0"] == shape["r1"]:
            made = self.new("Part::Cylinder", name)
            self.follow(made, "Radius", shape["r0"])
        else:
            made = self.new("Part::Cone", name)
            self.follow(made, "Radius1", shape["r0"])
            self.follow(made, "Radius2", shape["r1"])
        length = shape["length"]
        if shape["r0"] != shape["r1"] and length.endswith(MESH_OVERLAP):
            length = length[:-len(MESH_OVERLAP)]  # here faces may meet exactly, and leave no seam
        self.follow(made, "Height", length)
        self.stand(made, shape["base"], shape["axis"])
        return made

    def block(self, name, shape):
        """Part::Box between two corners."""
        made = self.new("Part::Box", name)
        for key, high, low in zip(("Length", "Width", "Height"), shape["max"], shape["min"]):
            self.follow(made, key, "(%s) - (%s)" % (high, low))
        self.stand(made, shape["min"])
        return made

    def ball(self, name, shape):
        """Part::Sphere."""
        made = self.new("Part::Sphere", name)
        self.follow(made, "Radius", shape["radius"])
        self.stand(made, shape["center"])
        return made

    def prism(self, name, shape):
        """Part::Prism, measured across flats, a corner over local x."""
        made = self.new("Part::Prism", name)
        made.Polygon = shape["sides"]
        across = number(2 * math.cos(math.pi / shape["sides"]))
        self.follow(made, "Circumradius", "(%s) / %s" % (shape["width"], across))
        self.follow(made, "Height", shape["length"])
        self.stand(made, shape["base"], shape["axis"])
        return made


def runs(features):
    """Consecutive features with the same operation, as (operation, features)."""
    result = []
    for feature in features:
        if result and result[-1][0] == feature["operation"] != "keep":
            result[-1][1].append(feature)
        else:
            result.append((feature["operation"], [feature]))
    return result
