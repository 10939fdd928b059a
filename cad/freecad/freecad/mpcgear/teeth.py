# --- Teeth: one solid feature per gear, rebuilt from the sections when they change -----------------
# FreeCAD has no plain object for many lofts, and a loft for every tooth takes a thousand links. So the
# teeth of a gear are one Part::Feature that knows where their sections stand; `rebuild` lofts and
# fuses them. All else in the document recomputes by itself.

import math

import FreeCAD as App
import Part

from .parameters import TEETH
from .poses import copies, vector
from .progress import Progress

SHORTEST_RIB = 0.8  # a rib's foot is at most this share of the tooth's distance from the axis
DEGREE = 5  # of the lofts' B-splines, at most
SPANS = tuple(math.radians(span) for span in (120, 60, 45, 30))  # of arcs, at most, in lofts; the later
# ones where the first gives no solid
BULGE = 0.05  # mm; how far a tooth may leave the boxes around its stations
RIB_BOXES = 4  # between bead and hub
SAME = 1e-6  # mm; parameters that differ by less are the same


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


def sweep(tooth, digit, axis):
    """(where the sections of a tooth stand, how much its rib thickens on the side of x × y × outwards and on
    the other)."""
    along = frames(tooth, digit, axis)
    flare = list(tooth.get("flare", ((0, 0), (0, 0)))[int(digit) - 1])
    if sum(f.n.cross(f.b).dot(f.t) for f in along) < 0:
        flare.reverse()
    return [frame.placement() for frame in along], flare


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


def store(feature, design, gear):
    """Writes into `feature` where the sections of the teeth of `gear` stand."""
    digit, axis, foot = gear_frame(design, gear)
    count = copies(design) if gear == "driver" else 1
    turns = [App.Placement(App.Vector(), App.Rotation(App.Vector(0, 0, 1), -360.0 * i / count), axis)
             for i in range(count)]
    stand, counts, pairs, flares = [], [], [], []
    for k, pair in enumerate(design["sub_gear_pairs"], 1):
        for turn in turns:
            for tooth in pair["teeth"]:
                along, flare = sweep(tooth, digit, axis)
                stand += along if count == 1 else [turn.multiply(placement) for placement in along]
                counts.append(len(along))
                pairs.append(k)
                flares += flare
    for kind, name, value, words in (
        ("App::PropertyPlacementList", "Stations", stand, "Where the sections stand, tooth by tooth"),
        ("App::PropertyIntegerList", "Counts", counts, "Sections of every tooth"),
        ("App::PropertyIntegerList", "Pairs", pairs, "Sub-gear pair of every tooth"),
        ("App::PropertyVector", "Axis", axis, "A point on the gear's axis"),
        ("App::PropertyFloat", "Foot", foot, "How far from the axis the ribs end"),
        ("App::PropertyFloatList", "Flares", flares, "How much every rib thickens to its foot, on either side"),
        ("App::PropertyFloatList", "Built", [], "Values of ToothParams that the shape was built with"),
    ):
        feature.addProperty(kind, name, "mpcgear", words)
        setattr(feature, name, value)
        feature.setEditorMode(name, 1)


def aliases(document):
    """Aliases of the values that the shape of the teeth depends on, in order."""
    sheet = document.getObject(TEETH)
    found = []
    for row in range(2, 60):
        alias = sheet.getAlias("G%d" % row)
        if alias:
            found.append(alias)
    return found


def values(document):
    """Those values, mm."""
    sheet = document.getObject(TEETH)
    return [float(getattr(sheet, alias)) for alias in aliases(document)]


def features(document):
    """The features of teeth in a document."""
    return [o for o in document.Objects if "Stations" in o.PropertiesList and "Built" in o.PropertiesList]


def stale(document):
    """Labels of the teeth that are not those of the sheet."""
    now = values(document)
    return [f.Label for f in features(document)
            if len(f.Built) != len(now) or any(abs(a - b) > SAME for a, b in zip(f.Built, now))]


