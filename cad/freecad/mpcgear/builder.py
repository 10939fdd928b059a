# --- The tree: parameters, sections, teeth, hubs, joints, one App::Part per body ----------------
# Everything is built of plain Spreadsheet, Sketcher and Part objects, so that the document
# recomputes wherever FreeCAD runs, with nothing of mpcgear installed. Lengths are mm.

import math
import re

import FreeCAD as App
import Part
import Sketcher

from .files import COLOURS
from .options import OptionTools, build_options, option_rows, spline_sections
from .parameters import Expression, build_parameters, edge_radius, number, tooth_sections
from .poses import build_poses, follower_poses, place, vector
from .printing import build_print

SHORTEST_NECK = 0.1  # mm; a loft mistakes corners that are closer together for each other
SHORTEST_EDGE = 1e-9  # mm; shorter edges of the section are left out
TUCKED_RIB = 0.97  # of its thickness at the bead's middle: its corners stay inside the bead
SHORTEST_RIB = 0.8  # a rib's foot is at most this share of the tooth's distance from the axis


def build(document, design):
    """Fills `document` with the mechanism of `design` (the content of design.json)."""
    parameters = build_parameters(document, design)
    build_options(document, design)
    build_poses(document, design)
    sections = build_sections(document, design)
    parts = []
    for body in design["recipe"]["bodies"]:
        parts.append(BodyBuilder(document, design, parameters, sections).build(body))
    build_print(document, design, lambda: BodyBuilder(document, design, parameters, sections), parts)
    build_datums(document, design)
    phi, pose = follower_poses(design)[0]
    place(document, design["settings"]["gear"]["center_distance_mm"], phi, pose)
    document.recompute()
    return parts


# --- Cross sections ------------------------------------------------------------------------------


def build_sections(document, design):
    """Sketches of the teeth, one per sub-gear pair, and of the rib; every station of every tooth links
    to them."""
    group = document.addObject("App::DocumentObjectGroup", "Sections")
    sections = tooth_sections(design)
    teeth = [ToothSection(document, section, k).sketch for k, section in enumerate(sections, 1)]
    rib = rib_section(document, design["section"])
    for sketch in teeth + [rib]:
        group.addObject(sketch)
        sketch.Visibility = False
    spline_sections(document, group)
    return teeth, rib


def constrain(sketch, name, expression, *arguments):
    """Adds a named constraint that follows `expression`."""
    index = sketch.addConstraint(Sketcher.Constraint(*arguments))
    sketch.renameConstraint(index, name)
    sketch.setExpression("Constraints." + name, expression)


