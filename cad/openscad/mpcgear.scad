// mpcgear.scad: swept teeth, ribs and plain solids for multi-point conjugation gears.
//
// Every file that mpcgear writes carries a copy of this one, so that it opens anywhere. To write a
// part of your own, put this file beside it and say: use <mpcgear.scad>
// For OpenSCAD 2021.01 and later. SPDX-License-Identifier: MIT OR Apache-2.0

// ---- Tooth section -------------------------------------------------------------------------

// Outline of a tooth's cross section, counter-clockwise, in coordinates (n, b): the contact point
// is the origin, n points into the material, b away from the hub. The flank starts half the
// clearance behind the contact. A bead with round flanks stands on a neck as thick as the rib.
// The outline is symmetric: corner i mirrors corner -1-i, and the cap faces rely on it.
function tooth_section(thickness, flank_radius, tip, root, clearance, neck, segments) =
    let (
        radius = min(flank_radius, thickness / 2),
        centre = clearance / 2 + radius,
        middle = clearance / 2 + thickness / 2,
        side = middle - min(neck, thickness) / 2,
        neck_angle = acos(min(max(centre - side, 0) / radius, 1)),
        has_neck = root > radius * sin(neck_angle) + 0.001,
        low = has_neck ? neck_angle : asin(min(root / radius, 1)),
        high = asin(min(tip / radius, 1)),
        below = max(round(segments * low / 360), 1),
        above = max(round(segments * high / 360), 1),
        angles = concat([for (i = [below : -1 : 1]) -low * i / below],
                        [for (i = [0 : above]) high * i / above]),
        half = concat(has_neck ? [[side, -root]] : [],
                      [for (a = angles) [centre - radius * cos(a), radius * sin(a)]]),
        last = len(half) - 1,
        pointed = half[last].x > middle - 0.0001
    )
    concat([for (c = half) [2 * middle - c.x, c.y]],
           [for (i = [pointed ? last - 1 : last : -1 : 0]) half[i]]);

// ---- Sweeps --------------------------------------------------------------------------------

// A station is [point, n, b]: where the section stands and how it is turned. Stations follow each
// other in the direction n x b.

// `count` stations of a list, evenly chosen, both ends included.
function thin(stations, count) =
    let (last = len(stations) - 1, steps = min(count - 1, last))
    [for (i = [0 : steps]) stations[round(i * last / steps)]];

// The section's corners at every station.
function tooth_rings(stations, section) =
    [for (s = stations) [for (c = section) s[0] + c.x * s[1] + c.y * s[2]]];

// Length of a vector's part in the xy plane.
function level_norm(v) = norm([v.x, v.y]);

// The four corners of a rib at every station: a wall from the bead's middle, `depth` behind the
// contact point, straight towards the gear's axis through `axis`, ending `foot` from the axis.
function rib_rings(all_stations, rib, depth, axis, foot) =
    let (
        // Two stations at both ends are left free: thin corners would stand where rib and tooth end.
        last = len(all_stations) - 1,
        stations = last >= 8 ? [for (i = [2 : last - 2]) all_stations[i]] : all_stations,
        outer = [for (s = stations) s[0] + depth * s[1]],
        reach = [for (o = outer) level_norm(o - axis)],
        inner_radius = min(foot, 0.8 * min(reach))
    )
    [for (i = [0 : len(stations) - 1])
        let (
            radial = [outer[i].x - axis.x, outer[i].y - axis.y, 0] / reach[i],
            inner = outer[i] - (reach[i] - inner_radius) * radial,
            across = cross(cross(stations[i][1], stations[i][2]), radial),
            side = across * (rib / 2 / norm(across))
        )
        [outer[i] - side, outer[i] + side, inner + side, inner - side]];

// Triangles of a cap over `n` corners that start at index `first`, as a zigzag of strips.
function cap_faces(n, first) =
    [for (k = [0 : floor((n - 3) / 2)])
        each concat([[first + k, first + k + 1, first + n - 1 - k]],
                    k + 1 < n - 2 - k ? [[first + k + 1, first + n - 2 - k, first + n - 1 - k]] : [])];

// Triangles of a closed shell over `rings` rings of `n` corners each, clockwise from outside.
function shell_faces(rings, n, first) =
    concat(
        [for (r = [0 : rings - 2]) for (i = [0 : n - 1])
            let (a = first + r * n + i, b = first + r * n + (i + 1) % n)
            each [[a, b + n, b], [a, a + n, b + n]]],
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

// ---- Plain solids --------------------------------------------------------------------------

// Corners of the polygon that stands for a circle.
function circle_sides(radius) = radius < 2.5 ? 24 : radius < 6 ? 48 : 72;

// Turns z towards `axis`.
module towards(axis) {
    rotate([0, acos(axis.z / norm(axis)), atan2(axis.y, axis.x)]) children();
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
