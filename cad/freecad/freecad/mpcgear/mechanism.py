"""The moving mechanism in a document: poses by driver angle, and overlaps of its solids."""

import bisect
import math

import FreeCAD as App

from . import files, poses, teeth
from .progress import Progress

TURN = 2 * math.pi
PARTS = ("Driver", "Follower", "Support", "Slider")
NEAR = 0.5  # mm; only components whose boxes come this close are measured
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

    def within(self, phi):
        """φ, or the nearest row's where the motion is not known."""
        after = bisect.bisect_right(self.phis, phi) % len(self.phis)
        low, high = self.phis[after - 1], self.phis[after]
        if (high - low) % TURN <= math.radians(20):
            return phi
        return low if (phi - low) % TURN < (high - phi) % TURN else high

    def move(self, phi):
        """Turns the driver to φ (rad), moves follower and slider along, and returns Q."""
        self.phi = phi = self.within(phi % TURN)
        pose, q = self.at(phi)
        poses.place(self.document, self.distance, phi, pose)
        for part in self.parts():
            part.purgeTouched()  # nothing else follows where a part stands
        return q

    def parts(self):
        """The parts that this mechanism has."""
        found = (self.document.getObject(name) for name in PARTS)
        return [part for part in found if part is not None]

    def clearance(self):
        """Overlaps and gaps of all parts where they stand now, as a list of `Contact`, worst
        first; teeth are measured one by one, so that each entry names a tooth."""
        parts = [components(part) for part in self.parts()]
        near = [(a, b) for i, first in enumerate(parts) for second in parts[i + 1:]
                for a in first for b in second if a.is_near(b)]
        found = []
        with Progress("Measuring gaps", len(near)) as progress:
            for a, b in near:
                progress.step("%s – %s" % (a.label, b.label))
                found += [contact for contact in [measure(a, b)] if contact]
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


class Component:
    """A hub, a tooth or a whole solid where it stands: its label, boxes that its surface lies in, and its
    shape, which is made when it is asked for the first time."""

    def __init__(self, part, label, boxes, make):
        self.placement = files.where(part)
        self.label, self.make, self.made = label, make, None
        self.boxes = [box.transformed(self.placement.toMatrix()) for box in boxes]
        self.around = App.BoundBox()
        for box in self.boxes:
            box.enlarge(NEAR / 2)
            self.around.add(box)

    def is_near(self, other):
        """Whether the two may be less than `NEAR` apart."""
        return self.around.intersect(other.around) and any(
            a.intersect(b) for a in self.boxes for b in other.boxes)

    def shape(self):
        """The shape in the document's frame."""
        if self.made is None:
            self.made = self.make().copy()
            self.made.Placement = self.placement.multiply(self.made.Placement)
        return self.made


def components(part):
    """The components of a part: hub and teeth as they are now, or its whole solid. What the user has added
    belongs to the hub."""
    bodies = getattr(part.Result, "Shapes", [])
    solid, gear = part.Result, None
    if part.Hub != part.Result and len(bodies) == 2 and "Stations" in bodies[1].PropertiesList:
        solid, gear = bodies[0], teeth.GearTeeth(part.Document, bodies[1])
    boxes = [face.BoundBox for face in solid.Shape.Faces]
    found = [Component(part, part.Label, boxes, lambda: solid.Shape)]
    for i, boxes in enumerate(gear.boxes() if gear else []):
        label = "%s tooth %s" % (part.Label, gear.teeth[i][0])
        found.append(Component(part, label, boxes, lambda i=i: gear.fin(i)))
    return found


def measure(a, b):
    """The `Contact` of two components, or None when they are clearly apart."""
    gap = a.shape().distToShape(b.shape())[0]
    overlap = a.shape().common(b.shape()).Volume if gap < 1e-6 else 0.0
    return Contact(a.label, b.label, overlap, gap) if gap < NEAR else None