class ToothSection:
    """The sketch of the teeth of sub-gear pair `k` in (x = n into the material, y = b outwards): a bead
    on a neck of the rib's thickness that reaches down to the root; no neck where the root ends on the
    flanks, or so little below that it would be a sliver. Flanks flatter than a round bead end in
    rounded edges; of a round bead the flanks are cut off at the tip, or meet there."""

    def __init__(self, document, section, k):
        self.sketch = document.addObject("Sketcher::SketchObject", "ToothSection%d" % k)
        self.sketch.Label = "Tooth section, sub-gear pair %d" % k
        self.radius_name = "ToothParams.flank_radius_%d" % k
        self.k, self.section = k, section
        self.edges, self.smooth = [], []
        self.thickness, self.radius = section["thickness"], section["flank_radius"]
        self.middle = (section["clearance"] + self.thickness) / 2
        self.inset = self.thickness / 2 - self.radius  # arc centres are this far from the middle
        self.draw()
        self.close()
        self.hold()

    def line(self, start, end):
        """A line; returns its number."""
        points = [App.Vector(self.middle + x, y, 0) for x, y in (start, end)]
        self.edges.append(Part.LineSegment(*points))
        return len(self.edges) - 1

    def arc(self, centre, radius, start, end):
        """An arc counter-clockwise from one angle to another; returns its number."""
        at = App.Vector(self.middle + centre[0], centre[1], 0)
        self.edges.append(Part.ArcOfCircle(Part.Circle(at, App.Vector(0, 0, 1), radius), start, end))
        return len(self.edges) - 1

    def draw(self):
        """Edges counter-clockwise: bottom, right neck or edge, right flank, right edge and tip, and back
        on the left. Coordinates are from the middle."""
        section, radius, inset = self.section, self.radius, self.inset
        half = min(section["rib"], self.thickness) / 2
        low = math.acos(min(max((half - inset) / radius, 0.0), 1.0))
        self.has_neck = section["root"] > radius * math.sin(low) + SHORTEST_NECK
        root_edge, tip_edge = 0.0, edge_radius(section, section["tip"])
        if not self.has_neck:
            root_edge = min(edge_radius(section, section["root"]), self.thickness / 2 - half)
            low = math.asin(min(section["root"] / radius, 1.0))
        high = min(math.asin(min(section["tip"] / radius, 1.0)),
                   math.acos(max(1 - self.thickness / 2 / radius, 0.0)))
        low, bottom = self.rounded(low, section["root"], root_edge)
        high, top = self.rounded(high, section["tip"], tip_edge)
        if self.has_neck:
            bottom = half
        corner = (inset + radius * math.cos(low), -radius * math.sin(low))
        foot = (bottom, -section["root"])
        flat = (top, section["tip"] if tip_edge else radius * math.sin(high))
        round_tip = top < SHORTEST_EDGE and abs(inset) < SHORTEST_EDGE
        pointed = top < SHORTEST_EDGE
        self.round_tip, self.pointed = round_tip, pointed
        self.root_edges, self.tip_edges = [], []

        def edge(radius_of, height, turn, right, up):
            """The edge between a flank and the end of the section."""
            away = radius - radius_of
            x, y = inset + away * math.cos(turn), away * math.sin(turn)
            centre = (x if right else -x, y if up else -y)
            angles = sorted([turn, math.pi / 2])
            if not right:
                angles = [math.pi - a for a in reversed(angles)]
            if not up:
                angles = [-a for a in reversed(angles)]
            made = self.arc(centre, radius_of, *angles)
            (self.tip_edges if up else self.root_edges).append(made)
            return made

        self.line((-foot[0], foot[1]), foot)
        if self.has_neck:
            self.line(foot, corner)
        if root_edge:
            self.smooth += [0, edge(root_edge, section["root"], low, True, False)]
        if round_tip:
            self.right = self.left = self.arc((0, 0), radius, -low, math.pi + low)
        else:
            self.right = self.arc((inset, 0), radius, -low, high)
            if tip_edge:
                self.smooth += [self.right, edge(tip_edge, section["tip"], high, True, True)]
            if not pointed:
                self.top = self.line(flat, (-flat[0], flat[1]))
            if tip_edge:
                self.smooth += [self.top, edge(tip_edge, section["tip"], high, False, True)]
            self.left = self.arc((-inset, 0), radius, math.pi - high, math.pi + low)
        if root_edge:
            self.smooth += [self.left, edge(root_edge, section["root"], low, False, False)]
        if self.has_neck:
            self.line((-corner[0], corner[1]), (-foot[0], foot[1]))

    def rounded(self, turn, height, edge):
        """The angle to which a flank reaches, and half the width that is left at the end `height`."""
        if not edge:
            return turn, self.inset + self.radius * math.cos(turn)
        turn = math.asin((height - edge) / (self.radius - edge))
        return turn, self.inset + (self.radius - edge) * math.cos(turn)

    def close(self):
        """Every edge ends where the next one begins, smoothly where an edge is rounded."""
        self.sketch.addGeometry(self.edges)
        for edge in range(len(self.edges)):
            following = (edge + 1) % len(self.edges)
            kind = "Tangent" if edge in self.smooth else "Coincident"
            self.sketch.addConstraint(Sketcher.Constraint(kind, edge, 2, following, 1))

    def hold(self):
        """Constraints that follow the parameters. They name an edge and its 1 = start, 2 = end,
        3 = centre; edge -1 is the x axis, whose start is the origin."""
        sketch, section = self.sketch, self.section
        thickness, clearance = "ToothParams.thickness", "ToothParams.clearance"
        sketch.addConstraint(Sketcher.Constraint("Horizontal", 0))
        constrain(sketch, "root", "ToothParams.root", "DistanceY", 0, 1, -1, 1, section["root"])
        if self.has_neck:
            half = min(section["rib"], self.thickness) / 2
            sketch.addConstraint(Sketcher.Constraint("Vertical", 1))
            sketch.addConstraint(Sketcher.Constraint("Vertical", len(self.edges) - 1))
            constrain(sketch, "rib", "ToothParams.rib", "DistanceX", 0, 1, 0, 2, 2 * half)
            constrain(sketch, "neck", "%s / 2 + %s / 2 - ToothParams.rib / 2" % (clearance, thickness),
                      "DistanceX", -1, 1, 0, 1, self.middle - half)
        sketch.addConstraint(Sketcher.Constraint("PointOnObject", self.right, 3, -1))
        if self.round_tip:
            constrain(sketch, "flank", thickness + " / 2", "Radius", self.right, self.radius)
            constrain(sketch, "middle", "%s / 2 + %s / 2" % (clearance, thickness),
                      "DistanceX", -1, 1, self.right, 3, self.middle)
            return
        sketch.addConstraint(Sketcher.Constraint("PointOnObject", self.left, 3, -1))
        sketch.addConstraint(Sketcher.Constraint("Equal", self.right, self.left))
        constrain(sketch, "flank", self.radius_name, "Radius", self.left, self.radius)
        constrain(sketch, "left_centre", "%s / 2 + %s" % (clearance, self.radius_name),
                  "DistanceX", -1, 1, self.left, 3, self.middle - self.inset)
        constrain(sketch, "right_centre", "%s / 2 + %s - %s" % (clearance, thickness, self.radius_name),
                  "DistanceX", -1, 1, self.right, 3, self.middle + self.inset)
        if not self.pointed:
            sketch.addConstraint(Sketcher.Constraint("Horizontal", self.top))
            constrain(sketch, "tip", "ToothParams.tip", "DistanceY", -1, 1, self.top, 1, section["tip"])
        for name, edges in (("tip_edge", self.tip_edges), ("root_edge", self.root_edges)):
            if edges:
                radius = self.edges[edges[0]].Radius
                sketch.addConstraint(Sketcher.Constraint("Equal", *edges))
                constrain(sketch, name, "ToothParams.%s_%d" % (name, self.k), "Radius", edges[0], radius)


