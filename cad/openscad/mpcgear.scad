// mpcgear.scad: swept teeth, ribs and plain solids for multi-point conjugation gears.
//
// Every file that mpcgear writes carries a copy of this one, so that it opens anywhere. To write a
// part of your own, put this file beside it and say: use <mpcgear.scad>
// For OpenSCAD 2021.01 and later. SPDX-License-Identifier: MIT OR Apache-2.0

// ---- Tooth section -------------------------------------------------------------------------

// Outline of a tooth's cross section, counter-clockwise, in coordinates (n, b): the contact point
// is the origin, n points into the material, b away from the hub. The flank starts half the
// clearance behind the contact. A bead stands on a neck as thick as the rib, if that is longer than
// 0.1 mm. `segments` is the number of corners of a circle as thick as the tooth.
// The outline is symmetric: corner i mirrors corner -1-i, and the cap faces rely on it.
function tooth_section(thickness, flank_radius, tip, root, clearance, neck, segments) =
    let (
        flank = clearance / 2,
        middle = flank + thickness / 2,
        side = middle - min(neck, thickness) / 2,
        neck_angle = acos(min(max(flank + flank_radius - side, 0) / flank_radius, 1)),
        neck_height = flank_radius * sin(neck_angle),
        has_neck = root > neck_height + 0.1,
        below = has_neck
            ? concat(tooth_side(thickness, flank_radius, flank, neck_height, 0, segments), [[side, root]])
            : tooth_side(thickness, flank_radius, flank, root,
                         min(tooth_edge(thickness, flank_radius, root), side - flank), segments),
        above = tooth_side(thickness, flank_radius, flank, tip,
                           tooth_edge(thickness, flank_radius, tip), segments),
        half = concat([for (i = [len(below) - 1 : -1 : 1]) [below[i].x, -below[i].y]], above),
        last = len(half) - 1,
        pointed = half[last].x > middle - 0.0001
    )
    concat([for (c = half) [2 * middle - c.x, c.y]],
           [for (i = [pointed ? last - 1 : last : -1 : 0]) half[i]]);

// Radius of the edge between a flank that is flatter than a round bead and the end of the section
// `height` above or below the contact: the flank takes 0.15 rad, the edge the rest. 0 on a round bead.
function tooth_edge(thickness, flank_radius, height) =
    let (
        half = (thickness - 0.1) / 2,
        rest = (height - 0.15 * flank_radius) / 0.85,
        widest = (half * (2 * flank_radius - half) - height * height) / (2 * (flank_radius - height))
    )
    flank_radius <= max(thickness / 2, height) ? 0 : min(max(min(max(rest, 0.2), widest), 0), height);

// One side of a section, from the contact's height up to `height`, with an edge of radius `edge`.
function tooth_side(thickness, flank_radius, flank, height, edge, segments) =
    let (
        fineness = segments / 360 / sqrt(thickness / 2),
        meet = acos(max(1 - thickness / 2 / flank_radius, 0)),
        turn = edge > 0 ? asin(min(max((height - edge) / (flank_radius - edge), 0), 1))
                        : min(asin(min(height / flank_radius, 1)), meet),
        away = flank_radius - edge,
        arc = section_arc(flank_radius, [flank + flank_radius, 0], [0, turn], fineness)
    )
    edge <= 0 ? arc
              : concat([for (i = [0 : 1 : len(arc) - 2]) arc[i]],
                       section_arc(edge, [flank + flank_radius - away * cos(turn), away * sin(turn)],
                                   [turn, 90], 0.6 * fineness));

// Corners of an arc, both ends included; angles from -n towards +b.
function section_arc(radius, centre, angles, fineness) =
    let (steps = max(ceil(fineness * sqrt(radius) * (angles[1] - angles[0]) - 0.001), 1))
    [for (i = [0 : steps])
        let (a = angles[0] + (angles[1] - angles[0]) * i / steps)
        [centre.x - radius * cos(a), centre.y + radius * sin(a)]];

