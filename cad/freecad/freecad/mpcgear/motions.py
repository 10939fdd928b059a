"""Motions as motion files: formulas, tables, paths and recorded poses. Lengths are mm."""

import csv
import json
import math

import FreeCAD as App
import Part

CLASSES = ("1R", "1R1T", "3R", "3R1T")
TILTS, SLIDES = ("3R", "3R1T"), ("1R1T", "3R1T")
POINTS = 48  # along a path that is taken from a sketch
LEAST_POSES = 3
translate = App.Qt.translate


class MotionError(Exception):
    """What was chosen is no motion; the text says why and what to do."""


def toml(value):
    """A number, text, list or table in one line, as TOML writes it."""
    if isinstance(value, dict):
        return "{ %s }" % ", ".join("%s = %s" % (json.dumps(key), toml(item)) for key, item in value.items()
                                    if item is not None)
    if isinstance(value, (list, tuple)):
        return "[%s]" % ", ".join(toml(item) for item in value)
    return json.dumps(value)


def motion_file(name, gear_class, motion, settings=None):
    """The text of a motion file: `motion` is its table [motion], `settings` its other tables."""
    lines = ["name = %s" % json.dumps(name), "class = %s" % json.dumps(gear_class)]
    for title, fields in [("motion", motion)] + sorted((settings or {}).items()):
        lines += ["", "[%s]" % title]
        lines += ["%s = %s" % (key, toml(value)) for key, value in fields.items() if value is not None]
    return "\n".join(lines) + "\n"


def of_design(design):
    """The text of a motion file that asks for what `design` (the content of design.json) was made for."""
    motion = design["motion"]
    if motion["kind"] == "uniform":  # a motion file writes it as a formula
        motion = {"kind": "formula", "own_turn": "-phi"}
    return motion_file(design["name"], design["class"], motion, design["settings"])


def formula(gear_class, own_turn, rotation, slide):
    """[motion] of formulas in phi: the follower's own turn (rad), then an axis-angle vector (rad) where the
    class tilts, and the height of the joint (mm) where it slides. Empty texts are left out."""
    fields = {"kind": "formula", "own_turn": own_turn.strip() or "-phi"}
    if gear_class in TILTS and any(text.strip() for text in rotation):
        fields["rotation"] = [text.strip() or "0" for text in rotation]
    if gear_class in SLIDES and slide.strip():
        fields["translation"] = ["0", "0", slide.strip()]
    return fields


def table(path):
    """[motion] of a CSV file: poses (phi_deg,x,y,z,qw,qx,qy,qz) or points of a path (x,y,z or
    phi_deg,x,y,z), told apart by the number of columns."""
    rows = []
    try:
        with open(path, encoding="utf-8-sig", newline="") as source:
            lines = [(n, line) for n, line in enumerate(source, 1) if line.strip() and line[0] != "#"]
    except (OSError, ValueError) as error:
        raise MotionError("%s: %s" % (path, error))
    for n, line in lines:
        cells = [cell.strip() for cell in next(csv.reader([line]))]
        if not rows and not is_number(cells[0]):
            continue  # the head
        wrong = [cell for cell in cells if not is_number(cell)]
        if wrong:
            raise MotionError(translate("mpcgear", "%s, line %d: '%s' is not a number") % (path, n, wrong[0]))
        rows.append([float(cell) for cell in cells])
    widths = {len(row) for row in rows}
    if widths == {8}:
        return {"kind": "table", "rows": rows}
    if widths in ({3}, {4}):
        return {"kind": "path", "points": rows}
    raise MotionError(translate("mpcgear", "%s: 3 columns (x, y, z), 4 (phi_deg, x, y, z) or 8 (phi_deg, x, y, z, "
                                "qw, qx, qy, qz) are needed in every row, there are %s")
                      % (path, ", ".join(map(str, sorted(widths))) or "none"))


def is_number(text):
    """Whether a text is a number."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def along(edges, centre, gear_class):
    """([motion] of a closed curve that the end-effector follows at constant speed, how far in mm its points
    had to be moved). The joint is at `centre`; in classes with a ball the points go to a sphere around it,
    in the others to a cylinder around its z, which is as far as the curve is on the average."""
    try:
        wire = Part.Wire(Part.__sortEdges__(list(edges)))
    except Part.OCCError as error:
        raise MotionError(str(error))
    if not wire.isClosed():
        raise MotionError(translate("mpcgear", "The path is not closed: choose edges that come back to where "
                                    "they begin."))
    points = [point - centre for point in wire.discretize(Number=POINTS + 1)[:-1]]
    fields = {"kind": "path"}
    if gear_class in TILTS:
        radius = sum(point.Length for point in points) / len(points)
        if gear_class == "3R1T":
            fields.update(radius_mm=radius, points=[list(point) for point in points])
            return fields, 0.0
        moved = [point * (radius / max(point.Length, 1e-9)) for point in points]
    else:
        aside = [math.hypot(point.x, point.y) for point in points]
        radius = sum(aside) / len(points)
        moved = [App.Vector(point.x * radius / max(own, 1e-9), point.y * radius / max(own, 1e-9),
                            point.z if gear_class == "1R1T" else 0.0) for point, own in zip(points, aside)]
    if radius < 1e-6:
        raise MotionError(translate("mpcgear", "The path goes through the joint: move the joint's centre."))
    fields["points"] = [[round(x, 9) for x in point] for point in moved]
    return fields, max((a - b).Length for a, b in zip(points, moved))


def recorded(placements, centre, gear_class):
    """([motion] through poses that an object had one after the other, evenly over a turn of the driver; how
    far in mm they leave what the class allows; whether they turn once by themselves). The first one is the
    follower's rest, with its axis along z through `centre`. Poses that make no turn of their own get the
    gear's: once about z, first."""
    if len(placements) < LEAST_POSES:
        raise MotionError(translate("mpcgear", "%d poses are recorded, at least %d are needed: move the object "
                                    "and press Record again.") % (len(placements), LEAST_POSES))
    frame = App.Placement(centre, App.Rotation())
    rest = placements[0].inverse()
    poses = [frame.inverse().multiply(p).multiply(rest).multiply(frame) for p in placements]
    turn = sum(twist(b.Rotation.multiply(a.Rotation.inverted())) for a, b in zip(poses, poses[1:] + poses[:1]))
    turns = abs(turn + 2 * math.pi) < math.pi / 2
    keyframes, off = [], 0.0
    for i, pose in enumerate(poses):
        height = pose.Base.z if gear_class in SLIDES else 0.0
        off = max(off, (pose.Base - App.Vector(0, 0, height)).Length)
        keyframe = {"phi_deg": 360.0 * i / len(poses), "position": [0.0, 0.0, round(height, 9)]}
        x, y, z, w = pose.Rotation.Q
        if turns:
            keyframe["quaternion"] = [w, x, y, z]
        else:
            vector = App.Vector(x, y, z)
            angle = 2 * math.atan2(vector.Length, w)
            angle -= 2 * math.pi if angle > math.pi else 0.0
            scale = math.degrees(angle) / vector.Length if vector.Length > 1e-12 else 0.0
            keyframe["rotation_deg"] = [round(scale * c, 9) for c in vector]
        keyframes.append(keyframe)
    return {"kind": "keyframes", "keyframes": keyframes}, off, turns


def twist(rotation):
    """Angle of a rotation about z, in (-π, π]."""
    _, _, z, w = rotation.Q
    angle = 2 * math.atan2(z, w)
    return math.remainder(angle, 2 * math.pi)