def rebuild(document):
    """Lofts and fuses the teeth of every gear, all or nothing, also when cancelled. The bodies are yet to be
    recomputed."""
    made, found = {}, features(document)
    with Progress("Building teeth", sum(len(f.Counts) for f in found)) as progress:
        for feature in found:
            made[feature.Name] = GearTeeth(document, feature).solid(progress)
    for feature in found:
        feature.Shape = made[feature.Name]
        feature.Built = values(document)


class GearTeeth:
    """The teeth of one gear as their feature and the sketches say."""

    def __init__(self, document, feature):
        self.feature = feature
        sheet = document.getObject(TEETH)
        self.middle = (sheet.clearance_mm.Value + sheet.thickness_mm.Value) / 2
        self.sections = {k: outline(document.getObject("ToothSection%d" % k)) for k in set(feature.Pairs)}
        self.rib = [v.Point for v in outline(document.getObject("RibSection")).OrderedVertexes]
        self.beads = {}
        self.teeth, start, number = [], 0, {}
        flares = list(feature.Flares) if "Flares" in feature.PropertiesList else []
        flares = list(zip(flares[::2], flares[1::2])) or [(0, 0)] * len(feature.Counts)
        for count, pair, flare in zip(feature.Counts, feature.Pairs, flares):
            number[pair] = number.get(pair, 0) + 1
            along = feature.Stations[start:start + count]
            self.teeth.append(("%d.%d" % (pair, number[pair]), pair, along, flare))
            start += count

    def bead(self, pair, span):
        """The section of a pair's teeth with B-splines of `span` in place of arcs."""
        if (pair, span) not in self.beads:
            self.beads[pair, span] = splines(self.sections[pair], span)
        return self.beads[pair, span]

    def lofts(self, number, span=SPANS[0]):
        """One tooth and its rib, which leaves both ends free: no thin corners there."""
        _, pair, along, flare = self.teeth[number]
        bead = self.bead(pair, span)
        return [loft([moved(bead, placement) for placement in along]), loft(self.rib_wires(along[1:-1], flare))]

    def fin(self, number):
        """One tooth with its rib, as one shape."""
        return Part.makeCompound(self.fused([number]))

    def fused(self, group):
        """The solids of a group of teeth. FreeCAD's kernel misses an intersection now and then, which
        shows as too many solids; it finds it when the same curves are written in another way."""
        for span in SPANS:
            shapes = [shape for number in group for shape in self.lofts(number, span)]
            made = shapes[0].multiFuse(shapes[1:])
            if len(made.Solids) <= len(group):
                return made.Solids
        raise RuntimeError("%s: tooth %s cannot be joined with its rib"
                           % (self.feature.Label, self.teeth[group[0]][0]))

    def rib_wires(self, along, flare):
        """The rib's trapezium at every station: from the bead's middle straight towards the axis, ending
        `Foot` from it, or nearer where the tooth itself is, and there thicker by `flare`."""
        lines, axis = [], self.feature.Axis
        for placement in along:
            normal = placement.Rotation.multVec(App.Vector(1, 0, 0))
            tangent = placement.Rotation.multVec(App.Vector(0, 0, 1))
            outer = placement.Base + normal * self.middle
            radial = App.Vector(outer.x - axis.x, outer.y - axis.y, 0)
            distance = radial.Length
            radial.normalize()
            across = tangent.cross(radial).normalize()
            lines.append((outer, across, radial, distance))
        foot = min([self.feature.Foot] + [SHORTEST_RIB * line[3] for line in lines])
        section = [App.Vector(c.x - c.y * (flare[0] if c.x > 0 else -flare[1]), c.y) for c in self.rib]
        wires = []
        for outer, across, radial, distance in lines:
            corners = [outer + across * c.x + radial * (c.y * (distance - foot)) for c in section]
            wires.append(Part.makePolygon(corners + corners[:1]))
        return wires

    def solid(self, progress=None):
        """All teeth with their ribs as one shape of solids that do not touch."""
        result = []
        for group in joined(list(range(len(self.teeth))), self.close_pairs()):
            if progress:
                progress.step("%s: tooth %s" % (self.feature.Label, self.teeth[group[0]][0]), len(group))
            result += self.fused(group)
        return Part.makeCompound(result)

    def close_pairs(self):
        """Pairs of teeth that may touch."""
        pieces = self.boxes()
        return [(i, j) for j in range(len(pieces)) for i in range(j)
                if any(a.intersect(b) for a in pieces[i] for b in pieces[j])]

    def boxes(self):
        """Boxes around the pieces of every tooth between its stations."""
        pieces = []
        for _, pair, along, flare in self.teeth:
            section = self.sections[pair].BoundBox
            corners = [App.Vector(x, y, 0) for x in (section.XMin, section.XMax)
                       for y in (section.YMin, section.YMax)]
            rows = [[placement.multVec(c) for c in corners] for placement in along]
            boxes = [box_around(a + b) for a, b in zip(rows, rows[1:])]
            ribs = [[v.Point for v in wire.Vertexes] for wire in self.rib_wires(along[1:-1], flare)]
            for a, b in zip(ribs, ribs[1:]):
                low, high = (a[:2] + b[:2], a[2:] + b[2:])
                high = high[1::-1] + high[3:1:-1]  # above their neighbours in `low`
                levels = [[p + (q - p) * (i / RIB_BOXES) for p, q in zip(low, high)]
                          for i in range(RIB_BOXES + 1)]
                boxes += [box_around(c + d) for c, d in zip(levels, levels[1:])]
            pieces.append(boxes)
        return pieces