def rib_section(document, section):
    """Trapezium across the rib, 1 mm long, from the bead (y = 0) to its foot (y = −1); every station
    stretches its link to the rib's length."""
    sketch = document.addObject("Sketcher::SketchObject", "RibSection")
    half = section["rib"] / 2
    top = TUCKED_RIB * half
    corners = [App.Vector(x, y, 0) for x, y in ((-half, -1), (half, -1), (top, 0), (-top, 0))]
    sketch.addGeometry([Part.LineSegment(corners[i], corners[(i + 1) % 4]) for i in range(4)])
    for edge in range(4):
        sketch.addConstraint(Sketcher.Constraint("Coincident", edge, 2, (edge + 1) % 4, 1))
    for edge in (0, 2):
        sketch.addConstraint(Sketcher.Constraint("Symmetric", edge, 1, edge, 2, -2))
    sketch.addConstraint(Sketcher.Constraint("PointOnObject", 2, 1, -1))
    sketch.addConstraint(Sketcher.Constraint("DistanceY", 1, 1, 1, 2, 1.0))
    constrain(sketch, "rib_foot", "ToothParams.rib_foot", "DistanceX", 0, 1, 0, 2, 2 * half)
    constrain(sketch, "rib", "%s * ToothParams.rib" % TUCKED_RIB, "DistanceX", 2, 2, 2, 1, 2 * top)
    return sketch


# --- Teeth ---------------------------------------------------------------------------------------


class Frame:
    """Where the section stands at one contact station, in the gear's own frame."""

    def __init__(self, station, digit):
        self.p = vector(station["p" + digit])
        self.n = vector(station["n" + digit])
        self.t = vector(station["t" + digit])
        self.b = self.t.cross(self.n).normalize()

    def placement(self):
        """Sketch x = n, y = b."""
        return App.Placement(self.p, App.Rotation(self.n, self.b, self.n.cross(self.b), "XYZ"))


def frames(tooth, digit, axis):
    """Frames along one tooth, b pointing away from the gear's `axis` (a point on it)."""
    result = [Frame(station, digit) for station in tooth["stations"]]
    outwards = sum((f.p - axis).x * f.b.x + (f.p - axis).y * f.b.y for f in result)
    if outwards < 0:
        for frame in result:
            frame.b = frame.b * -1
    return result


def rib_lines(along, section, axis, foot):
    """(placement, length) of the rib's rectangle at every frame: from the bead's middle straight
    towards the hub's axis, ending `foot` from it, or nearer where the tooth itself is."""
    lines = []
    for frame in along:
        outer = frame.p + frame.n * (0.5 * (section["clearance"] + section["thickness"]))
        radial = App.Vector(outer.x - axis.x, outer.y - axis.y, 0)
        distance = radial.Length
        radial.normalize()
        across = frame.t.cross(radial).normalize()
        turned = App.Rotation(across, radial, across.cross(radial), "XYZ")
        lines.append((App.Placement(outer, turned), distance))
    foot = min([foot] + [SHORTEST_RIB * distance for _, distance in lines])
    return [(placement, distance - foot) for placement, distance in lines]


# --- Bodies --------------------------------------------------------------------------------------


