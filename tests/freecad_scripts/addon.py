"""Runs inside freecadcmd: the add-on without a window, judged on a design of uniform motion.

MPCGEAR_ADDON is the add-on's folder, MPCGEAR_DESIGN a design.json; exit code 0 when all holds.
"""

import math
import os
import sys
import tempfile
import traceback

import FreeCAD as App

sys.path.insert(0, os.environ["MPCGEAR_ADDON"])

from mpcgear import files, mechanism, open_design, parameters, poses  # noqa: E402


def same(a, b, tolerance):
    return abs(a - b) <= tolerance


def edit(document, sheet, alias, value):
    table = document.getObject(sheet)
    table.set(table.getCellFromAlias(alias), "=%.9f mm" % value)
    document.recompute()
    assert files.broken(document) == [], files.broken(document)


def volumes(document):
    return {p.Name: files.solid_of(p).Volume for p in mechanism.Mechanism(document).parts()}


def expressions_keep_their_units():
    term = parameters.Expression({"a", "b"}).length
    box = App.newDocument("Units").addObject("Part::Box", "Box")
    for text, value in (("3", 3), ("-(2 + 1) * 2", -6), ("7 / 2", 3.5), ("-40 - -2", -38)):
        assert same(box.evalExpression(term(text)).Value, value, 1e-9), text
    assert "Params.a" in term("a * b / a + 2")
    try:
        term("a ** b")
    except ValueError:
        return
    raise AssertionError("a power is no recipe expression")


def parameters_change_what_they_name(document):
    before = volumes(document)
    radius = document.Params.driver_hub_radius.Value
    edit(document, "Params", "driver_hub_radius", radius - 0.3)
    after = volumes(document)
    assert after["Driver"] < before["Driver"] - 10, (before, after)
    assert same(after["Follower"], before["Follower"], 1e-3), (before, after)
    assert same(after["Support"], before["Support"], 1e-3), (before, after)
    edit(document, "Params", "driver_hub_radius", 10 * radius)
    check = document.Params.getCellFromAlias("driver_hub_radius").replace("B", "E")
    assert document.Params.get(check) == "TOO LARGE", document.Params.get(check)
    edit(document, "Params", "driver_hub_radius", radius)
    assert same(volumes(document)["Driver"], before["Driver"], 1e-3)
    edit(document, "ToothParams", "clearance", 0.5)
    box = document.ToothSection1.Shape.BoundBox
    assert same(box.XMin, 0.25, 1e-6) and same(box.XLength, 1.8, 1e-6), box
    edit(document, "ToothParams", "clearance", 0.1)
    assert same(volumes(document)["Driver"], before["Driver"], 1e-3)


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


def sees_clearance_and_overlap(document):
    gear = mechanism.Mechanism(document)
    gear.move(gear.phis[len(gear.phis) // 2])
    near = gear.clearance()
    teeth = [c for c in near if "Fin Driver" in c.first and "Fin Follower" in c.second]
    assert teeth and all(c.overlap == 0 for c in near), [str(c) for c in near]
    assert same(min(c.gap for c in teeth), 0.1, 0.01), [str(c) for c in teeth]
    document.Driver.Placement = poses.driver_placement(gear.distance, gear.phi + 0.05)
    forced = [c for c in gear.clearance() if c.overlap > mechanism.TOUCH]
    assert forced, "turning the driver alone has to make its teeth hit the follower"
    gear.move(gear.phi)


def survives_reopening(document):
    path = os.path.join(tempfile.mkdtemp(), "again.FCStd")
    assert not [o for o in document.Objects if "Python" in o.TypeId], "needs the add-on to live on"
    document.saveAs(path)
    App.closeDocument(document.Name)
    document = App.openDocument(path)
    before = volumes(document)
    edit(document, "Params", "journal_radius", document.Params.journal_radius.Value - 0.5)
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
    assert files.broken(document) == [], files.broken(document)
    parameters_change_what_they_name(document)
    drives(document)
    sees_clearance_and_overlap(document)
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
