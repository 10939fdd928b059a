"""Opens a design.json: the same tree that the design's macro builds."""

import json
import math
import os

import FreeCAD as App

from . import builder
from .poses import copies, vector
from .progress import Cancelled

FORMATS = (1, 2)
# As in the macro: teeth have at most so many frames, of which the ribs leave some free at both
# ends, and about every third of the others carries a section.
MOST_FRAMES, RIB_INSET, FRAME_STEP = 25, 1, 3


class DesignError(Exception):
    """The file is not a design that can be built; the text says why and what to do."""


def read(path):
    """The design in `path`, its stations thinned to those that carry sections."""
    try:
        with open(path, encoding="utf-8") as source:
            design = json.load(source)
    except (OSError, ValueError) as error:
        raise DesignError("%s cannot be read: %s" % (path, error))
    if not isinstance(design, dict) or "sub_gear_pairs" not in design:
        raise DesignError("%s is not an mpcgear design: choose the design.json that "
                          "'mpcgear design' wrote" % path)
    if design.get("format") not in FORMATS:
        raise DesignError("%s has format %s, this add-on reads formats %d to %d: update the older of both"
                          % (path, design.get("format"), FORMATS[0], FORMATS[-1]))
    if not design["sub_gear_pairs"] or not design["recipe"]["bodies"]:
        raise DesignError("%s has no finished solids: %s"
                          % (path, "; ".join(design.get("problems", [])) or "no teeth found"))
    if design["format"] == 1:
        design["poses"] = contact_poses(design)
    else:
        place_on_gears(design)
        turn, count = 2 * math.pi, copies(design)
        rows = {round(row[0] % turn, 9): [row[0] % turn] + row[1:]
                for tooth in design["poses"] for row in tooth}
        design["poses"] = [[(row[0] + turn * i) / count] + row[1:]
                           for i in range(count) for _, row in sorted(rows.items())]
    for pair in design["sub_gear_pairs"]:
        for tooth in pair["teeth"]:
            tooth["stations"] = [tooth["stations"][i] for i in chosen(len(tooth["stations"]))]
    return design


def chosen(stations):
    """Indices of those of a tooth's `stations` that carry sections: both ends, and the ribs' own."""
    count = min(stations, MOST_FRAMES)
    frames = [i * (stations - 1) // (count - 1) for i in range(count)]
    inner = frames[RIB_INSET:-RIB_INSET] if count > 4 * RIB_INSET else frames
    steps = max((len(inner) - 1) // FRAME_STEP, 1)
    ribs = {inner[i * (len(inner) - 1) // steps] for i in range(steps + 1)}
    return sorted(ribs | {frames[0], frames[-1]})


def place_on_gears(design):
    """Adds to every station where it is in the frames of driver and follower: p1 and p2, n1 and n2
    into the material, t1 and t2 along the gears' curves."""
    axis = App.Vector(-design["settings"]["gear"]["center_distance_mm"], 0, 0)
    rate = 1 / copies(design)
    for pair in design["sub_gear_pairs"]:
        for tooth, poses in zip(pair["teeth"], design["poses"]):
            for station, (phi, x, y, z, *q) in zip(tooth["stations"], poses):
                p, n, v = (vector(station[name]) for name in "pnv")
                driver = App.Rotation(App.Vector(0, 0, 1), math.degrees(phi * rate)).inverted()
                follower = App.Rotation(*q).inverted()
                slide = v - App.Vector(0, 0, rate).cross(p - axis)
                station["p1"] = list(driver.multVec(p - axis) + axis)
                station["n1"] = list(driver.multVec(n) * -1)
                station["t1"] = list(driver.multVec(slide).normalize())
                station["p2"] = list(follower.multVec(p - App.Vector(x, y, z)))
                station["n2"] = list(follower.multVec(n))
            for i, station in enumerate(tooth["stations"]):
                station["t2"] = list(slope(tooth["stations"], i).normalize())


def slope(stations, i):
    """Derivative of p2 by phi at station i, of the polynomial through the seven nearest stations."""
    first = max(min(i - 3, len(stations) - 7), 0)
    near = [k for k in range(first, min(first + 7, len(stations))) if k != i]
    x = [station["phi"] for station in stations]
    weight = {k: 1 / math.prod(x[k] - x[m] for m in near + [i] if m != k) for k in near + [i]}
    here = vector(stations[i]["p2"])
    steps = ((vector(stations[k]["p2"]) - here) * (weight[k] / weight[i] / (x[i] - x[k])) for k in near)
    return sum(steps, App.Vector())


def triad(a, b):
    """Right-handed orthonormal axes made of two independent vectors, as a rotation."""
    return App.Rotation(a, b, a.cross(b), "XYZ")


def contact_poses(design):
    """The design's rows for `poses.follower_poses`: every contact is known both in the fixed frame
    and in the follower's, so two normals fix the rotation and a point the rest."""
    pairs = design["sub_gear_pairs"]
    poses = {}
    for j in range(len(pairs[0]["teeth"])):
        for rows in zip(*(pair["teeth"][j]["stations"] for pair in pairs)):
            if max(row["phi"] for row in rows) - min(row["phi"] for row in rows) > 1e-6:
                raise ValueError("tooth %d: the sub-gear pairs have contact at different angles"
                                 % (j + 1))
            phi = rows[0]["phi"] % (2 * math.pi)
            first = vector(rows[0]["n"])
            other = max(rows[1:], key=lambda row: first.cross(vector(row["n"])).Length)
            fixed = triad(first, vector(other["n"]))
            body = triad(vector(rows[0]["n2"]), vector(other["n2"]))
            rotation = fixed.multiply(body.inverted())
            base = vector(rows[0]["p"]) - rotation.multVec(vector(rows[0]["p2"]))
            poses[round(phi, 9)] = [phi] + list(base) + list(rotation.Q)
    return [row for _, row in sorted(poses.items())]


def open_design(path):
    """Builds the design in `path` in a new document and returns the document."""
    design = read(path)
    name = "".join(c for c in design["name"].title() if c.isalnum())
    document = App.newDocument(name or os.path.splitext(os.path.basename(path))[0])
    try:
        builder.build(document, design)
    except Cancelled:
        App.closeDocument(document.Name)
        raise
    for problem in design.get("problems", []):
        App.Console.PrintWarning("mpcgear: this design is a draft: %s\n" % problem)
    return document
