# --- Motion: where driver, follower and slider are at driver angle φ -----------------------------

import math

import FreeCAD as App

from .parameters import number


def vector(values):
    """A FreeCAD vector from three numbers."""
    return App.Vector(*values)


def triad(a, b):
    """Right-handed orthonormal axes made of two independent vectors, as a rotation."""
    return App.Rotation(a, b, a.cross(b), "XYZ")


def follower_poses(design):
    """[(φ in rad, placement of the follower)], increasing φ in [0, 2π]: every contact is known both
    in the fixed frame and in the follower's, so two normals fix the rotation and a point the rest."""
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
            poses[round(phi, 9)] = App.Placement(base, rotation)
    return sorted(poses.items())


def build_poses(document, design):
    """The spreadsheet `Poses`: where the follower is and how large Q is, over one turn."""
    sheet = document.addObject("Spreadsheet::Sheet", "Poses")
    titles = ["phi_deg", "x_mm", "y_mm", "z_mm", "q0", "q1", "q2", "q3", "Q"]
    for column, title in zip("ABCDEFGHI", titles):
        sheet.set(column + "1", title)
    sheet.setStyle("A1:I1", "bold", "add")
    for row, (phi, pose) in enumerate(follower_poses(design), 2):
        values = [math.degrees(phi)] + list(pose.Base) + list(pose.Rotation.Q)
        values.append(closure_at(design["closure"], phi))
        for column, value in zip("ABCDEFGHI", values):
            sheet.set(column + str(row), "=" + number(value))


def closure_at(samples, phi):
    """Q of the sample nearest to φ."""
    turn = 2 * math.pi

    def away(sample):
        return abs((sample["phi"] - phi + math.pi) % turn - math.pi)

    return min(samples, key=away)["q"] if samples else 0.0


def driver_placement(distance, phi):
    """Driver turned by φ (rad) about the line x = −distance, y = 0."""
    return App.Placement(App.Vector(0, 0, 0), App.Rotation(App.Vector(0, 0, 1), math.degrees(phi)),
                         App.Vector(-distance, 0, 0))


def place(document, distance, phi, pose):
    """Moves the parts to driver angle φ (rad), with the follower at `pose`."""
    document.Driver.Placement = driver_placement(distance, phi)
    document.Follower.Placement = pose
    slider = document.getObject("Slider")
    if slider is not None:
        slider.Placement = App.Placement(App.Vector(0, 0, pose.Base.z), App.Rotation())
