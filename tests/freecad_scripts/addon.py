"""Runs inside freecadcmd: the add-on without a window, judged on a design of uniform motion.

The add-on is installed; MPCGEAR_DESIGN is a design.json; exit code 0 when all holds.
"""

import math
import os
import sys
import tempfile
import traceback

import FreeCAD as App

from freecad.mpcgear import check, clearance, files, mechanism, open_design, parameters, poses, teeth


def same(a, b, tolerance):
    return abs(a - b) <= tolerance


def value_of(document, alias):
    sheet, _ = parameters.cell_of(document, alias)
    return getattr(sheet, alias + "_mm").Value


def edit(document, alias, value, form="=%.9f mm"):
    """Types a value and recomputes; returns what the column Check says to it."""
    sheet, cell = parameters.cell_of(document, alias)
    sheet.set(cell, form % value)
    document.recompute()
    if teeth.stale(document):
        teeth.rebuild(document)
        document.recompute()
    assert check.broken(document) == [], check.broken(document)
    return sheet.get(cell.replace("B", "E"))


def volumes(document):
    return {p.Name: files.solid_of(p).Volume for p in mechanism.Mechanism(document).parts()}


def expressions_keep_their_units():
    document = App.newDocument("Units")
    names, sheet = parameters.Names(), parameters.new_sheet(document, "Params")
    for row, alias in enumerate(("first", "second"), 2):
        parameters.write_parameter(sheet, row, alias, 3.0, (0.0, 9.0), "", names)
    term = parameters.Expression(names).length
    box = document.addObject("Part::Box", "Box")
    document.recompute()
    for text, value in (("3", 3), ("-(2 + 1) * 2", -6), ("7 / 2", 3.5), ("-40 - -2", -38),
                        ("first * second / first + 2", 5)):
        assert same(box.evalExpression(term(text)).Value, value, 1e-9), text
    for typed, value in (("=4", 4), ("4.5", 4.5), ("=0", 0), ("=0.1 in", 2.54), ("=2 + 1.5", 3.5), ("=-2 mm", -2)):
        sheet.set("B2", typed)
        document.recompute()
        assert same(box.evalExpression(term("first + 1")).Value, value + 1, 1e-9), typed
        expected = "TOO SMALL" if value < 0 else "ok"
        assert sheet.get("E2") == expected, (typed, sheet.get("E2"))
    try:
        term("first ** second")
    except ValueError:
        return
    raise AssertionError("a power is no recipe expression")


def parameters_change_what_they_name(document):
    before = volumes(document)
    radius = value_of(document, "driver_hub_radius")
    edit(document, "driver_hub_radius", radius - 0.3)
    after = volumes(document)
    assert after["Driver"] < before["Driver"] - 10, (before, after)
    assert same(after["Follower"], before["Follower"], 1e-3), (before, after)
    assert same(after["Support"], before["Support"], 1e-3), (before, after)
    assert edit(document, "driver_hub_radius", 10 * radius, "%.9f") == "TOO LARGE"
    assert edit(document, "driver_hub_radius", radius) == "ok"
    assert same(volumes(document)["Driver"], before["Driver"], 1e-3)
    edit(document, "clearance", 0.5)
    box = document.ToothSection1.Shape.BoundBox
    assert same(box.XMin, 0.25, 1e-6) and same(box.XLength, 1.8, 1e-6), box
    assert not same(volumes(document)["Driver"], before["Driver"], 1e-1)
    edit(document, "clearance", 0.1)
    assert same(volumes(document)["Driver"], before["Driver"], 1e-3)


def every_cell_survives_a_plain_number(document):
    """The same value without its unit changes nothing, in every row that somebody may edit."""
    before, typed = volumes(document), 0
    for sheet in document.findObjects("Spreadsheet::Sheet"):
        for row in range(2, 90):
            alias, used = (sheet.getAlias("%s%d" % (column, row)) for column in "BG")
            if used:
                sheet.set("B%d" % row, "%.9f" % getattr(sheet, used).Value)
                typed += 1
    document.recompute()
    assert typed > 30, typed
    assert check.broken(document) == [] and teeth.stale(document) == [], check.broken(document)
    after = volumes(document)
    assert all(same(after[name], before[name], 1e-3) for name in before), (before, after)


def check_speaks_up(document):
    """Teeth that are not rebuilt and objects that do not recompute are told in the sheet Check."""
    table = document.Check
    assert check.update(document) == [] and (table.B2, table.B3) == ("ok", "ok"), (table.B2, table.B3)
    sheet, cell = parameters.cell_of(document, "clearance")
    for value, words in (("=0.2 mm", "NOT REBUILT"), ("=0.1 mm", "ok")):
        sheet.set(cell, value)
        document.recompute()
        assert table.B2.startswith(words), table.B2
    sheet, cell = parameters.cell_of(document, "journal_radius")
    before = sheet.getContents(cell)
    for value, words in (("=-1 mm", "NOT OK: "), (before, "ok")):
        sheet.set(cell, value)
        document.recompute()
        check.update(document)
        assert table.B3.startswith(words), table.B3
        assert table.Label == ("Check: ok" if words == "ok" else "Check: NOT OK"), table.Label