def box_around(points):
    """Their bounding box, with room for what bulges between stations."""
    box = App.BoundBox()
    for point in points:
        box.add(point)
    box.enlarge(BULGE)
    return box


def joined(items, pairs):
    """`items` in groups that `pairs` of them connect."""
    leader = {item: item for item in items}

    def top(item):
        while leader[item] != item:
            item = leader[item]
        return item

    for a, b in pairs:
        leader[top(b)] = top(a)
    groups = {}
    for item in items:
        groups.setdefault(top(item), []).append(item)
    return list(groups.values())


def outline(sketch):
    """The closed wire of a sketch."""
    return Part.Wire(Part.__sortEdges__(sketch.Shape.Edges))


def splines(wire, span):
    """`wire` with quintic curves of at most `span` in place of arcs, which are within 1e-4 mm: lofts through
    arcs have degree 7."""
    edges = []
    for edge in wire.OrderedEdges:
        curve, (first, last) = edge.Curve, edge.ParameterRange
        if isinstance(curve, Part.Circle):
            count = max(1, math.ceil((last - first) / span))
            turns = [first + (last - first) * i / count for i in range(count + 1)]
            edges += [quintic(curve, a, b) for a, b in zip(turns, turns[1:])]
        else:
            edges.append(edge)
    return Part.Wire(Part.__sortEdges__(edges))


def quintic(circle, first, last):
    """The arc as a Bézier curve: directions and curvatures right at both ends, the middle on the arc. Up
    to 120° it stays within 4e-5 of the radius."""
    sine, cosine = math.sin((last - first) / 2), math.cos((last - first) / 2)
    step = (10 * sine - math.sqrt(100 * sine ** 2 - 128 * cosine * (1 - cosine))) / (2 * cosine)
    poles = []
    for turn, sign in ((first, 1), (last, -1)):
        point = circle.value(turn)
        speed = circle.tangent(turn)[0] * (sign * circle.Radius * step)
        bend = (circle.Center - point) * step ** 2
        poles.append([point, point + speed / 5, point + speed * (2 / 5) + bend / 20])
    curve = Part.BezierCurve()
    curve.setPoles(poles[0] + poles[1][::-1])
    return curve.toBSpline().toShape()


def moved(wire, placement):
    """A copy of `wire` at `placement`."""
    copy = wire.copy()
    copy.Placement = placement
    return copy


def loft(wires):
    """The solid through closed wires."""
    return Part.makeLoft(wires, True, False, False, DEGREE)
