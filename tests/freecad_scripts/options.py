"""Runs inside freecadcmd: every option of the sheets changes what it names, and only that.

The add-on is installed; MPCGEAR_DESIGN is a design.json of class 3R; exit code 0 when all
holds. The judge is arithmetic: volumes and faces of the bounding box of every part.
"""

import math
import os
import sys
import traceback

import FreeCAD as App

from freecad.mpcgear import check, files, open_design, parameters, teeth

PARTS = ("Driver", "Follower", "Support")


def write(document, values):
    for alias, value in values.items():
        sheet, cell = parameters.cell_of(document, alias)
        sheet.set(cell, "=" + value)


def contents(document, alias):
    sheet, cell = parameters.cell_of(document, alias)
    return sheet.getContents(cell).lstrip("=")


def value_of(document, alias):
    sheet, _ = parameters.cell_of(document, alias)
    return getattr(sheet, alias + "_mm").Value


def measured(document):
    """{part: (volume, [zmin, zmax])} of parts that are one valid solid each."""
    document.recompute()
    if teeth.stale(document):
        teeth.rebuild(document)
        document.recompute()
    assert check.broken(document) == [], check.broken(document)
    solids = {name: files.solid_of(document.getObject(name)) for name in PARTS}
    return {name: (s.Volume, (s.BoundBox.ZMin, s.BoundBox.ZMax)) for name, s in solids.items()}


class Bench:
    """Changes options against a document that is as designed."""

    def __init__(self, document):
        self.document = document
        self.plain = measured(document)

    def change_of(self, part, z=(0.0, 0.0), **values):
        """How `values` change the volume of `part`: its lowest and highest z change by `z`, and no other
        part changes; they are taken back."""
        before = {alias: contents(self.document, alias) for alias in values}
        write(self.document, values)
        now = measured(self.document)
        write(self.document, before)
        for name in PARTS:
            assert name == part or abs(now[name][0] - self.plain[name][0]) < 1e-3, (values, name)
        moved = [a - b for a, b in zip(now[part][1], self.plain[part][1])]
        assert all(abs(a - b) < 1e-4 for a, b in zip(moved, z)), (values, moved, z)
        return now[part][0] - self.plain[part][0]

    def is_as_before(self):
        """All that was taken back is gone."""
        now = measured(self.document)
        for name in PARTS:
            assert abs(now[name][0] - self.plain[name][0]) < 1e-3, (name, now, self.plain)

    def change(self, part, expected, tolerance=0.02, **values):
        """As change_of(), for a change that is known."""
        found = self.change_of(part, **values)
        assert abs(found - expected) < tolerance, (values, found, expected)


def segment(radius, flat):
    """Area that a flat cuts off a circle."""
    angle = math.acos((radius - flat) / radius)
    return radius ** 2 * (angle - math.sin(angle) * math.cos(angle))


def star(radius, count):
    return count * radius * 0.93 * radius * math.sin(math.pi / count)


def slot(radius, width, depth):
    """Area of a keyway beside a round hole."""
    half = width / 2
    under = half * math.sqrt(radius ** 2 - half ** 2) + radius ** 2 * math.asin(half / radius)
    return width * (radius + depth) - under


def bores(bench):
    disc = math.pi * 2.6 ** 2
    d_shape = disc - segment(2.6, 0.5)
    cases = [
        (disc, dict(bore="1")),
        (math.pi * 2.1 ** 2, dict(bore="1", bore_diameter="4 mm")),
        (math.pi * 2.8 ** 2, dict(bore="1", bore_fit="0.3 mm")),
        (0.6 * disc, dict(bore="1", bore_depth="6 mm")),
        (d_shape, dict(bore="2")),
        (disc - segment(2.6, 0.8), dict(bore="2", bore_flat="0.8 mm")),
        (2 * math.sqrt(3) * 2.6 ** 2, dict(bore="3")),
        (star(2.6, 25), dict(bore="4")),
        (star(2.6, 23), dict(bore="4", bore_teeth="23")),
        (d_shape, dict(bore_preset="1")),
        (d_shape, dict(bore_preset="2")),
        (math.pi * 3.275 ** 2 - segment(3.275, 0.6), dict(bore_preset="3")),
        (star(2.97, 25), dict(bore_preset="4", bore_fit="0.02 mm")),
        (star(2.95, 23), dict(bore_preset="5")),
        (math.pi * 2.1 ** 2 + slot(2.1, 2, 1), dict(bore="1", bore_diameter="4 mm", keyway="1")),
    ]
    for area, values in cases:
        bench.change("Driver", -10 * area, **values)


def walls(document):
    """A hole that leaves too little of the shaft is named."""
    sheet, cell = parameters.cell_of(document, "bore_wall")
    for bore, diameter, words in (("0", "5 mm", "ok"), ("1", "3 mm", "ok"), ("1", "7 mm", "TOO SMALL")):
        write(document, dict(bore=bore, bore_diameter=diameter))
        document.recompute()
        assert sheet.get(cell.replace("B", "E")) == words, (bore, diameter)
    write(document, dict(bore="0", bore_diameter="5 mm"))


def set_screws(bench):
    shaft = value_of(bench.document, "journal_radius")
    hole = bench.change_of("Driver", set_screw="3 mm", set_screw_nut="0")
    both = bench.change_of("Driver", set_screw="3 mm")
    # Half a hole across the shaft, up to its round side; a pocket of 5.9 x 2.8 mm above it.
    assert abs(hole + math.pi * 1.6 ** 2 * shaft) < 0.1 * abs(hole), (hole, shaft)
    assert both < hole - 2.8 * 5.9 * 3, (both, hole)


