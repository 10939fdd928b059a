# --- Options: bores, keyways, set screws, boss, webs, bearing seats, feet -------------------------
# Plain Part objects cannot be switched on and off. A tool that cuts waits far away until a cell of
# the sheet `Options` says that it cuts; one that adds waits inside the body. All stay editable.

import math

import FreeCAD as App
import Part

from .parameters import write_formula, write_parameter, write_title

AWAY = "1000 mm"  # where tools that cut wait
SERRATIONS = (25, 23)  # of servo horns
SPLINE_ROOT = 0.93  # share of a spline's radius where its serrations begin
SPLINE_LENGTH = 200.0  # of a rod with 1 mm radius, mm; as long as the deepest hole


def bore_rows(bore, keyway, screw, hole, there="1 == 1"):
    """Rows of a hole for a shaft, with a keyway and a set screw: (alias, value, (min, max), unit,
    words); a formula has no range. None of it shows unless the condition `there` holds."""
    of = {"b": bore, "k": keyway, "s": screw, "there": there}
    size = "({b}_preset == 0 ? {b}_diameter : ({b}_preset <= 2 ? 5 mm : ({b}_preset == 3 ? 6.35 mm : " \
           "({b}_preset == 4 ? 5.9 mm : 5.7 mm))))"
    rows = [
        ("{b}", 0, (0, 4), "", "%s: 0 none, 1 round, 2 D-shaped, 3 hexagonal, 4 splined" % hole),
        ("{b}_preset", 0, (0, 5), "", "Shaft that the hole is for: 0 as set in the next rows, 1 NEMA 14, "
         "2 NEMA 17, 3 NEMA 23, 4 servo horn 25T, 5 servo horn 23T"),
        ("{b}_diameter", 5, (1, 40), " mm", "Diameter of that shaft, across flats if hexagonal"),
        ("{b}_flat", 0.5, (0.1, 5), " mm", "Depth of the D's flat"),
        ("{b}_teeth", 25, (23, 25), "", "Serrations of the spline: 25 or 23"),
        ("{b}_fit", 0.1, (0, 0.5), " mm", "Gap all around the shaft"),
        ("{k}", 0, (0, 1), "", "1 for a keyway to DIN 6885 / ISO 773 in a round hole of 6 mm or more"),
        ("{s}", 0, (0, 5), " mm", "Set screw: 0 none, or its nominal size 2, 2.5, 3, 4 or 5"),
        ("{s}_nut", 1, (0, 1), "", "1 for a pocket that the set screw's nut is pushed into from above"),
        ("{b}_kind", "{there} ? ({b}_preset == 0 ? {b} : ({b}_preset <= 3 ? 2 : 4)) : 0", None, "",
         "Kind of the hole"),
        ("{b}_radius", size + " / 2 + {b}_fit", None, "", "Its radius, with the gap"),
        ("{b}_cut", "{b}_preset == 0 ? {b}_flat : ({b}_preset <= 2 ? 0.5 mm : 0.6 mm)", None, "",
         "Depth of its flat"),
        ("{b}_serrations", "{b}_kind == 4 ? ({b}_preset == 0 ? {b}_teeth : ({b}_preset == 5 ? 23 : 25)) : 0",
         None, "", "Its serrations"),
        ("{k}_shown", "{b}_kind == 1 ? {k} : 0", None, "", "Whether there is a keyway"),
        ("{k}_width", by_size(size, "mm", (8, 2), (10, 3), (12, 4), (17, 5), (22, 6), (30, 8), (99, 10)),
         None, "", "Width of the keyway"),
        ("{k}_depth", by_size(size, "mm", (8, 1), (10, 1.4), (12, 1.8), (17, 2.3), (22, 2.8), (99, 3.3)),
         None, "", "Its depth in the hub"),
        ("{b}_reach", "{b}_kind == 0 ? 0 mm : ({b}_kind == 3 ? {b}_radius / cos(30 deg) : "
         "({k}_shown == 1 ? sqrt(({k}_width / 2) ^ 2 + ({b}_radius + {k}_depth) ^ 2) : "
         "{b}_radius))", None, "", "How far the hole reaches from the axis"),
        ("{s}_shown", "{there} ? ({s} > 0 mm ? 1 : 0) : 0", None, "", "Whether there is a set screw"),
        ("{s}_pocket", "{s}_shown == 1 ? {s}_nut : 0", None, "", "Whether there is a pocket for its nut"),
        ("{s}_hole", by_size("{s}", "mm", (2, 2.2), (2.5, 2.7), (3, 3.2), (4, 4.3), (9, 5.3)), None, "",
         "Diameter of the set screw's hole"),
        ("{s}_flats", by_size("{s}", "mm", (2, 4), (2.5, 5), (3, 5.5), (4, 7), (9, 8)), None, "",
         "Its nut across flats, ISO 4032"),
        ("{s}_height", by_size("{s}", "mm", (2, 1.6), (2.5, 2), (3, 2.4), (4, 3.2), (9, 4.7)), None, "",
         "Height of that nut"),
    ]
    named = lambda text: text.format(**of) if isinstance(text, str) else text
    return [(named(alias), named(value), limits, unit, words)
            for alias, value, limits, unit, words in rows]