class BodyBuilder:
    """Builds one body of the recipe as an App::Part of plain Part objects."""

    def __init__(self, document, design, parameters, sections):
        self.document = document
        self.design = design
        self.expression = Expression(parameters)
        self.tooth_sections, self.rib_section = sections

    def build(self, body):
        """The App::Part of `body` (or of a piece of one); its `Result` is the finished solid."""
        self.name = body["name"].title().replace(" ", "")
        self.colour = COLOURS.get(body["name"], (0.8, 0.8, 0.8))
        self.part = self.document.addObject("App::Part", self.name)
        solid = None
        for operation, features in runs(body["features"]):
            group = self.part.newObject("App::DocumentObjectGroup", self.name + operation)
            group.Label = "%s: %s" % (self.name, {"add": "added", "cut": "cut", "keep": "kept"}[operation])
            made = [self.primitive(feature, group) for feature in features]
            solid = self.combine(operation, solid, made)
        if body["name"] in option_rows(self.design):
            options = OptionTools(self, body["name"])
            added, cut = options.added(*bands(self.design, body.get("teeth"))), options.cut()
            solid = self.combine("add", solid, added) if added else solid
            solid = self.combine("cut", solid, cut) if cut else solid
        teeth = self.teeth(body["teeth"]) if body.get("teeth") else []
        if teeth:
            solid = self.boolean("MultiFuse", self.name + "WithTeeth", Shapes=[solid] + teeth)
        solid.Label = self.name + " solid"
        solid.Visibility = True
        self.part.addProperty("App::PropertyLinkChild", "Result", "mpcgear", "The finished solid")
        self.part.Result = solid
        return self.part

    def new(self, kind, name, group=None):
        """A new hidden object in the part (and in `group`)."""
        made = self.document.addObject(kind, re.sub(r"\W+", "_", name.title()) or "Object")
        (group or self.part).addObject(made)
        made.Visibility = False
        if App.GuiUp and hasattr(made.ViewObject, "ShapeColor"):
            made.ViewObject.ShapeColor = self.colour  # booleans take theirs from their inputs
        return made

    def combine(self, operation, solid, tools):
        """`solid` with all `tools` added, cut away, or kept in common."""
        if operation == "add":
            shapes = ([solid] if solid else []) + tools
            if len(shapes) == 1:
                return shapes[0]
            return self.boolean("MultiFuse", self.name + "Union", Shapes=shapes)
        if operation == "keep":
            for tool in tools:
                solid = self.boolean("MultiCommon", self.name + "Common", Shapes=[solid, tool])
            return solid
        tool = tools[0]
        if len(tools) > 1:
            tool = self.boolean("MultiFuse", self.name + "Cutters", Shapes=tools)
        return self.boolean("Cut", self.name + "Cut", Base=solid, Tool=tool)

    def boolean(self, kind, name, **inputs):
        """A boolean feature with its inputs."""
        made = self.new("Part::" + kind, name)
        for key, value in inputs.items():
            setattr(made, key, value)
        return made

    def primitive(self, feature, group):
        """One recipe feature as a parametric Part primitive."""
        (kind, shape), = feature["shape"].items()
        makers = {"cone": self.cone, "block": self.block, "ball": self.ball, "prism": self.prism}
        if kind not in makers:
            raise ValueError("feature %s of the design has an unknown shape: %s" % (feature["name"], kind))
        made = makers[kind](feature["name"], shape, group)
        made.Label = "%s %s" % (self.name, feature["name"])
        return made

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

    def cone(self, name, shape, group):
        """Part::Cylinder where both radii are the same expression, else Part::Cone."""
        if shape["r0"] == shape["r1"]:
            made = self.new("Part::Cylinder", name, group)
            self.follow(made, "Radius", shape["r0"])
        else:
            made = self.new("Part::Cone", name, group)
            self.follow(made, "Radius1", shape["r0"])
            self.follow(made, "Radius2", shape["r1"])
        self.follow(made, "Height", shape["length"])
        self.stand(made, shape["base"], shape["axis"])
        return made

    def block(self, name, shape, group):
        """Part::Box between two corners."""
        made = self.new("Part::Box", name, group)
        for key, high, low in zip(("Length", "Width", "Height"), shape["max"], shape["min"]):
            self.follow(made, key, "(%s) - (%s)" % (high, low))
        self.stand(made, shape["min"])
        return made

    def ball(self, name, shape, group):
        """Part::Sphere."""
        made = self.new("Part::Sphere", name, group)
        self.follow(made, "Radius", shape["radius"])
        self.stand(made, shape["center"])
        return made

    def prism(self, name, shape, group):
        """Part::Prism, measured across flats, a corner over local x."""
        made = self.new("Part::Prism", name, group)
        made.Polygon = shape["sides"]
        across = number(2 * math.cos(math.pi / shape["sides"]))
        self.follow(made, "Circumradius", "(%s) / %s" % (shape["width"], across))
        self.follow(made, "Height", shape["length"])
        self.stand(made, shape["base"], shape["axis"])
        return made

    def teeth(self, gear):
        """Every tooth of `gear` fused with its rib, grouped by sub-gear pair."""
        digit, axis, foot = gear_frame(self.design, gear)
        section = self.design["section"]
        fins = []
        for k, pair in enumerate(self.design["sub_gear_pairs"], 1):
            band = self.new("App::DocumentObjectGroup", "%s Band %d" % (gear, k))
            band.Label = "%s teeth, sub-gear pair %d" % (self.name, k)
            for j, tooth in enumerate(pair["teeth"], 1):
                name = "%s %d.%d" % (self.name, k, j)
                along = frames(tooth, digit, axis)
                fin = self.new("Part::MultiFuse", "Fin " + name, band)
                beads = [(frame.placement(), 1.0) for frame in along]
                # The rib leaves both ends of the tooth free: no thin corners there.
                ribs = rib_lines(along[1:-1], section, axis, foot)
                fin.Shapes = [self.loft("Tooth " + name, self.tooth_sections[k - 1], beads, band),
                              self.loft("Rib " + name, self.rib_section, ribs, band)]
                fin.Label = "Fin " + name
                fins.append(fin)
        return fins

    def loft(self, name, section, stations, band):
        """A loft through links to `section`, one per (placement, stretch along y)."""
        group = self.new("App::DocumentObjectGroup", "Stations Of " + name, band)
        links = []
        for placement, stretch in stations:
            link = self.new("App::Link", "Station Of " + name, group)
            link.LinkedObject = section
            link.LinkTransform = False
            link.Placement = placement
            link.ScaleVector = App.Vector(1, stretch, 1)
            links.append(link)
        made = self.new("Part::Loft", name, band)
        made.Label = name
        made.Sections = links
        made.Solid = True
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


