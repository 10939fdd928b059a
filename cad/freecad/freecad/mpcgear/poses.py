# --- Motion: where driver, follower and slider are at driver angle φ -----------------------------

import math

import FreeCAD as App

from .parameters import kept_sheet, number


def vector(values):
    """A FreeCAD vector from three numbers."""
    return App.Vector(*values)


def copies(design):
    """How many times as many teeth as the follower the driver has: so many periods of the motion make one
    turn of the driver."""
    gear = design["settings"]["gear"]
    driver, follower = (gear.get(name, "auto") for name in ("driver_teeth", "follower_teeth"))
    driver, follower = (gear["teeth"] if own == "auto" else own for own in (driver, follower))
    return driver // follower


def follower_poses(design):
    """[(driver angle φ in rad, placement of the follower)], increasing φ in [0, 2π], of the design's `poses`:
    rows of φ, position in mm, and quaternion with its real part last."""
    return [(row[0], App.Placement(vector(row[1:4]), App.Rotation(*row[4:8])))
            for row in design["poses"]]


def build_poses(document, design):
    """The spreadsheet `Poses`: where the follower is and how large Q is, over one turn."""
    sheet = kept_sheet(document, "Poses")
    titles = ["phi_deg", "x_mm", "y_mm", "z_mm", "q0", "q1", "q2", "q3", "Q"]
    for column, title in zip("ABCDEFGHI", titles):
        sheet.set(column + "1", title)
    sheet.setStyle("A1:I1", "bold", "add")
    for row, (phi, pose) in enumerate(follower_poses(design), 2):
        values = [math.degrees(phi)] + list(pose.Base) + list(pose.Rotation.Q)
        values.append(closure_at(design["closure"], phi * copies(design)))
        for column, value in zip("ABCDEFGHI", values):
            sheet.set(column + str(row), "=" + number(value))


def closure_at(samples, phi):
    """Q of the sample nearest to phase φ."""
    turn = 2 * math.pi

    def away(sample):
        return abs((sample["phi"] - phi + math.pi) % turn - math.pi)

    return min(samples, key=away)["q"] if samples else 0.0


def driver_placement(distance, phi):
    """Driver turned by φ (rad) about the line x = −distance, y = 0."""
    return App.Placement(App.Vector(0, 0, 0), App.Rotation(App.Vector(0, 0, 1), math.degrees(phi)),
                         App.Vector(-distance, 0, 0))


def placements(distance, phi, pose):
    """{part: where it is} at driver angle φ (rad), with the follower at `pose`."""
    lifted = App.Placement(App.Vector(0, 0, pose.Base.z), App.Rotation())
    return {"Driver": driver_placement(distance, phi), "Follower": pose, "Slider": lifted}


def place(document, distance, phi, pose):
    """Moves the parts there."""
    for name, there in placements(distance, phi, pose).items():
        part = document.getObject(name)
        if part is not None:
            part.Placement = there