def wall_row(alias, hole, wall):
    """Row of the thinnest wall around a hole; its check speaks up below 0.8 mm."""
    return (alias, "%s == 0 ? 1000 mm : %s" % (hole, wall), "0.8 mm", "", "Wall that the hole leaves")


def by_size(what, unit, *steps):
    """Formula of a table: the value of the first step that `what` does not exceed."""
    text = "%g %s" % (steps[-1][1], unit)
    for limit, value in reversed(steps[:-1]):
        text = "(%s <= %g %s ? %g %s : %s)" % (what, limit, unit, value, unit, text)
    return text


def web_rows(gear, radius):
    """Rows of the discs that join a gear's ribs."""
    return [
        (gear + "_web_radius", 0, (0, round(radius, 4)), " mm", "Radius of solid discs that join the "
         "ribs, 0 for none; shows where it exceeds Params.%s_hub_radius" % gear),
        (gear + "_web_thickness", 3, (1, 10), " mm", "Thickness of those discs"),
    ]


def option_rows(design):
    """{body: rows} of the bodies that have options."""
    most = {p["name"]: p["max"] for p in design["recipe"]["parameters"]}
    rows = {
        "driver": [("bore_depth", 10, (1, 200), " mm", "Depth of the hole from the shaft's upper end")]
        + bore_rows("bore", "keyway", "set_screw", "Hole in the shaft end")
        + [wall_row("bore_wall", "bore_kind", "Params.journal_radius - max(bore_reach; Params.shaft_flat + "
                    "bore_reach - (bore_kind == 2 ? bore_cut : 0 mm))")]
        + web_rows("driver", most["driver_hub_radius"]),
        "follower": web_rows("follower", most["follower_hub_radius"]),
        "support": [
            ("seat_diameter", 0, (0, 40), " mm", "Outer diameter of the driver's ball bearings and "
             "their fit, 0 for plain holes (MR105: 10.1, 608: 22.1); Params.bearing_wall has to leave "
             "a wall around them"),
            ("seat_width", 4, (1, 9), " mm", "Width of the bearings (MR105: 4, 608: 7)"),
            ("feet_height", 0, (0, 20), " mm", "Height of feet under the base plate, 0 for none"),
            ("feet_radius", 4, (2, 10), " mm", "Radius of the feet"),
        ],
    }
    if has_boss(design):
        rows["follower"] += [
            ("boss_height", 0, (0, 30), " mm", "Height of a boss on the mount, 0 for none"),
            ("boss_radius", 6, (2, 20), " mm", "Radius of the boss, at most Params.mount_radius"),
        ] + bore_rows("boss_bore", "boss_keyway", "boss_screw", "Hole in the boss", "boss_height > 0 mm")
        rows["follower"].append(wall_row("boss_wall", "boss_bore_kind", "boss_radius - boss_bore_reach"))
    return rows