def boss(bench):
    mount = value_of(bench.document, "mount_thickness")
    holes = 3 * math.pi * value_of(bench.document, "mount_hole_radius") ** 2 * 2 / 3 * mount
    radius = value_of(bench.document, "mount_radius")
    low, high = math.pi * 4 ** 2 * 10, math.pi * 4 ** 2 * 10 + holes
    height = bench.change_of("Follower", z=(0.0, 10.0), boss_height="10 mm", boss_radius="4 mm")
    assert low - 0.01 <= height <= high, (low, height, high)
    wide = bench.change_of("Follower", z=(0.0, 10.0), boss_height="10 mm",
                           boss_radius="%.4f mm" % radius)
    assert wide > math.pi * radius ** 2 * 10 - 0.01, wide
    with_boss = dict(boss_height="10 mm", boss_radius="4 mm")
    hole = dict(with_boss, boss_bore="1", boss_bore_diameter="4 mm")
    for values, area in (
        (hole, math.pi * 2.1 ** 2),
        (dict(hole, boss_keyway="1"), math.pi * 2.1 ** 2 + slot(2.1, 2, 1)),
        (dict(with_boss, boss_bore_preset="5"), star(2.95, 23)),
    ):
        bench.change("Follower", height - 10 * area, z=(0.0, 10.0), **values)
    screwed = bench.change_of("Follower", z=(0.0, 10.0), boss_screw="2 mm", **with_boss)
    assert screwed < height - math.pi * 1.1 ** 2 * 3, (screwed, height)


def webs(document):
    """Discs show where the drum is smaller; one per band, less what ribs and teeth fill."""
    for gear in ("driver", "follower"):
        alias = gear + "_hub_radius"
        designed = value_of(document, alias)
        sheet, cell = parameters.cell_of(document, alias)
        least = sheet.get(cell.replace("B", "C")).Value
        inner, outer = least, least + 0.6 * (designed - least)
        if outer - inner < 0.3:
            continue
        write(document, {alias: "%.6f mm" % inner})
        bench = Bench(document)
        found = bench.change_of(gear.capitalize(), **{
            gear + "_web_radius": "%.6f mm" % outer, gear + "_web_thickness": "1 mm"})
        number = document.getObject(gear.title() + "Webs").ElementCount
        full = number * math.pi * (outer ** 2 - inner ** 2)
        assert 0.6 * full < found <= full + 0.01, (gear, found, full, number)
        bench.is_as_before()
        write(document, {alias: "%.6f mm" % designed})
        measured(document)


def spokes(document):
    """Tapered ribs are heavier in both gears, and the support stays as it is."""
    before = measured(document)
    write(document, {"rib_foot": "1.75 mm"})
    after = measured(document)
    for name in ("Driver", "Follower"):
        assert after[name][0] > before[name][0] + 0.2, (name, before, after)
    assert abs(after["Support"][0] - before["Support"][0]) < 1e-3
    write(document, {"rib_foot": "%.6f mm" % value_of(document, "rib")})
    assert abs(measured(document)["Driver"][0] - before["Driver"][0]) < 1e-3


def support(bench):
    play = value_of(bench.document, "journal_radius") + value_of(bench.document, "joint_play")
    bench.change("Support", -2 * 4 * math.pi * (25 - play ** 2), seat_diameter="10 mm")
    bench.change("Support", -2 * 3 * math.pi * (25 - play ** 2), seat_diameter="10 mm",
                 seat_width="3 mm")
    bench.change("Support", 4 * 5 * math.pi * 16, z=(-5.0, 0.0), feet_height="5 mm")
    bench.change("Support", 4 * 5 * math.pi * 9, z=(-5.0, 0.0), feet_height="5 mm",
                 feet_radius="3 mm")


def lies_flat(document):
    """Every piece of the print layout is one valid solid on z = 0, also after a change."""
    def lowest():
        found = {}
        for piece in document.Print.Group:
            shape = piece.LinkedObject.Shape.copy()
            assert len(shape.Solids) == 1 and shape.isValid(), piece.Label
            shape.Placement = piece.Placement.multiply(shape.Placement)
            found[piece.Label] = shape.BoundBox
        return found

    boxes = lowest()
    assert len(boxes) >= 6, list(boxes)
    plate = value_of(document, "plate_thickness")
    write(document, {"plate_thickness": "%.6f mm" % (plate + 2)})
    measured(document)
    for when in (boxes, lowest()):
        assert all(abs(box.ZMin) < 1e-6 for box in when.values()), {k: b.ZMin for k, b in when.items()}
        spans = sorted((box.XMin, box.XMax) for box in when.values())
        assert all(a[1] < b[0] for a, b in zip(spans, spans[1:])), spans
    write(document, {"plate_thickness": "%.6f mm" % plate})
    measured(document)


def main():
    document = open_design.open_design(os.environ["MPCGEAR_DESIGN"])
    assert check.broken(document) == [], check.broken(document)
    bench = Bench(document)
    bores(bench)
    walls(document)
    set_screws(bench)
    boss(bench)
    support(bench)
    bench.is_as_before()
    webs(document)
    spokes(document)
    lies_flat(document)


try:
    main()
    code = 0
except BaseException:  # freecadcmd would run the file again and exit with 0
    traceback.print_exc()
    code = 1
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)