// ---- Sweeps --------------------------------------------------------------------------------

// A station is [point, n, b]: where the section stands and how it is turned. Stations follow each
// other in the direction n x b.

// Stations from rows [x, y, z, turn]: the three numbers of a turn are its axis times its angle, and it takes
// x to n and y to b.
function turned(rows) =
    [for (r = rows)
        let (turn = [r[3], r[4], r[5]], angle = norm(turn), k = angle == 0 ? [0, 0, 1] : turn / angle,
             c = cos(angle), s = sin(angle))
        [[r[0], r[1], r[2]],
         c * [1, 0, 0] + s * [0, k.z, -k.y] + (1 - c) * k.x * k,
         c * [0, 1, 0] + s * [-k.z, 0, k.x] + (1 - c) * k.y * k]];

// `count` stations of a list, evenly chosen, both ends included.
function thin(stations, count) =
    let (last = len(stations) - 1, steps = min(count - 1, last))
    [for (i = [0 : steps]) stations[round(i * last / steps)]];

// The section's corners at every station.
function tooth_rings(stations, section) =
    [for (s = stations) [for (c = section) s[0] + c.x * s[1] + c.y * s[2]]];

// Length of a vector's part in the xy plane.
function level_norm(v) = norm([v.x, v.y]);

// All but `inset` stations at both ends, where there are enough.
function inner_stations(stations, inset) =
    len(stations) > 4 * inset
        ? [for (i = [inset : len(stations) - 1 - inset]) stations[i]]
        : stations;

// Half of a rib's outline, [distance from the axis, half thickness] from the bead at `reach` down to
// `foot`: thickness[0] thick at the bead and thickness[1] at the foot, with a fillet of this radius
// where it meets the hub. At the bead's middle it is 3 % thinner: its corners stay inside the bead.
function rib_profile(reach, foot, thickness, hub_radius, fillet) =
    let (
        room = min(fillet, 0.9 * (reach - hub_radius)),
        round = room > 0.02 ? room : 0,
        arc = round == 0 ? [] : [for (a = [0 : 30 : 90])
            [hub_radius + round * (1 - sin(a)), round * (1 - cos(a))]],
        flared = concat([[reach, 0]], arc, [[foot, round]])
    )
    [for (f = flared)
        [f.x, f.y + lookup(f.x, [[foot, thickness[1]], [reach, 0.97 * thickness[0]]]) / 2]];

// The corners of a rib at every station: a wall from the bead's middle, `depth` behind the contact
// point, straight towards the gear's axis through `axis`, ending `foot` from the axis. Thickness and
// fillet are those of rib_profile(); at the foot `flare` is added on either side.
function rib_rings(stations, thickness, depth, axis, foot, hub_radius = 0, fillet = 0, flare = [0, 0]) =
    let (
        outer = [for (s = stations) s[0] + depth * s[1]],
        reach = [for (o = outer) level_norm(o - axis)],
        nearest = min(reach),
        inner_radius = min(foot, 0.8 * nearest),
        room = min(fillet, 0.8 * (nearest - hub_radius))
    )
    [for (i = [0 : len(stations) - 1])
        let (
            radial = [outer[i].x - axis.x, outer[i].y - axis.y, 0] / reach[i],
            across = cross(cross(stations[i][1], stations[i][2]), radial),
            side = across / norm(across),
            half = rib_profile(reach[i], inner_radius, thickness, hub_radius, room),
            last = len(half) - 1,
            share = [for (c = half) (reach[i] - c.x) / (reach[i] - inner_radius)]
        )
        concat([for (k = [0 : last])
                   outer[i] - (reach[i] - half[k].x) * radial + (half[k].y + share[k] * flare[0]) * side],
               [for (k = [last : -1 : 0])
                   outer[i] - (reach[i] - half[k].x) * radial - (half[k].y + share[k] * flare[1]) * side])];

