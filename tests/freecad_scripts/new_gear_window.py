"""Runs inside freecad, with a window: *New gear…* drafts, is cancelled, designs, and designs anew.

The add-on is installed; MPCGEAR_BINARY is the program; exit code 0 when all holds. With MPCGEAR_SHOTS pictures of
the window go into that folder.
"""

import gc
import os
import sys
import time
import traceback

import FreeCAD as App
import FreeCADGui as Gui
from PySide import QtCore, QtGui

SHOTS = os.environ.get("MPCGEAR_SHOTS")


def wait(condition, seconds=180):
    """Lets the window live until `condition` holds; returns how often it could."""
    began, turns = time.time(), 0
    while not condition():
        assert time.time() - began < seconds, "waited for too long"
        QtGui.QApplication.processEvents()
        time.sleep(0.01)
        turns += 1
    return turns


def shot(name):
    """A picture of the window, and of the bodies."""
    if SHOTS:
        began = time.time()
        wait(lambda: time.time() - began > 0.5)
        Gui.getMainWindow().grab().save(os.path.join(SHOTS, name + ".png"))
        if App.ActiveDocument is not None and App.ActiveDocument.Objects:
            Gui.activeDocument().activeView().saveImage(os.path.join(SHOTS, name + "-view.png"), 1200, 900, "White")


def panel_of(command):
    """The panel that a command opens."""
    from freecad.mpcgear import new_gear

    before = [o for o in gc.get_objects() if isinstance(o, new_gear.NewGearPanel)]
    Gui.runCommand(command)
    return [o for o in gc.get_objects() if isinstance(o, new_gear.NewGearPanel) and o not in before][0]


def records_poses(panel):
    document = App.newDocument("Arm")
    arm = document.addObject("Part::Box", "Arm")
    document.recompute()
    panel.source.setCurrentIndex(4)
    panel.record_button.click()
    assert "Select" in panel.words.text(), panel.words.text()
    Gui.Selection.addSelection(arm)
    for tilt in (0, 4, 6, 3):
        arm.Placement.Rotation = App.Rotation(App.Vector(1, 0, 0), tilt)
        panel.record_button.click()
    assert panel.pose_count.text().startswith("4"), panel.pose_count.text()
    panel.guarded(panel.look)
    assert abs(max(panel.plot.course["tilt_deg"]) - 6) < 0.3 and panel.plot.height() > 200
    assert "3R" in panel.verdict.text(), panel.verdict.text()
    shot("recorded")


def follows_a_selected_circle(panel):
    document = App.ActiveDocument
    circle = document.addObject("Part::Circle", "Path")
    circle.Radius, circle.Placement.Base.z = 5, 40
    document.recompute()
    panel.source.setCurrentIndex(3)
    Gui.Selection.clearSelection()
    panel.guarded(panel.look)
    assert "Select" in panel.words.text(), panel.words.text()
    Gui.Selection.addSelection(circle)
    panel.guarded(panel.look)
    assert abs(max(panel.plot.course["tilt_deg"]) - 7.125) < 0.02, panel.words.text()
    App.closeDocument(document.Name)


def drives_and_goes_back(document):
    from freecad.mpcgear.drive import DrivePanel

    panel = DrivePanel(document)
    before = [part.Placement.toMatrix() for part in (document.Driver, document.Follower)]
    panel.slider.setValue(100)
    assert document.Driver.Placement.toMatrix() != before[0]
    panel.back.click()
    after = [part.Placement.toMatrix() for part in (document.Driver, document.Follower)]
    off = [abs(x - y) for a, b in zip(before, after) for x, y in zip(a.A, b.A)]
    assert max(off) < 1e-9, off
    assert not [o.Name for o in document.Objects if "Touched" in o.State]


def main():
    Gui.activateWorkbench("MpcgearWorkbench")
    Gui.getMainWindow().resize(1500, 1100)
    panel = panel_of("Mpcgear_New")
    records_poses(panel)
    follows_a_selected_circle(panel)
    panel.source.setCurrentIndex(0)
    panel.guarded(panel.look)
    shot("example")
    panel.example.setCurrentText("uniform_1r")
    panel.settings["search.effort"].setText("0.2")

    panel.draft_button.click()
    assert not panel.design_button.isEnabled()
    assert wait(panel.draft_button.isEnabled) > 5, "the window stood still"
    assert "first look" in panel.words.text(), panel.words.text()
    assert len(App.getDocument("MpcgearDraft").Objects) == 3
    shot("draft")

    panel.settings["search.effort"].setText("50")
    panel.design_button.click()
    wait(lambda: panel.job.run.progress.get("stage"))
    panel.cancel_button.click()
    wait(panel.draft_button.isEnabled)
    cancelled = panel.words.text()
    assert "Cancelled" in cancelled or "does not work" in cancelled or "proved" in cancelled, cancelled

    for name in list(App.listDocuments()):
        App.closeDocument(name)
    panel.settings["search.effort"].setText("0.2")
    panel.design_button.click()
    wait(lambda: panel.job.run.progress.get("best_hold"))
    shot("designing")
    wait(panel.draft_button.isEnabled)
    assert "proved to work" in panel.words.text(), panel.words.text()
    document = App.ActiveDocument
    assert document.Check.B3 == "ok" and document.getObject("Follower") is not None
    shot("designed")
    panel.reject()

    drives_and_goes_back(document)
    panel = panel_of("Mpcgear_Redesign")
    thickness = document.FollowerParams.mount_thickness_mm.Value
    panel.others.setText("hub.mount_thickness_mm=%g" % (thickness + 1))
    panel.design_button.click()
    wait(panel.draft_button.isEnabled)
    assert App.ActiveDocument == document
    assert abs(document.FollowerParams.mount_thickness_mm.Value - thickness - 1) < 1e-6, panel.words.text()
    assert document.Check.B3 == "ok", document.Check.B3
    shot("redesigned")
    panel.reject()


def run():
    try:
        main()
        code = 0
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


QtCore.QTimer.singleShot(1000, run)