def has_boss(design):
    """The mount of 1R has the pocket of the pin's cap where a boss would stand."""
    return design["class"] != "1R"


def build_options(document, design, names):
    """Options below the parameters of their bodies, one aliased row each."""
    for body, rows in option_rows(design).items():
        sheet = document.getObject(body.title() + "Params")
        row = sheet_end(sheet)
        write_title(sheet, row, "Options")
        for row, (alias, value, limits, unit, words) in enumerate(rows, row + 1):
            if not isinstance(limits, tuple):
                write_formula(sheet, row, alias, value, words, names, limits)
            else:
                write_parameter(sheet, row, alias, value, limits, words, names, unit)
    document.recompute()


def sheet_end(sheet):
    """The first empty row of a sheet."""
    row = 1
    while sheet.getContents("A%d" % row):
        row += 1
    return row


def spline_blank(document, group):
    """Splined rods with an outer radius of 1 mm, one per number of serrations, below one another with a
    rod's length between them; links to them are scaled."""
    rods = []
    for k, count in enumerate(SERRATIONS):
        corners = []
        for i in range(2 * count + 1):
            radius, angle = SPLINE_ROOT if i % 2 else 1.0, math.pi * i / count
            corners.append(App.Vector(radius * math.cos(angle), radius * math.sin(angle),
                                      -2 * k * SPLINE_LENGTH))
        rods.append(Part.Face(Part.makePolygon(corners)).extrude(App.Vector(0, 0, SPLINE_LENGTH)))
    blank = document.addObject("Part::Feature", "Splines")
    blank.Shape = Part.makeCompound(rods)
    blank.Visibility = False
    group.addObject(blank)


