# --- Options: bores, keyway, set screw, bearing seats ---------------------------------------------
# A tool waits far away from its part until a cell of the sheet `Options` says that it cuts: plain
# Part objects cannot be switched on and off otherwise, and every one of them stays editable.

from .parameters import new_sheet, write_parameter

# Body: (alias, value, (min, max), unit, words)
OPTION_ROWS = {
    "driver": [
        ("bore", 0, (0, 3), "", "Hole in the shaft end: 0 none, 1 round, 2 D-shaped, 3 hexagonal"),
        ("bore_diameter", 5, (1, 40), " mm",
         "Diameter of the shaft in it, across flats if hexagonal (NEMA 14 and 17: 5, NEMA 23: 6.35)"),
        ("bore_flat", 0.5, (0.1, 5), " mm", "Depth of the D's flat"),
        ("bore_depth", 10, (1, 200), " mm", "Depth of the hole from the upper end"),
        ("bore_fit", 0.1, (0, 0.5), " mm", "Gap all around the shaft"),
        ("keyway_width", 0, (0, 12), " mm", "Width of a keyway in a round hole, 0 for none "
         "(DIN 6885: 2 up to a shaft of 8, 3 up to 10, 4 up to 12, 5 up to 17)"),
        ("keyway_depth", 1, (0.5, 4), " mm",
         "Depth of the keyway in the hub (DIN 6885: 1, 1.4, 1.8, 2.3)"),
        ("set_screw", 0, (0, 6), " mm", "Diameter of a set screw's hole in the shaft end, 0 for none"),
    ],
    "support": [
        ("seat_diameter", 0, (0, 40), " mm",
         "Outer diameter of the driver's ball bearings and their fit, 0 for plain holes "
         "(MR105: 10.1, 608: 22.1); Params.bearing_wall has to leave a wall around them"),
        ("seat_width", 4, (1, 9), " mm", "Width of the bearings (MR105: 4, 608: 7)"),
    ],
}


def build_options(document):
    """The sheet `Options`, one aliased row per option of the bodies that are there."""
    sheet, row = new_sheet(document, "Options"), 2
    for body, rows in OPTION_ROWS.items():
        for alias, value, limits, unit, words in rows:
            write_parameter(sheet, row, alias, value, limits, "%s: %s" % (body, words), unit)
            row += 1
    document.recompute()


def option_tools(builder, body):
    """The tools that the options of `body` cut with; `builder` makes primitives in its part."""
    if body not in OPTION_ROWS:
        return []
    group = builder.part.newObject("App::DocumentObjectGroup", builder.name + "Options")
    group.Label = "%s: options" % builder.name
    return (driver_tools if body == "driver" else support_tools)(builder, group)


def driver_tools(builder, group):
    """Bore of the shaft end, its keyway and its set screw."""
    top = builder.expression.length("driver_top + joint_play + bridge_thickness + shaft_end")
    axis = builder.expression.length("-center_distance")
    radius, depth = "(Options.bore_diameter / 2 + Options.bore_fit)", "(Options.bore_depth + 1 mm)"

    def tool(kind, name, kinds, **lengths):
        made = builder.new("Part::" + kind, name, group)
        for key, expression in lengths.items():
            made.setExpression(key, expression)
        away = "1000 mm"
        made.setExpression("Placement.Base.z", "Options.bore == %d ? (%s - Options.bore_depth) : %s"
                           % (kinds, top, away))
        return made

    def across(made, x, y):
        made.setExpression("Placement.Base.x", axis + x)
        made.setExpression("Placement.Base.y", y)
        return made

    bore = across(tool("Cylinder", "Bore round", 1, Radius=radius, Height=depth), "", "0 mm")
    shaft = across(tool("Cylinder", "Bore of a D", 2, Radius=radius, Height=depth), "", "0 mm")
    flat = across(tool("Box", "Flat of a D", 2, Length="2 * %s - Options.bore_flat" % radius,
                       Width="2 * " + radius, Height=depth), " - " + radius, "-" + radius)
    d_shape = builder.boolean("MultiCommon", builder.name + "BoreD", Shapes=[shaft, flat])
    hexagon = tool("Prism", "Bore hexagonal", 3, Circumradius=radius + " / cos(30 deg)", Height=depth)
    hexagon.Polygon = 6
    across(hexagon, "", "0 mm")
    width = "max(Options.keyway_width; 0.1 mm)"
    keyway = across(tool("Box", "Keyway", 1, Length=width, Height=depth,
                         Width=radius + " + Options.keyway_depth"), " - %s / 2" % width, "0 mm")
    keyway.setExpression("Placement.Base.z", "Options.keyway_width > 0 mm ? (Options.bore == 1 ? "
                         "(%s - Options.bore_depth) : 1000 mm) : 1000 mm" % top)
    screw = builder.new("Part::Cylinder", "Set screw", group)
    builder.stand(screw, ("-center_distance", "0", "0"), (-1, 0, 0))  # opposite to the shaft's flat
    screw.setExpression("Radius", "max(Options.set_screw; 0.1 mm) / 2")
    screw.setExpression("Height", builder.expression.length("journal_radius + 1"))
    screw.setExpression("Placement.Base.z", "Options.set_screw > 0 mm ? (%s - %s) : 1000 mm"
                        % (top, builder.expression.length("shaft_end / 2")))
    return [bore, d_shape, hexagon, keyway, screw]


def support_tools(builder, group):
    """Seats of ball bearings in base plate and bridge, open towards the driver."""
    tools = []
    for name, bottom in (("Seat in the base", "driver_bottom - joint_play"),
                         ("Seat in the bridge", "driver_top + joint_play")):
        seat = builder.new("Part::Cylinder", name, group)
        builder.stand(seat, ("-center_distance", "0", "0"))
        seat.setExpression("Radius", "max(Options.seat_diameter; 0.1 mm) / 2")
        seat.setExpression("Height", "Options.seat_width + 1 mm")
        start = "Options.seat_width" if "base" in name else "1 mm"
        seat.setExpression("Placement.Base.z", "Options.seat_diameter > 0 mm ? (%s - %s) : 1000 mm"
                           % (builder.expression.length(bottom), start))
        tools.append(seat)
    return tools