// Triangles of a cap over `n` corners that start at index `first`, as a zigzag of strips.
function cap_faces(n, first) =
    [for (k = [0 : floor((n - 3) / 2)])
        each concat([[first + k, first + k + 1, first + n - 1 - k]],
                    k + 1 < n - 2 - k ? [[first + k + 1, first + n - 2 - k, first + n - 1 - k]] : [])];

// Triangles of a closed shell over `rings` rings of `n` corners each, clockwise from outside. Corner
// i of a ring mirrors corner -1-i, and so do the diagonals on both sides of a twisted wall: what one
// side loses against the ruled surface the other gains.
function shell_faces(rings, n, first) =
    concat(
        [for (r = [0 : rings - 2]) for (i = [0 : n - 1])
            let (a = first + r * n + i, b = first + r * n + (i + 1) % n)
            each 2 * i < n ? [[a, b + n, b], [a, a + n, b + n]] : [[a, a + n, b], [b, a + n, b + n]]],
        cap_faces(n, first),
        [for (f = cap_faces(n, first + (rings - 1) * n)) [f[2], f[1], f[0]]]);

// One polyhedron of several shells, each a list of rings. They must not touch each other.
module shells(solids) {
    starts = [for (i = 0, sum = 0; i < len(solids);
                   sum = sum + len(solids[i]) * len(solids[i][0]), i = i + 1) sum];
    polyhedron(
        points = [for (rings = solids) for (ring = rings) each ring],
        faces = [for (i = [0 : len(solids) - 1])
            each shell_faces(len(solids[i]), len(solids[i][0]), starts[i])]);
}

// Disc around the hub at height `z`, from `inner` in the hub's wall out to `outer`: it joins the ribs.
module web(axis, z, thickness, inner, outer) {
    difference() {
        post(axis, z - thickness / 2, z + thickness / 2, outer);
        post(axis, z - thickness, z + thickness, inner);
    }
}

// ---- Plain solids --------------------------------------------------------------------------

// Corners of the polygon that stands for a circle.
function circle_sides(radius) = radius < 2.5 ? 24 : radius < 6 ? 48 : 72;

// Turns z towards `axis`.
module towards(axis) {
    rotate([0, acos(axis.z / norm(axis)), atan2(axis.y, axis.x)]) children();
}

// Upright cylinder between two heights.
module post(at, bottom, top, radius) {
    translate([at.x, at.y, bottom])
        cylinder(h = top - bottom, r = radius, $fn = circle_sides(radius));
}

// Cylinder from `base` along `axis`.
module rod(base, length, radius, axis = [0, 0, 1]) {
    translate(base) towards(axis)
        cylinder(h = length, r = radius, $fn = circle_sides(radius));
}

// Cone from `base` along `axis`.
module cone(base, length, radius, end_radius, axis = [0, 0, 1]) {
    translate(base) towards(axis)
        cylinder(h = length, r1 = radius, r2 = end_radius, $fn = circle_sides(max(radius, end_radius)));
}

// Box between two opposite corners.
module block(from, to) {
    translate(from) cube(to - from);
}

// Ball about `centre`.
module ball(centre, radius) {
    translate(centre) sphere(r = radius, $fn = 48);
}

// Regular prism, `width` across flats, from `base` along `axis`.
module prism(base, length, width, sides, axis = [0, 0, 1]) {
    translate(base) towards(axis)
        cylinder(h = length, r = width / 2 / cos(180 / sides), $fn = sides);
}

// Turns the direction `up` upwards.
module upright(up) {
    rotate([0, -acos(up.z / norm(up)), 0]) rotate(-atan2(up.y, up.x)) children();
}

// Refuses a value outside its range.
module check(name, value, least, most) {
    assert(value >= least && value <= most,
           str(name, " = ", value, " is out of range: ", least, " to ", most));
}