def drives(document):
    gear = mechanism.Mechanism(document)
    for low, high in zip(gear.phis, gear.phis[1:]):
        if high - low > 0.2:  # the design of the test has only a few teeth
            continue
        phi = 0.5 * (low + high)
        pose, _ = gear.at(phi)
        expected = App.Rotation(App.Vector(0, 0, 1), -math.degrees(phi))
        assert pose.Base.Length < 1e-6, pose
        assert pose.Rotation.multiply(expected.inverted()).Angle < 1e-6, (phi, pose)
    gear.move(gear.phis[len(gear.phis) // 2])
    again = mechanism.Mechanism(document)
    assert same(again.phi, gear.phi, 1e-6), (again.phi, gear.phi)
    touched = [o.Name for o in document.Objects if "Touched" in o.State]
    assert touched == [], touched


def sees_clearance_and_overlap(document):
    gear = mechanism.Mechanism(document)
    gear.move(gear.phis[len(gear.phis) // 2])
    near = clearance.here(gear)
    teeth = [c for c in near if "Driver tooth" in c.first and "Follower tooth" in c.second]
    assert teeth and all(c.overlap == 0 for c in near), [str(c) for c in near]
    assert same(min(c.gap for c in teeth), 0.1, 0.01), [str(c) for c in teeth]
    document.Driver.Placement = poses.driver_placement(gear.distance, gear.phi + 0.05)
    forced = [c for c in clearance.here(gear) if c.overlap > clearance.TOUCH]
    assert forced, "turning the driver alone has to make its teeth hit the follower"
    gear.move(gear.phi)


def sweep_sees_what_was_added(document):
    """A stick on the driver that points beside the follower now hits its hub later."""
    gear = mechanism.Mechanism(document)
    gear.move(gear.phis[0])
    hits = gear.phis[len(gear.phis) // 2]
    assert hits - gear.phis[0] > 0.5, (gear.phis[0], hits)
    stick = document.addObject("Part::Box", "Stick")
    document.Driver.addObject(stick)
    hidden = document.addObject("Part::Box", "Hidden")
    document.Driver.addObject(hidden)
    stick.Label, stick.Length, stick.Width, stick.Height = "stick", 30, 1, 1
    for box in (stick, hidden):
        box.Placement = App.Placement(
            App.Vector(), App.Rotation(App.Vector(0, 0, 1), -math.degrees(hits)),
            App.Vector(-gear.distance, 0, 0)).multiply(
                App.Placement(App.Vector(-gear.distance, -0.5, 0), App.Rotation()))
    hidden.Visibility = False
    document.recompute()
    where = [part.Placement.Base for part in (document.Driver, document.Follower)]
    both = {"stick", "Follower"}
    assert not [c for c in clearance.here(gear) if {c.first, c.second} == both]
    found = clearance.sweep(gear, 36)
    assert not [c for c in found if "Hidden" in (c.first, c.second)], [str(c) for c in found]
    worst, = [c for c in found if {c.first, c.second} == both]
    assert worst.overlap > 1, [str(c) for c in found]
    assert same(worst.phi, hits, 0.25), (worst.phi, hits)
    assert [part.Placement.Base for part in (document.Driver, document.Follower)] == where
    assert [o.Name for o in document.Objects if "Touched" in o.State] == []
    for name in ("Stick", "Hidden"):
        document.removeObject(name)
    document.recompute()


def survives_reopening(document):
    path = os.path.join(tempfile.mkdtemp(), "again.FCStd")
    assert not [o for o in document.Objects if "Python" in o.TypeId], "needs the add-on to live on"
    document.saveAs(path)
    App.closeDocument(document.Name)
    document = App.openDocument(path)
    before = volumes(document)
    edit(document, "journal_radius", value_of(document, "journal_radius") - 0.5)
    after = volumes(document)
    assert after["Driver"] < before["Driver"] - 1, (before, after)


def refuses_other_files():
    path = os.path.join(tempfile.mkdtemp(), "other.json")
    with open(path, "w") as out:
        out.write("{}")
    try:
        open_design.read(path)
    except open_design.DesignError as error:
        assert "design.json" in str(error)
        return
    raise AssertionError("an empty object is no design")


def main():
    expressions_keep_their_units()
    refuses_other_files()
    document = open_design.open_design(os.environ["MPCGEAR_DESIGN"])
    assert check.broken(document) == [], check.broken(document)
    parameters_change_what_they_name(document)
    every_cell_survives_a_plain_number(document)
    check_speaks_up(document)
    drives(document)
    sees_clearance_and_overlap(document)
    sweep_sees_what_was_added(document)
    survives_reopening(document)


try:
    main()
    code = 0
except BaseException:  # freecadcmd would run the file again and exit with 0
    traceback.print_exc()
    code = 1
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)