class OptionTools:
    """Makes the tools of one body; `builder` makes primitives in its part."""

    def __init__(self, builder, body):
        self.builder, self.body = builder, body
        self.length = builder.expression.length

    def first(self, axis, bands):
        """Tools that add to the body before anything is cut: webs at the heights `bands`, feet."""
        made = [self.webs(axis, bands)] if bands else []
        return made + (self.feet() if self.body == "support" else [])

    def last(self):
        """Tools that add to the body when the holes of its recipe are cut: the boss covers some."""
        return [self.boss()] if self.body == "follower" and has_boss(self.builder.design) else []

    def cut(self):
        """Tools that cut."""
        joint = "driver_top + joint_play"
        if self.body == "driver":
            top = self.length(joint + " + bridge_thickness + shaft_end")
            middle = self.length(joint + " + bridge_thickness + shaft_end / 2")
            return self.bore("bore", "keyway", "set_screw", "-center_distance", -1,
                             ("(%s - Options.bore_depth)" % top, top, middle),
                             self.length("journal_radius"))
        if self.body == "follower" and has_boss(self.builder.design):
            bottom = "(%s)" % self.length("mount_bottom + mount_thickness")
            return self.bore("boss_bore", "boss_keyway", "boss_screw", "0", 1,
                             (bottom, "(%s + Options.boss_height)" % bottom,
                              "(%s + Options.boss_height / 2)" % bottom),
                             "Options.boss_radius")
        return self.seats() if self.body == "support" else []

    def tool(self, kind, name, **lengths):
        """A primitive whose properties follow expressions."""
        made = self.builder.new("Part::" + kind, self.builder.name + " " + name)
        made.Label = "%s %s" % (self.builder.name, name.lower())
        for key, expression in lengths.items():
            self.follow(made, key, expression)
        return made

    def follow(self, made, key, expression):
        """Lets a property follow an expression of aliases."""
        made.setExpression(key, self.builder.names.resolve(expression))

    def at(self, made, x, y, z):
        """`made`, placed by expressions; a coordinate that is None stays."""
        for key, expression in zip("xyz", (x, y, z)):
            if expression is not None:
                self.follow(made, "Placement.Base." + key, expression)
        return made

    def webs(self, axis, heights):
        """Discs at `heights`, links to one; without a radius, hidden in the drum."""
        gear, radius = self.body, "Params.%s_hub_radius" % self.body
        least = radius if gear == "driver" else "Params.follower_collar_radius"
        shown = "Options.%s_web_radius > %s" % (gear, radius)
        thick = "(%s ? Options.%s_web_thickness : 0.5 mm)" % (shown, gear)
        disc = self.tool("Cylinder", "Web", Height=thick,
                         Radius="%s ? Options.%s_web_radius : (%s - 0.2 mm)" % (shown, gear, least))
        self.at(disc, None, None, "-%s / 2" % thick)
        webs = self.builder.new("App::Link", self.builder.name + " Webs")
        webs.LinkedObject, webs.LinkTransform, webs.ShowElement = disc, True, False
        webs.ElementCount = len(heights)
        webs.PlacementList = [App.Placement(App.Vector(axis.x, axis.y, z), App.Rotation())
                              for z in heights]
        return webs

    def boss(self):
        """Cylinder on the mount that fills covered holes; without height, hidden between the holes."""
        holes = max(self.builder.design["settings"]["hub"]["mount_holes"], 1)
        there = "Options.boss_height > 0 mm ? %s : %s"
        away = [self.length("mount_bolt_radius * %.9f" % share)
                for share in (math.cos(math.pi / holes), math.sin(math.pi / holes))]
        boss = self.tool(
            "Cylinder", "Boss", Radius=there % ("Options.boss_radius", "0.1 mm"),
            Height=there % ("(%s + Options.boss_height)" % self.length("mount_thickness * 0.8"),
                            self.length("mount_thickness / 2")))
        bottom = self.length("mount_bottom + mount_thickness * 0.2")
        return self.at(boss, there % ("0 mm", away[0]), there % ("0 mm", away[1]), bottom)

    def feet(self):
        """Four cylinders under the corners of the base plate; without height, hidden in it."""
        there = "Options.feet_height > 0 mm ? (%s) : (%s)"
        bottom = self.length("driver_bottom - joint_play - plate_thickness")
        inside = self.length("plate_thickness / 4")
        feet = []
        for end, sign in (("tower_front - tower_thickness", "+"), ("base_end", "-")):
            for side, turn in (("base_half_width", "-"), ("-base_half_width", "+")):
                foot = self.tool("Cylinder", "Foot %d" % (len(feet) + 1),
                                 Radius=there % ("Options.feet_radius", "Options.feet_radius / 2"),
                                 Height=there % ("Options.feet_height + 1 mm", inside))
                feet.append(self.at(foot, "%s %s Options.feet_radius" % (self.length(end), sign),
                                    "%s %s Options.feet_radius" % (self.length(side), turn),
                                    there % (bottom + " - Options.feet_height", bottom + " + " + inside)))
        return feet

    def bore(self, bore, keyway, screw, axis, side, heights, outer):
        """Hole from heights[0] up to heights[1], its keyway, and the set screw at heights[2] through
        the wall out to `outer`, on the side of +x or −x."""
        bottom, top, middle = heights
        axis = self.length(axis)
        radius, depth = "Options.%s_radius" % bore, "(%s - %s + 1 mm)" % (top, bottom)

        def where(alias, number, z=bottom):
            return "Options.%s == %d ? %s : %s" % (alias, number, z, AWAY)

        kind = "Options.%s_kind" % bore
        round_at = "%s == 1 ? %s : (%s == 2 ? %s : %s)" % (kind, bottom, kind, bottom, AWAY)

        # Round and D-shaped: a cylinder within a block, whose side is the flat of a D.
        shaft = self.at(self.tool("Cylinder", bore, Radius=radius, Height=depth), axis, None, round_at)
        flat = self.tool("Box", bore + " flat", Width="2 * %s + 2 mm" % radius, Height=depth,
                         Length="2 * {0} + 1 mm + (Options.{1}_kind == 2 ? (-Options.{1}_cut) : 1 mm)"
                         .format(radius, bore))
        flat = self.at(flat, "%s - %s - 1 mm" % (axis, radius), "-%s - 1 mm" % radius, round_at)
        hole = self.builder.boolean("MultiCommon", "%s %s round" % (self.builder.name, bore),
                                    Shapes=[shaft, flat])
        hexagon = self.tool("Prism", bore + " hexagonal", Circumradius=radius + " / cos(30 deg)",
                            Height=depth)
        hexagon.Polygon = 6
        tools = [hole, self.at(hexagon, axis, None, where(bore + "_kind", 3))]
        tools.append(self.spline(bore, axis, bottom))
        slot = self.tool("Box", keyway, Length="Options.%s_width" % keyway, Height=depth,
                         Width="%s + Options.%s_depth" % (radius, keyway))
        tools.append(self.at(slot, "%s - Options.%s_width / 2" % (axis, keyway), None,
                             where(keyway + "_shown", 1)))

        thread = self.tool("Cylinder", screw, Radius="Options.%s_hole / 2" % screw,
                           Height=outer + " + 1 mm")
        thread.Placement.Rotation = App.Rotation(App.Vector(0, 1, 0), 90 * side)
        tools.append(self.at(thread, axis, None, where(screw + "_shown", 1, middle)))
        height = "(Options.%s_height + 0.4 mm)" % screw
        below = "(Options.%s_flats / cos(30 deg) / 2 + 0.2 mm)" % screw
        nut = self.tool("Box", screw + " nut", Length=height, Width="Options.%s_flats + 0.4 mm" % screw,
                        Height="(%s - %s) + %s + 1 mm" % (top, middle, below))
        centre = "(Options.%s_reach + %s) / 2" % (bore, outer)
        tools.append(self.at(
            nut, "%s %s %s - %s / 2" % (axis, "+" if side > 0 else "-", centre, height),
            "-(Options.%s_flats + 0.4 mm) / 2" % screw,
            where(screw + "_pocket", 1, "(%s - %s)" % (middle, below))))
        return tools

    def spline(self, bore, axis, bottom):
        """The splined rods, scaled to the bore: one stands on `bottom`, the others far above or below."""
        link = self.builder.new("App::Link", "%s %s splines" % (self.builder.name, bore))
        link.LinkedObject = self.builder.document.getObject("Splines")
        link.LinkTransform = False
        self.follow(link, "Scale", "Options.%s_radius / 1 mm" % bore)
        stack = 2 * (len(SERRATIONS) - 1) * SPLINE_LENGTH
        z = "%s + %g * Options.%s_radius" % (AWAY, stack, bore)
        for k, count in enumerate(SERRATIONS):
            z = "Options.%s_serrations == %d ? (%s + %g * Options.%s_radius) : (%s)" % (
                bore, count, bottom, 2 * k * SPLINE_LENGTH, bore, z)
        return self.at(link, axis, None, z)

    def seats(self):
        """Seats of ball bearings in base plate and bridge, open towards the driver."""
        tools = []
        for name, bottom, start in (
            ("Seat in the base", "driver_bottom - joint_play", "Options.seat_width"),
            ("Seat in the bridge", "driver_top + joint_play", "1 mm"),
        ):
            seat = self.tool("Cylinder", name, Radius="max(Options.seat_diameter; 0.1 mm) / 2",
                             Height="Options.seat_width + 1 mm")
            tools.append(self.at(seat, self.length("-center_distance"), None,
                                 "Options.seat_diameter > 0 mm ? (%s - %s) : %s"
                                 % (self.length(bottom), start, AWAY)))
        return tools