// Refuses another value than what teeth and motion dictate.
module dictated(name, value, only) {
    assert(abs(value - only) < 0.00005, str(name, " = ", value, " cannot be chosen: teeth and motion dictate ", only));
}

// Tells that a value which was changed does nothing.
module unused(name, value, default, used, reason) {
    if (!used && value != default) echo(str("NOTE: ", name, " = ", value, " does nothing: ", reason));
}

// Tells which of some values, [name, whether it is undefined], were given to the wrong file.
module elsewhere(file, values) {
    for (v = values) if (!v[1]) echo(str("NOTE: ", v[0], " does nothing here: it is a parameter of ", file));
}

// A limit as it is told: rounded down to 0.001.
function shown(value) = floor(value * 1000 + 0.0001) / 1000;

// Refuses a word that is none of `choices`. Newer Customizers make numbers of words like "608".
module check_choice(name, value, choices) {
    assert(len([for (c = choices) if (c == str(value)) c]) > 0,
           str(name, " = \"", value, "\" must be one of ", choices));
}

// ---- Bores, keyways, screws, bearings ------------------------------------------------------

// [kind, diameter, flat, teeth] of the shafts that `preset` stands for; `custom` if it is none.
function bore_preset(preset, custom) =
    preset == "nema14" ? ["d_shape", 5, 0.5, 0] :
    preset == "nema17" ? ["d_shape", 5, 0.5, 0] :
    preset == "nema23" ? ["d_shape", 6.35, 0.6, 0] :
    preset == "servo_25t" ? ["spline", 5.9, 0, 25] :
    preset == "servo_23t" ? ["spline", 5.7, 0, 23] :
    custom;

// Outline of a hole: "round", "d_shape" with `flat` cut off, "hexagon" by its width across flats,
// "spline" with `teeth` serrations.
module bore_outline(kind, diameter, flat, teeth) {
    radius = diameter / 2;
    if (kind == "round") circle(r = radius, $fn = circle_sides(radius));
    if (kind == "d_shape") difference() {
        circle(r = radius, $fn = circle_sides(radius));
        translate([radius - flat, -radius]) square(diameter);
    }
    if (kind == "hexagon") circle(r = radius / cos(30), $fn = 6);
    if (kind == "spline") polygon([for (i = [0 : 2 * teeth - 1])
        (i % 2 == 0 ? radius : 0.93 * radius) * [cos(180 * i / teeth), sin(180 * i / teeth)]]);
}

// Width and depth in the hub of a keyway by shaft, DIN 6885-1 (ISO 773), for shafts of 6 to 44 mm.
function keyway_size(shaft) =
    shaft <= 8 ? [2, 1] : shaft <= 10 ? [3, 1.4] : shaft <= 12 ? [4, 1.8] : shaft <= 17 ? [5, 2.3] :
    shaft <= 22 ? [6, 2.8] : shaft <= 30 ? [8, 3.3] : shaft <= 38 ? [10, 3.3] : [12, 3.3];

// A bore is [kind, diameter, flat, teeth, diameter of the shaft in it].

// A hole along z from 0 to `length`, with a keyway towards +y if wanted.
module bore_hole(bore, length, keyway) {
    linear_extrude(height = length) {
        bore_outline(bore[0], bore[1], bore[2], bore[3]);
        if (keyway) let (size = keyway_size(bore[4]))
            translate([-size.x / 2, 0]) square([size.x, bore[1] / 2 + size.y]);
    }
}

// Largest distance from the axis that a bore reaches.
function bore_reach(bore, keyway) =
    let (radius = bore[0] == "hexagon" ? bore[1] / 2 / cos(30) : bore[1] / 2)
    bore[0] == "none" ? 0 :
    keyway ? norm([keyway_size(bore[4]).x / 2, bore[1] / 2 + keyway_size(bore[4]).y]) : radius;

