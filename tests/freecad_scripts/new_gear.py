"""Runs inside freecadcmd: from a motion to a draft, and a redesign that keeps what the user has built.

The add-on is installed; MPCGEAR_DESIGN is a design.json of class 1R, MPCGEAR_BINARY the program; exit code 0 when
all holds. The judge is geometry: circles, cones and turns whose tilt and slide are known.
"""

import json
import math
import os
import sys
import tempfile
import time
import traceback

import FreeCAD as App
import Part

from freecad.mpcgear import check, files, jobs, motions, open_design, parameters, program, redesign

Z = App.Vector(0, 0, 1)


def near(a, b, tolerance=1e-3):
    assert abs(a - b) <= tolerance, (a, b)


def course(gear_class, motion):
    return jobs.Job(motions.motion_file('a "name"', gear_class, motion)).course()


def refused(action, *words):
    """`action` fails with a message that has all `words`."""
    try:
        action()
    except (motions.MotionError, program.ProgramError, redesign.NotRedesigned) as error:
        assert all(word in str(error) for word in words), (words, str(error))
        return
    raise AssertionError("not refused: %s" % (words,))


def formulas_are_what_they_say():
    made = course("3R1T", motions.formula("3R1T", "", ["8*deg*cos(phi)", "", ""], "2*sin(phi)"))
    near(max(made["tilt_deg"]), 8)
    near(made["slide_mm"][90], 2)
    plain = motions.formula("1R", "-phi", ["1", "1", "1"], "5")
    assert set(plain) == {"kind", "own_turn"}, plain
    refused(lambda: course("3R", motions.formula("3R", "-phi + sin(", ["", "", ""], "")), "own_turn")


def examples_come_from_the_program():
    assert "trefoil" in jobs.example("trefoil")
    refused(lambda: jobs.example("quatrefoil"), "quatrefoil")


def csv_files_are_told_apart():
    path = os.path.join(tempfile.mkdtemp(), "my.csv")

    def table(text):
        with open(path, "w") as out:
            out.write(text)
        return motions.table(path)

    turn = ["%d,0,0,%.6f,%.9f,0,0,%.9f" % (p, math.sin(math.radians(p)), math.cos(math.radians(p / 2)),
                                           -math.sin(math.radians(p / 2))) for p in range(0, 361, 10)]
    made = course("1R1T", table("# poses\nphi_deg,x,y,z,qw,qx,qy,qz\n" + "\n".join(turn)))
    near(max(made["slide_mm"]), 1)
    assert table("1,2,3\n4,5,6\n") == {"kind": "path", "points": [[1, 2, 3], [4, 5, 6]]}
    refused(lambda: table("x,y,z\n1,2,3\n1,two,3\n"), "line 3", "two")
    refused(lambda: table("1,2\n"), "columns", "2")


def a_circle_above_the_joint_is_a_cone():
    centre = App.Vector(3, 4, 5)
    edge = Part.makeCircle(7, centre + App.Vector(0, 0, 40))
    motion, moved = motions.along([edge], centre, "3R")
    near(moved, 0)
    made = course("3R", motion)
    for tilt in (min(made["tilt_deg"]), max(made["tilt_deg"])):
        near(tilt, math.degrees(math.atan(7 / 40)), 0.01)
    square = Part.makePolygon([App.Vector(x, y, 40) for x, y in ((4, 4), (-4, 4), (-4, -4), (4, -4), (4, 4))])
    near(motions.along(square.Edges, App.Vector(), "3R")[1], 0.1, 0.1)
    refused(lambda: motions.along(square.Edges[:3], App.Vector(), "3R"), "closed")


def recorded_poses_are_gone_through():
    centre = App.Vector(10, 0, 20)

    def leaning(phi):
        turn = App.Rotation(App.Vector(math.cos(phi), math.sin(phi), 0), 6)
        return App.Placement(App.Vector(), turn, centre).multiply(App.Placement(App.Vector(1, 2, 3), App.Rotation()))

    upright = App.Placement(App.Vector(1, 2, 3), App.Rotation())
    placements = [upright] + [leaning(phi) for phi in (0.5, 1.5, 2.5)] + [upright]
    motion, off, turns = motions.recorded(placements, centre, "3R")
    near(off, 0)
    assert not turns
    made = course("3R", motion)
    for i, tilt in ((0, 0), (72, 6), (144, 6), (216, 6), (288, 0)):
        near(made["tilt_deg"][i], tilt)
    spinning = [App.Placement(App.Vector(0, 0, math.sin(phi)), App.Rotation(Z, -math.degrees(phi)))
                for phi in (2 * math.pi * i / 12 for i in range(12))]
    motion, off, turns = motions.recorded(spinning, App.Vector(), "1R1T")
    assert turns and off < 1e-9, off
    made = course("1R1T", motion)
    near(made["slide_mm"][90], 1)
    near(max(abs(turn + phi) for turn, phi in zip(made["turn_deg"], made["phi_deg"])), 0)
    near(motions.recorded(spinning, App.Vector(), "1R")[1], 1)
    refused(lambda: motions.recorded(placements[:2], centre, "3R"), "2 poses")


