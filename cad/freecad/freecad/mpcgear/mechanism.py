"""The moving mechanism in a document: poses by driver angle."""

import bisect
import math

import FreeCAD as App

from . import poses

TURN = 2 * math.pi
PARTS = ("Driver", "Follower", "Support", "Slider")


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

    def placements(self, phi):
        """{part: where it is} at driver angle φ, without moving it; of those that move."""
        phi = self.within(phi % TURN)
        return poses.placements(self.distance, phi, self.at(phi)[0])

    def parts(self):
        """The parts that this mechanism has."""
        found = (self.document.getObject(name) for name in PARTS)
        return [part for part in found if part is not None]


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
