//! A swept body of `elements`, clamped somewhere: displacements and stresses under forces.

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::block_cholesky::{BlockTridiagonal, Factor};
use super::elements::{self, Elasticity, NODES, PLACES, POINTS};

/// Elements on a grid: across, up and along the sweep.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Nodes, mm.
    pub nodes: Vec<Vector3<f64>>,
    /// Directions x, y, z in which a node cannot move.
    pub fixed: Vec<[bool; 3]>,
    /// Nodes of each element, in the order of [`PLACES`].
    pub elements: Vec<[usize; NODES]>,
    /// Place of each element on the grid: across, up, along.
    pub cells: Vec<[usize; 3]>,
    /// Place of each node on the grid, in halves of cells.
    pub halves: Vec<[usize; 3]>,
}

impl Grid {
    /// Elements at those of `counts` cells for which `exists`; nodes are where `place` puts half cells.
    pub fn new(
        counts: [usize; 3],
        exists: impl Fn([usize; 3]) -> bool,
        mut place: impl FnMut([usize; 3]) -> Vector3<f64>,
    ) -> Grid {
        let mut grid = Grid {
            nodes: Vec::new(),
            fixed: Vec::new(),
            elements: Vec::new(),
            cells: Vec::new(),
            halves: Vec::new(),
        };
        let wide = counts.map(|n| 2 * n + 1);
        let mut known = vec![usize::MAX; wide.iter().product()];
        for cell in cells(counts).filter(|&cell| exists(cell)) {
            let nodes = PLACES.map(|side| {
                let half: [usize; 3] =
                    std::array::from_fn(|i| (2 * cell[i] + 1).wrapping_add_signed(side[i].into()));
                let index = &mut known[half[0] + wide[0] * (half[1] + wide[1] * half[2])];
                if *index == usize::MAX {
                    *index = grid.nodes.len();
                    grid.nodes.push(place(half));
                    grid.fixed.push([false; 3]);
                    grid.halves.push(half);
                }
                *index
            });
            grid.elements.push(nodes);
            grid.cells.push(cell);
        }
        grid
    }

    /// The nodes of an element.
    pub fn corners(&self, element: usize) -> [Vector3<f64>; NODES] {
        self.elements[element].map(|node| self.nodes[node])
    }
}

/// All cells, the first coordinate fastest.
fn cells([a, b, c]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..c).flat_map(move |k| (0..b).flat_map(move |j| (0..a).map(move |i| [i, j, k])))
}

/// Forces at nodes, N.
pub type Forces = Vec<(usize, Vector3<f64>)>;

/// A grid whose stiffness is factored.
#[derive(Debug)]
pub struct ElasticBody<'a> {
    grid: &'a Grid,
    material: Elasticity,
    gradients: Vec<[([Vector3<f64>; NODES], f64); POINTS]>,
    /// Block and row of each node's three directions; `None` where it is fixed.
    rows: Vec<[Option<(usize, usize)>; 3]>,
    sizes: Vec<usize>,
    factor: Factor,
}

impl<'a> ElasticBody<'a> {
    /// `None` where an element is turned inside out or nothing holds the body.
    pub fn new(grid: &'a Grid, material: Elasticity) -> Option<ElasticBody<'a>> {
        // A stretch of the sweep: from one end of elements up to before the next.
        let stretches = grid.halves.iter().map(|half| half[2] / 2).max()? + 1;
        let (mut sizes, mut heads) = (vec![0; stretches], vec![0; stretches]);
        let mut rows = vec![[None; 3]; grid.nodes.len()];
        for beginning in [true, false] {
            for node in (0..grid.nodes.len())
                .filter(|&node| grid.halves[node][2].is_multiple_of(2) == beginning)
            {
                let stretch = grid.halves[node][2] / 2;
                for axis in (0..3).filter(|&axis| !grid.fixed[node][axis]) {
                    rows[node][axis] = Some((stretch, sizes[stretch]));
                    sizes[stretch] += 1;
                }
            }
            if beginning {
                heads.copy_from_slice(&sizes);
            }
        }
        let mut matrix = BlockTridiagonal::zeros(&sizes, &heads);
        let mut gradients = Vec::with_capacity(grid.elements.len());
        for (element, nodes) in grid.elements.iter().enumerate() {
            let of = elements::gradients(&grid.corners(element))?;
            elements::stiffness(&of, material, |a, b, pair| {
                let (one, two) = (&rows[nodes[a]], &rows[nodes[b]]);
                for (i, row) in one.iter().enumerate() {
                    for (j, column) in two.iter().enumerate() {
                        let (Some(row), Some(column)) = (*row, *column) else {
                            continue;
                        };
                        matrix.add(row, column, pair[(i, j)]);
                        if a != b {
                            matrix.add(column, row, pair[(i, j)]);
                        }
                    }
                }
            });
            gradients.push(of);
        }
        Some(ElasticBody {
            grid,
            material,
            gradients,
            rows,
            sizes,
            factor: matrix.factor()?,
        })
    }

    /// Displacement of every node, mm, under each of `cases`.
    pub fn solve(&self, cases: &[Forces]) -> Option<Vec<Vec<Vector3<f64>>>> {
        let sizes = self.sizes.iter();
        let mut sides: Vec<_> = sizes.map(|&n| DMatrix::zeros(n, cases.len())).collect();
        for (column, forces) in cases.iter().enumerate() {
            for (node, force) in forces {
                for (axis, row) in self.rows[*node].iter().enumerate() {
                    if let Some((block, row)) = row {
                        sides[*block][(*row, column)] += force[axis];
                    }
                }
            }
        }
        self.factor.solve(&mut sides)?;
        let at = |column: usize, row: &Option<(usize, usize)>| {
            row.map_or(0.0, |(block, row)| sides[block][(row, column)])
        };
        let case = |column: usize| {
            let moved = self
                .rows
                .iter()
                .map(|rows| Vector3::from_fn(|axis, _| at(column, &rows[axis])));
            moved.collect()
        };
        Some((0..cases.len()).map(case).collect())
    }

    /// Stress at the integration points of `element`, MPa, when the nodes move by `moved`, mm.
    pub fn stresses(&self, element: usize, moved: &[Vector3<f64>]) -> [Matrix3<f64>; POINTS] {
        let moved = self.grid.elements[element].map(|node| moved[node]);
        self.gradients[element]
            .each_ref()
            .map(|(slopes, _)| elements::stress(slopes, &moved, self.material))
    }
}
