# --- Cross sections of teeth and ribs, as sketches that follow the sheet ToothParams -----------------

import math

import FreeCAD as App
import Part
import Sketcher

from .options import spline_blank
from .parameters import edge_radius, tooth_sections

SHORTEST_NECK = 0.1  # mm; a loft mistakes corners that are closer together for each other
SHORTEST_EDGE = 1e-9  # mm; shorter edges of the section are left out
TUCKED_RIB = 0.97  # of its thickness at the bead's middle: its corners stay inside the bead


def build_sections(document, design):
    """Sketches of the teeth, one per sub-gear pair, and of the rib: what the teeth are lofted through."""
    group = document.addObject("App::DocumentObjectGroup", "Sections")
    sections = tooth_sections(design)
    teeth = [ToothSection(document, section, k).sketch for k, section in enumerate(sections, 1)]
    rib = rib_section(document, design["section"])
    for sketch in teeth + [rib]:
        group.addObject(sketch)
        sketch.Visibility = False
    spline_blank(document, group)


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
        self.radius_name = "ToothParams.flank_radius_%d_mm" % k
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
        thickness, clearance = "ToothParams.thickness_mm", "ToothParams.clearance_mm"
        sketch.addConstraint(Sketcher.Constraint("Horizontal", 0))
        constrain(sketch, "root", "ToothParams.root_mm", "DistanceY", 0, 1, -1, 1, section["root"])
        if self.has_neck:
            half = min(section["rib"], self.thickness) / 2
            sketch.addConstraint(Sketcher.Constraint("Vertical", 1))
            sketch.addConstraint(Sketcher.Constraint("Vertical", len(self.edges) - 1))
            constrain(sketch, "rib", "ToothParams.rib_mm", "DistanceX", 0, 1, 0, 2, 2 * half)
            constrain(sketch, "neck", "%s / 2 + %s / 2 - ToothParams.rib_mm / 2" % (clearance, thickness),
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
            constrain(sketch, "tip", "ToothParams.tip_mm", "DistanceY", -1, 1, self.top, 1, section["tip"])
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
    constrain(sketch, "rib_foot", "ToothParams.rib_foot_mm", "DistanceX", 0, 1, 0, 2, 2 * half)
    constrain(sketch, "rib", "%s * ToothParams.rib_mm" % TUCKED_RIB, "DistanceX", 2, 2, 2, 1, 2 * top)
    return sketch
