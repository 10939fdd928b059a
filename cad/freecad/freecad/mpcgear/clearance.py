"""Overlaps and gaps of the bodies, with all that the user has added to them, at one driver angle or all round."""

import math

import FreeCAD as App

from . import files, teeth
from .mechanism import TURN
from .progress import Progress

NEAR = 0.5  # mm; only components whose boxes come this close are measured
TOUCH = 1e-4  # mm³; less overlap than this is a contact
ANGLES = 72  # of a sweep


def here(mechanism):
    """The contacts of all parts where they stand now, worst first; teeth are measured one by one, so that each
    entry names a tooth."""
    parts = [components(part) for part in mechanism.parts()]
    near = near_pairs(parts)
    found = []
    with Progress("Measuring gaps", len(near)) as progress:
        for a, b in near:
            progress.step("%s – %s" % (a.label, b.label))
            found += measured(a, b, mechanism.phi)
    return sorted(found, key=Contact.badness)


def sweep(mechanism, angles=ANGLES):
    """The worst contact of every two components over a turn of the driver, worst first. Nothing is moved."""
    parts, worst = [(part.Name, components(part)) for part in mechanism.parts()], {}
    with Progress("Clearance", angles) as progress:
        for i in range(angles):
            phi = mechanism.within(TURN * i / angles)
            progress.step("φ = %.0f°" % math.degrees(phi))
            for name, there in mechanism.placements(phi).items():
                for component in dict(parts).get(name, []):
                    component.place(there)
            for a, b in near_pairs([found for _, found in parts]):
                for contact in measured(a, b, phi):
                    key = contact.first, contact.second
                    worst[key] = min(worst.get(key, contact), contact, key=Contact.badness)
    return sorted(worst.values(), key=Contact.badness)


def near_pairs(parts):
    """Components of different parts that may be less than `NEAR` apart."""
    return [(a, b) for i, first in enumerate(parts) for second in parts[i + 1:]
            for a in first for b in second if a.is_near(b)]


class Contact:
    """Two components that come close: overlap in mm³, gap in mm (0 where they overlap), and at which driver
    angle in rad."""

    def __init__(self, first, second, overlap, gap, phi):
        self.first, self.second, self.overlap, self.gap, self.phi = first, second, overlap, gap, phi

    def badness(self):
        """Sorts the worst first."""
        return -self.overlap, self.gap

    def __str__(self):
        if self.overlap > TOUCH:
            return "%s – %s: overlap %.4f mm³" % (self.first, self.second, self.overlap)
        return "%s – %s: gap %.3f mm" % (self.first, self.second, self.gap)


class Component:
    """A hub, a tooth, what the user has added or a whole solid: its label, boxes that its surface lies in, and
    its shape, which is made when it is asked for the first time."""

    def __init__(self, label, own_boxes, make):
        self.label, self.own_boxes, self.make, self.made = label, own_boxes, make, None

    def place(self, placement):
        """Stands it where its part is."""
        self.placement = placement
        self.boxes = [box.transformed(placement.toMatrix()) for box in self.own_boxes]
        self.around = App.BoundBox()
        for box in self.boxes:
            box.enlarge(NEAR / 2)
            self.around.add(box)
        return self

    def is_near(self, other):
        """Whether the two may be less than `NEAR` apart."""
        return self.around.intersect(other.around) and any(
            a.intersect(b) for a in self.boxes for b in other.boxes)

    def shape(self):
        """The shape in the document's frame."""
        if self.made is None:
            self.made = self.make().copy()
            self.own = self.made.Placement
        self.made.Placement = self.placement.multiply(self.own)
        return self.made


def components(part):
    """The components of a part where it stands: hub and teeth as they are now, or its whole solid, and what the
    user has put beside them. What was put under the teeth belongs to the hub."""
    bodies = getattr(part.Result, "Shapes", [])
    solid, gear = part.Result, None
    if part.Hub != part.Result and len(bodies) == 2 and "Stations" in bodies[1].PropertiesList:
        solid, gear = bodies[0], teeth.GearTeeth(part.Document, bodies[1])
    found = [whole(part.Label, solid.Shape)] + [whole(o.Label, o.Shape) for o in additions(part)]
    for i, boxes in enumerate(gear.boxes() if gear else []):
        label = "%s tooth %s" % (part.Label, gear.teeth[i][0])
        found.append(Component(label, boxes, lambda i=i: gear.fin(i)))
    return [component.place(files.where(part)) for component in found]


def whole(label, shape):
    """The component of one shape."""
    return Component(label, [face.BoundBox for face in shape.Faces], lambda: shape)


def additions(part):
    """Solids that the user has put into a part and that are no step towards another object."""
    made = getattr(part.Document.Check, "Made", [o.Name for o in part.Group])

    def is_step(feature):
        return any(o.TypeId not in ("App::Part", "App::DocumentObjectGroup") for o in feature.InList)

    return [o for o in part.Group if o.Name not in made and o.Visibility and not is_step(o)
            and getattr(o, "Shape", None) is not None and o.Shape.Solids]


def measured(a, b, phi):
    """The `Contact` of two components in a list, which is empty when they are clearly apart."""
    gap = a.shape().distToShape(b.shape())[0]
    overlap = a.shape().common(b.shape()).Volume if gap < 1e-6 else 0.0
    return [Contact(a.label, b.label, overlap, gap, phi)] if gap < NEAR else []
