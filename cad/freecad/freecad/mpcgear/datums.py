# --- Datums: where to attach what is built on a gear. They depend on hubs alone, never on teeth ----

import FreeCAD as App

from .parameters import Expression, kept


class NotAHub(Exception):
    """What was to go under the teeth is not built on a hub; the text says what to do."""


def build_datums(document, design, names):
    """Axes, joint centre, and the faces that others are built on: each follows the sheets, not a face
    of a solid, so that a sketch attached to it stays when faces come and go."""
    distance = design["settings"]["gear"]["center_distance_mm"]
    driver = App.Placement(App.Vector(-distance, 0, 0), App.Rotation())
    down = App.Rotation(App.Vector(1, 0, 0), 180)
    upright = App.Placement(App.Vector(), App.Rotation(App.Vector(1, 0, 0), 90))
    reach = distance + max(abs(station["p"][2]) for pair in design["sub_gear_pairs"]
                           for tooth in pair["teeth"] for station in tooth["stations"])
    for kind, name, owner, place, height, words in (
        ("Line", "DriverAxis", "Driver", driver, None, "Axis of the driver"),
        ("Line", "FollowerAxis", "Follower", App.Placement(), None, "Axis of the follower at rest"),
        ("Point", "JointCentre", "Follower", App.Placement(), None, "Centre of the follower's joint"),
        ("Plane", "AxesPlane", "Support", upright, None, "Plane of both axes"),
        ("Plane", "MountFace", "Follower", App.Placement(), "mount_bottom + mount_thickness",
         "Face of the follower's mount, z away from it"),
        ("Plane", "ShaftEnd", "Driver", driver,
         "driver_top + joint_play + bridge_thickness + shaft_end", "End face of the driver's shaft"),
        ("Plane", "BasePlate", "Support", App.Placement(App.Vector(), down),
         "driver_bottom - joint_play - plate_thickness", "Underside of the base plate, z away from it"),
    ):
        part = document.getObject(owner)
        datum = kept(document, "PartDesign::" + kind, name)
        datum.Label = name  # a feature of the recipe may have taken the name itself
        datum.Placement = place
        if height is not None:
            datum.setExpression("Placement.Base.z", Expression(names).length(height))
        # By itself FreeCAD draws datums many times as large as the parts.
        if kind != "Point":
            datum.ResizeMode = "Manual"
            datum.Length = 2 * reach if height is None else reach / 2
        if kind == "Plane":
            datum.Width = datum.Length
        if "Meaning" not in datum.PropertiesList:
            part.addObject(datum)
            datum.addProperty("App::PropertyString", "Meaning", "mpcgear", "What it is")
            datum.Visibility = kind != "Plane"
        datum.Meaning = words


def adopt(document, feature):
    """Puts the user's `feature`, built on a hub, in the place of that hub under the teeth; returns the
    body's finished solid."""
    for part in document.findObjects("App::Part"):
        if "Hub" in part.PropertiesList and part.Hub != part.Result and feature in part.Group:
            if part.Hub != feature and part.Hub not in feature.OutListRecursive:
                raise NotAHub("%s is not built on %s" % (feature.Label, part.Hub.Label))
            part.Result.Shapes = [feature] + part.Result.Shapes[1:]
            feature.Visibility = False
            return part.Result
    raise NotAHub("%s belongs to no gear: move it into Driver or Follower first" % feature.Label)
