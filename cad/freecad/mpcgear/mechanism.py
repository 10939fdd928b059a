"""The moving mechanism in a document: poses by driver angle, and overlaps of its solids."""

import bisect
import math

import FreeCAD as App

from . import files, poses, teeth

TURN = 2 * math.pi
PARTS = ("Driver", "Follower", "Support", "Slider")
NEAR = 0.5  # mm; only components whose bounding boxes come this close are measured
TOUCH = 1e-4  # mm³; less overlap than this is a contact


class NoMechanism(Exception):
    """The document holds no mpcgear mechanism."""


class Mechanism:
    """Moves the parts of a document that the macro or 'Open mpcgear design' has built."""

    def __init__(self, document):
        if document is None or document.getObject("Poses") is None:
            raise NoMechanism("Open a gear first: 'Open mpcgear design…', or run its macro.")
        self.document = document
        self.distance = -document.DriverAxis.Placement.Base.x
        self.rows = read_poses(document.Poses)
        self.phis = [row[0] for row in self.rows]
        # Turn back to where the document stands.
        turned = document.Driver.Placement.Rotation.toEuler()[0]
        self.phi = math.radians(turned) % TURN

    def at(self, phi):
        """(pose of the follower, Q) at driver angle φ in rad, between the rows of `Poses`; where
        the motion is not known (reciprocating gears) the nearest row."""
        phi %= TURN
        after = bisect.bisect_right(self.phis, phi) % len(self.rows)
        low, high = self.rows[after - 1], self.rows[after]
        gap = (high[0] - low[0]) % TURN
        share = ((phi - low[0]) % TURN) / gap if gap else 0.0
        if gap > math.radians(20):
            share = round(share)
        base = low[1].Base + (high[1].Base - low[1].Base) * share
        rotation = low[1].Rotation.slerp(high[1].Rotation, share)
        return App.Placement(base, rotation), low[2] + (high[2] - low[2]) * share

    def move(self, phi):
        """Turns the driver to φ (rad), moves follower and slider along, and returns Q."""
        self.phi = phi % TURN
        pose, q = self.at(phi)
        poses.place(self.document, self.distance, phi, pose)
        return q

    def parts(self):
        """The parts that this mechanism has."""
        found = (self.document.getObject(name) for name in PARTS)
        return [part for part in found if part is not None]

    def clearance(self):
        """Overlaps and gaps of all parts where they stand now, as a list of `Contact`, worst
        first; fins are measured one by one, so that each entry names a tooth."""
        found = []
        parts = [(part, components(part)) for part in self.parts()]
        for i, (_, first) in enumerate(parts):
            for _, second in parts[i + 1:]:
                found += [contact for a in first for b in second
                          for contact in [measure(a, b)] if contact]
        return sorted(found, key=lambda c: (-c.overlap, c.gap))


class Contact:
    """Two components that come close: overlap in mm³, gap in mm (0 where they overlap)."""

    def __init__(self, first, second, overlap, gap):
        self.first, self.second, self.overlap, self.gap = first, second, overlap, gap

    def __str__(self):
        if self.overlap > TOUCH:
            return "%s – %s: overlap %.4f mm³" % (self.first, self.second, self.overlap)
        return "%s – %s: gap %.3f mm" % (self.first, self.second, self.gap)


def read_poses(sheet):
    """[(φ in rad, follower placement, Q)] of the spreadsheet `Poses`."""
    rows = []
    row = 2
    while sheet.getContents("A%d" % row):
        phi, x, y, z, q0, q1, q2, q3, q = (
            float(sheet.get("%s%d" % (column, row))) for column in "ABCDEFGHI")
        pose = App.Placement(App.Vector(x, y, z), App.Rotation(q0, q1, q2, q3))
        rows.append((math.radians(phi), pose, q))
        row += 1
    return rows


def components(part):
    """[(label, shape where it stands)]: hub and teeth of a part as they are now, or its whole solid. What
    the user has added belongs to the hub."""
    pieces = [(part.Label, part.Result.Shape)]
    shapes = getattr(part.Result, "Shapes", [])
    if part.Hub != part.Result and len(shapes) == 2 and "Stations" in shapes[1].PropertiesList:
        gear = teeth.GearTeeth(part.Document, shapes[1])
        pieces = [(part.Label, shapes[0].Shape)]
        pieces += [("%s tooth %s" % (part.Label, name), solid) for name, solid in gear.fins()]
    placed = []
    for label, shape in pieces:
        shape = shape.copy()
        shape.Placement = files.where(part).multiply(shape.Placement)
        placed.append((label, shape))
    return placed


def measure(a, b):
    """The `Contact` of two (label, shape), or None when their boxes are clearly apart."""
    box = a[1].BoundBox
    box.enlarge(NEAR)
    if not box.intersect(b[1].BoundBox):
        return None
    gap = a[1].distToShape(b[1])[0]
    overlap = a[1].common(b[1]).Volume if gap < 1e-6 else 0.0
    return Contact(a[0], b[0], overlap, gap) if gap < NEAR else None