// Largest diameter of the shaft with which a bore of this kind stays within room[0] from the axis, and
// within room[1] towards +x.
function bore_limit(bore, room, fit, keyway) =
    let (
        shrink = bore[0] == "hexagon" ? cos(30) : 1,
        flat = bore[0] == "d_shape" ? bore[2] : 0,
        keyed = [for (d = [6 : 0.05 : 44])
            if (norm([keyway_size(d).x / 2, d / 2 + fit + keyway_size(d).y]) <= min(room)) d]
    )
    keyway ? (len(keyed) > 0 ? max(keyed) : 0) : 2 * (shrink * min(room[0], room[1] + flat) - fit);

// Distance from the axis that a bore reaches towards +x, where the flat of a D is.
function bore_reach_x(bore, keyway) =
    bore[0] == "d_shape" ? bore[1] / 2 - bore[2] : bore_reach(bore, keyway);

// [clearance hole, width across flats of the nut, its height] by nominal size, ISO 4032.
function screw_size(name) =
    name == "M2" ? [2.2, 4, 1.6] : name == "M2.5" ? [2.7, 5, 2] : name == "M3" ? [3.2, 5.5, 2.4] :
    name == "M4" ? [4.3, 7, 3.2] : [5.3, 8, 4.7];

// Set screw along +x at height `z` through a wall between the radii `inner` and `outer`, and the
// pocket that its nut is pushed into from above, up to the height `top`.
module set_screw_hole(name, z, inner, outer, top) {
    size = screw_size(name);
    gap = 0.2;
    middle = (inner + outer) / 2;
    rod([0, 0, z], outer + 1, size[0] / 2, axis = [1, 0, 0]);
    block([middle - size[2] / 2 - gap, -size[1] / 2 - gap, z - size[1] / cos(30) / 2 - gap],
          [middle + size[2] / 2 + gap, size[1] / 2 + gap, top]);
}

// Bore, outer diameter and width of small ball bearings, mm.
function bearing_size(name) =
    let (n = str(name))
    n == "MR84" ? [4, 8, 3] : n == "MR105" ? [5, 10, 4] : n == "MR126" ? [6, 12, 4] :
    n == "688" ? [8, 16, 5] : n == "608" ? [8, 22, 7] : [0, 0, 0];

// ---- Printing ------------------------------------------------------------------------------

// Children in a row along y (along = 1) or x (along = 0), `gap` apart and centred across; `corners` are
// the rectangles [[x, y], [x, y]] that hold them.
module side_by_side(corners, along = 1, gap = 5) {
    across = 1 - along;
    for (i = [0 : $children - 1])
        let (
            before = [for (k = [0 : 1 : i - 1]) corners[k][1][along] - corners[k][0][along] + gap],
            to = sum(before) - corners[i][0][along],
            middle = -(corners[i][0][across] + corners[i][1][across]) / 2
        )
        translate(along == 0 ? [to, middle, 0] : [middle, to, 0]) children(i);
}

// The rectangle that holds what side_by_side() makes along y.
function row_corners(corners, gap = 5) =
    let (
        width = max([for (c = corners) c[1].x - c[0].x]),
        depth = sum([for (c = corners) c[1].y - c[0].y + gap]) - gap
    )
    len(corners) == 1 ? corners[0] : [[-width / 2, 0], [width / 2, depth]];

function sum(list) = len(list) == 0 ? 0 : list * [for (x = list) 1];

// Pulls the first layers of what lies on z = 0 in by `amount`, against an elephant's foot.
module pull_in_foot(amount) {
    if (amount > 0) {
        difference() {
            children();
            translate([0, 0, -1]) linear_extrude(height = 1 + amount) difference() {
                square(1000, center = true);
                // The outline of the layers, not a cut through them, which CGAL now and then fails at.
                offset(delta = -amount) projection() intersection() {
                    children();
                    translate([-500, -500, 0]) cube([1000, 1000, amount]);
                }
            }
        }
    } else {
        children();
    }
}