def gear_frame(design, gear):
    """(digit of the gear's station fields, point on its axis, where its ribs end)."""
    settings = design["settings"]
    hub = settings["hub"]
    if gear == "driver":
        axis = App.Vector(-settings["gear"]["center_distance_mm"], 0, 0)
        return "1", axis, hub["driver_radius_mm"] - 1.0
    if design["class"] in ("3R", "3R1T"):
        foot = hub["follower_radius_mm"] - 1.0
    else:  # between the pin's bore and the drum
        value = {p["name"]: p["value"] for p in design["recipe"]["parameters"]}
        bore = value["pin_radius"] + settings["fit"]["joint_play_mm"]
        foot = 0.5 * (bore + hub["follower_radius_mm"])
    return "2", App.Vector(0, 0, 0), foot


def bands(design, gear):
    """(point on the axis of `gear`, middle heights of its sub-gear pairs); none without a gear."""
    if gear is None:
        return App.Vector(), []
    digit, axis, _ = gear_frame(design, gear)
    heights = [[station["p" + digit][2] for tooth in pair["teeth"] for station in tooth["stations"]]
               for pair in design["sub_gear_pairs"]]
    return axis, [(min(along) + max(along)) / 2 for along in heights]


# --- Datums --------------------------------------------------------------------------------------


def build_datums(document, design):
    """Axes of driver and follower, joint centre, the plane across it and the plane of both axes."""
    distance = design["settings"]["gear"]["center_distance_mm"]
    centre, driver = App.Vector(0, 0, 0), App.Vector(-distance, 0, 0)
    reach = distance + max(abs(station["p"][2]) for pair in design["sub_gear_pairs"]
                           for tooth in pair["teeth"] for station in tooth["stations"])
    for kind, name, owner, place in (
        ("Line", "DriverAxis", "Driver", App.Placement(driver, App.Rotation())),
        ("Line", "FollowerAxis", "Follower", App.Placement()),
        ("Point", "JointCentre", "Follower", App.Placement()),
        ("Plane", "JointPlane", "Support", App.Placement()),
        ("Plane", "AxesPlane", "Support",
         App.Placement(centre, App.Rotation(App.Vector(1, 0, 0), 90))),
    ):
        part = document.getObject(owner)
        if part is not None:
            datum = document.addObject("PartDesign::" + kind, name)
            datum.Placement = place
            # By itself FreeCAD draws datums many times as large as the parts.
            if kind != "Point":
                datum.ResizeMode = "Manual"
                datum.Length = 2 * reach
            if kind == "Plane":
                datum.Width = 2 * reach
            part.addObject(datum)
            datum.Visibility = kind != "Plane"