def drafts_and_stops():
    text = motions.motion_file("mine", "1R", motions.formula("1R", "-phi + 0.1*sin(phi)", [], ""))
    job, seen = jobs.Job(text, ["gear.teeth=9", "load.mass_g=50"]), set()
    job.start(True)
    while job.run.is_running():
        seen.add(job.run.progress.get("stage"))
        time.sleep(0.02)
    path, summary = job.result()
    assert len(seen - {None}) >= 1, seen
    assert summary["draft"] and summary["j"] == 9 and summary["q_min"] > 5, summary
    assert os.path.isfile(path) and "first look" in jobs.told(summary)
    job = jobs.Job(text, ["gear.teeth=2"])
    job.start(True)
    refused(job.result, "gear.teeth", "3")
    job = jobs.Job(text, ["search.effort=50"])
    job.start(False)
    while job.run.is_running() and not job.run.progress:
        time.sleep(0.02)
    began = time.time()
    job.run.stop()
    try:
        assert job.result()[1]["stopped"]
    except program.ProgramError as error:
        assert "Cancelled" in str(error), error
    assert time.time() - began < 60


def redesign_keeps_what_was_built():
    """An arm on the mount, put under the teeth, and a bore that was typed stay; the mount is the new one."""
    path = os.environ["MPCGEAR_DESIGN"]
    document = open_design.open_design(path)
    text = redesign.motion_text(document)
    near(jobs.Job(text).course()["turn_deg"][90], -90)
    part = document.Follower
    arm = document.addObject("Part::Box", "Arm")
    part.addObject(arm)
    arm.Length, arm.Width, arm.Height = 40, 4, 5
    arm.setExpression("Placement.Base.z", "FollowerParams.mount_bottom_mm + FollowerParams.mount_thickness_mm - 1 mm")
    union = document.addObject("Part::MultiFuse", "WithArm")
    part.addObject(union)
    union.Shapes = [part.Hub, arm]
    document.recompute()
    part.Result.Shapes = [union] + part.Result.Shapes[1:]
    sheet, cell = parameters.cell_of(document, "bore")
    sheet.set(cell, "1")
    document.recompute()
    assert check.broken(document) == [], check.broken(document)
    check.update(document)
    labels, before = sorted(o.Label for o in document.Objects), files.solid_of(part)
    assert {"BasePlate", "ShaftEnd", "Check: ok"} <= set(labels), labels

    with open(path) as source:
        design = json.load(source)
    thicker, value = 1.5, None
    for parameter in design["recipe"]["parameters"]:
        if parameter["name"] == "mount_thickness":
            parameter["value"] += thicker
            value = parameter["value"]
    other = os.path.join(tempfile.mkdtemp(), "other.json")
    with open(other, "w") as out:
        json.dump(design, out)
    document.UndoMode = 1
    redesign.redesign(document, other)
    assert check.broken(document) == [], check.broken(document)
    assert document.getObject("WithArm").Shapes[0] == part.Hub and part.Result.Shapes[0].Name == "WithArm"
    near(document.FollowerParams.mount_thickness_mm.Value, value)
    assert parameters.cell_of(document, "bore")[0].getContents(cell) in ("1", "=1")
    after = files.solid_of(part)
    near(after.BoundBox.ZMax, before.BoundBox.ZMax + thicker)
    near(after.BoundBox.XMax, before.BoundBox.XMax)
    assert sorted(o.Label for o in document.Objects) == labels
    redesign.redesign(document, path)
    near(files.solid_of(part).Volume, before.Volume, 1e-2)

    design["class"] = "3R"
    with open(other, "w") as out:
        json.dump(design, out)
    refused(lambda: redesign.redesign(document, other), "1R", "3R")
    refused(lambda: redesign.motion_text(App.newDocument("Empty")), "design.json")


def main():
    formulas_are_what_they_say()
    examples_come_from_the_program()
    csv_files_are_told_apart()
    a_circle_above_the_joint_is_a_cone()
    recorded_poses_are_gone_through()
    drafts_and_stops()
    redesign_keeps_what_was_built()


try:
    main()
    code = 0
except BaseException:  # freecadcmd would run the file again and exit with 0
    traceback.print_exc()
    code = 1
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)
