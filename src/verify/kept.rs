//! What the motion of one body against another leaves alone. Two bodies that only turn about an axis
//! keep every point's distance from it and its height: where their images in these coordinates are
//! apart, the bodies are apart at every φ, however close and concentric their surfaces are.

use nalgebra::Vector3;

use super::mechanism::Mechanism;
use super::tree::Tree;
use super::triangle::Triangle;
use crate::motion::{Class, Pose};
use crate::solid::assembly::Carrier;

/// Coordinates that change by less than this over the turn are kept, mm.
const KEPT: f64 = 1e-9;

/// Phases at which that is tried.
const PHASES: usize = 720;

/// Coordinates of points, no farther apart than the points themselves, which a relative motion keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kept {
    /// Distance from the parallel to z through a point, and height: a revolute joint.
    AxisAndHeight(Vector3<f64>),
    /// Distance from the parallel to z through a point: a cylindrical joint.
    Axis(Vector3<f64>),
    /// Distance from the origin: a ball joint.
    Centre,
    /// x and y: a guide along z.
    Across,
}

/// From where to where the coordinates of a piece of surface reach, mm; where there is one, the second is 0.
pub(super) type Image = [[f64; 2]; 2];

/// The images of a mesh, for every node and triangle of its tree.
#[derive(Debug)]
pub(super) struct Images {
    pub nodes: Vec<Image>,
    pub triangles: Vec<Image>,
}

impl Kept {
    /// What the motion of two bodies against each other keeps, as far as it is known and true over the
    /// whole turn.
    pub fn by(pair: (Carrier, Carrier), mechanism: &Mechanism) -> Option<Kept> {
        use Carrier::{Driver, Follower, Slider, Support};
        let shaft = mechanism.drive.axis_point();
        let kept = match pair {
            (Driver, Support) | (Support, Driver) => Kept::AxisAndHeight(shaft),
            (Driver, Slider) | (Slider, Driver) => Kept::Axis(shaft),
            (Follower, Slider) | (Slider, Follower) => Kept::Centre,
            (Slider, Support) | (Support, Slider) => Kept::Across,
            (Follower, Support) | (Support, Follower) => match mechanism.motion.class() {
                Class::R1 => Kept::AxisAndHeight(Vector3::zeros()),
                Class::R1T1 => Kept::Axis(Vector3::zeros()),
                Class::R3 => Kept::Centre,
                Class::R3T1 => return None,
            },
            _ => return None,
        };
        let seen = |phi| {
            mechanism
                .pose(pair.0, phi)
                .inverse_mul(&mechanism.pose(pair.1, phi))
        };
        let mut phases = mechanism.motion.cycle().phases(PHASES);
        phases.all(|phi| kept.survives(&seen(phi))).then_some(kept)
    }

    /// Whether `pose` keeps the coordinates of all points: of four, in no plane.
    fn survives(&self, pose: &Pose) -> bool {
        let away = 30.0;
        let corners = [
            Vector3::zeros(),
            Vector3::x() * away,
            Vector3::y() * away,
            Vector3::z() * away,
        ];
        let odd = Vector3::new(1.0, 2.0, 3.0);
        corners.into_iter().map(|c| c + odd).all(|x| {
            let (before, after) = (self.of(x), self.of(pose.apply(x)));
            (0..2).all(|i| (before[i] - after[i]).abs() < KEPT)
        })
    }

    /// The coordinates of a point.
    fn of(&self, x: Vector3<f64>) -> [f64; 2] {
        match self {
            Kept::AxisAndHeight(axis) => [(x - axis).xy().norm(), x.z],
            Kept::Axis(axis) => [(x - axis).xy().norm(), 0.0],
            Kept::Centre => [x.norm(), 0.0],
            Kept::Across => [x.x, x.y],
        }
    }

    fn image(&self, triangle: &Triangle) -> Image {
        let corners = triangle.corners.map(|c| self.of(c));
        let mut image = [0, 1].map(|i| {
            let [a, b, c] = corners.map(|c| c[i]);
            [a.min(b).min(c), a.max(b).max(c)]
        });
        // A distance is least anywhere in the triangle, and largest in a corner.
        match self {
            Kept::AxisAndHeight(axis) | Kept::Axis(axis) => {
                let flat = Triangle {
                    corners: triangle.corners.map(|c| Vector3::new(c.x, c.y, 0.0)),
                    normal: Vector3::z(),
                };
                let axis = Vector3::new(axis.x, axis.y, 0.0);
                image[0][0] = (flat.nearest(axis) - axis).norm();
            }
            Kept::Centre => image[0][0] = triangle.nearest(Vector3::zeros()).norm(),
            Kept::Across => {}
        }
        image
    }

    /// The images of the mesh of `tree`.
    pub fn images(&self, tree: &Tree) -> Images {
        let triangles: Vec<Image> = tree.triangles.iter().map(|t| self.image(t)).collect();
        let nodes = tree.under(|k| triangles[k], both);
        Images {
            nodes: nodes.into_iter().map(Option::unwrap_or_default).collect(),
            triangles,
        }
    }
}

/// An image that holds both.
fn both(a: Image, b: Image) -> Image {
    [0, 1].map(|i| [a[i][0].min(b[i][0]), a[i][1].max(b[i][1])])
}

/// How far two images are apart, mm; so far are the surfaces at least, at every φ.
pub(super) fn apart(a: &Image, b: &Image) -> f64 {
    let [first, second] = [0, 1].map(|i| (b[i][0] - a[i][1]).max(a[i][0] - b[i][1]).max(0.0));
    (first * first + second * second).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Drive, Motion, MotionSource};
    use crate::solid::kernel;

    fn on(class: Class, test: impl Fn(&Mechanism)) {
        let motion = Motion::new(class, &MotionSource::Uniform {}).expect("a motion");
        test(&Mechanism {
            motion: &motion,
            drive: Drive::new(25.0, 1),
        });
    }

    #[test]
    fn joints_keep_what_they_should() {
        let shaft = Vector3::new(-25.0, 0.0, 0.0);
        on(Class::R3, |mechanism| {
            let kept = |a, b| Kept::by((a, b), mechanism);
            let expected = Some(Kept::AxisAndHeight(shaft));
            assert_eq!(kept(Carrier::Support, Carrier::Driver), expected);
            assert_eq!(
                kept(Carrier::Follower, Carrier::Support),
                Some(Kept::Centre)
            );
            assert_eq!(kept(Carrier::Driver, Carrier::Follower), None);
        });
        // What is not kept is seen: a turn about the shaft moves points away from the origin.
        let turned = |phi: f64| Drive::new(25.0, 1).state(phi).pose;
        assert!(Kept::AxisAndHeight(shaft).survives(&turned(1.0)));
        for kept in [Kept::Centre, Kept::Across, Kept::Axis(Vector3::zeros())] {
            assert!(!kept.survives(&turned(1.0)), "{kept:?}");
        }
    }

    #[test]
    fn images_are_where_the_surface_is() {
        // A facet comes nearer to the axis than its corners.
        let (sin, cos) = 0.2f64.sin_cos();
        let [x, y] = [5.0 * cos, 5.0 * sin];
        let facet = [(-y, 1.0), (y, 1.0), (y, 3.0)].map(|(y, z)| Vector3::new(x, y, z));
        let facet = Triangle::new(facet);
        let image = Kept::AxisAndHeight(Vector3::zeros()).image(&facet);
        for (found, expected) in image.concat().iter().zip([x, 5.0, 1.0, 3.0]) {
            assert!((found - expected).abs() < 1e-12, "{image:?}");
        }
        let [near, far] = Kept::Centre.image(&facet)[0];
        assert!((near - (x * x + 1.0).sqrt()).abs() < 1e-12, "{near}");
        assert!((far - 34.0f64.sqrt()).abs() < 1e-12, "{far}");
        let pin = [[0.0, 4.0], [5.0, 9.0]];
        assert!((apart(&image, &pin) - (x - 4.0).hypot(2.0)).abs() < 1e-12);
    }

    #[test]
    fn nodes_hold_their_triangles() {
        let mesh = kernel::lathe(&[(2.0, 0.0), (3.0, 1.0), (3.0, 4.0), (1.0, 6.0)], 24);
        let tree = Tree::new(&mesh);
        let images = Kept::AxisAndHeight(Vector3::new(1.0, 0.0, 0.0)).images(&tree);
        let holds = |outer: &Image, inner: &Image| both(*outer, *inner) == *outer;
        assert!(images.triangles.iter().all(|t| holds(&images.nodes[0], t)));
        for (i, node) in tree.nodes.iter().enumerate().filter(|(_, n)| !n.is_leaf()) {
            for child in [i + 1, node.first as usize] {
                assert!(holds(&images.nodes[i], &images.nodes[child]));
            }
        }
    }
}
