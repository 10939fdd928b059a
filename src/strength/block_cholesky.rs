//! Cholesky factor of a symmetric positive definite matrix that is block tridiagonal, as stiffness along a swept
//! body is: every block meets the next one only. Blocks are dense, so that nearly all work is products of matrices.

use nalgebra::{DMatrix, DMatrixViewMut};

/// The matrix, later its factor: blocks on the diagonal, of which only the lower half counts, and below it.
#[derive(Debug, Clone)]
pub struct BlockTridiagonal {
    diagonal: Vec<DMatrix<f64>>,
    /// Rows of the next block that meet this one; they come first in their block.
    below: Vec<DMatrix<f64>>,
}

/// Columns of the largest block that is factored without being divided.
const SMALL: usize = 24;

impl BlockTridiagonal {
    /// Zero, with blocks of `sizes`; of each the first `heads` rows meet the block before.
    pub fn zeros(sizes: &[usize], heads: &[usize]) -> BlockTridiagonal {
        let after = sizes.iter().zip(heads.iter().skip(1));
        BlockTridiagonal {
            diagonal: sizes.iter().map(|&n| DMatrix::zeros(n, n)).collect(),
            below: after.map(|(&n, &head)| DMatrix::zeros(head, n)).collect(),
        }
    }

    /// Adds `value` at a row and a column, each as block and place in it; entries above the diagonal are left out.
    pub fn add(&mut self, row: (usize, usize), column: (usize, usize), value: f64) {
        if row < column {
            return;
        }
        match row.0 == column.0 {
            true => self.diagonal[row.0][(row.1, column.1)] += value,
            false => self.below[column.0][(row.1, column.1)] += value,
        }
    }

    /// Its factor; `None` unless it is positive definite.
    pub fn factor(mut self) -> Option<Factor> {
        for i in 0..self.diagonal.len() {
            let (done, rest) = self.diagonal.split_at_mut(i + 1);
            let block = &mut done[i];
            factor(block.as_view_mut())?;
            let Some(next) = rest.first_mut() else { break };
            let below = &mut self.below[i];
            divide(block, below.as_view_mut());
            let head = below.nrows();
            next.view_mut((0, 0), (head, head))
                .gemm(-1.0, below, &below.transpose(), 1.0);
        }
        Some(Factor(self))
    }
}

/// A view of which rows and columns are known at run time only.
type View<'a> = DMatrixViewMut<'a, f64, nalgebra::U1, nalgebra::Dyn>;

/// Replaces the lower half of a matrix by its Cholesky factor.
fn factor(mut a: View) -> Option<()> {
    let n = a.nrows();
    if n <= SMALL {
        for j in 0..n {
            let pivot = a[(j, j)];
            if !(pivot > 0.0) {
                return None;
            }
            let scale = 1.0 / pivot.sqrt();
            for i in j..n {
                a[(i, j)] *= scale;
            }
            for k in j + 1..n {
                let factor = a[(k, j)];
                for i in k..n {
                    let product = factor * a[(i, j)];
                    a[(i, k)] -= product;
                }
            }
        }
        return Some(());
    }
    let half = n / 2;
    factor(a.view_mut((0, 0), (half, half)))?;
    let above = a.view((0, 0), (half, half)).into_owned();
    divide(&above, a.view_mut((half, 0), (n - half, half)));
    let left = a.view((half, 0), (n - half, half)).into_owned();
    let mut rest = a.view_mut((half, half), (n - half, n - half));
    rest.gemm(-1.0, &left, &left.transpose(), 1.0);
    factor(rest)
}

/// Replaces `b` by B·L⁻ᵀ, where L is the lower half of `l`.
fn divide(l: &DMatrix<f64>, mut b: View) {
    let (rows, n) = b.shape();
    for start in (0..n).step_by(SMALL) {
        let count = SMALL.min(n - start);
        let (done, mut here) = b.columns_range_pair_mut(0..start, start..start + count);
        if start > 0 {
            let of = l.view((start, 0), (count, start)).transpose();
            here.gemm(-1.0, &done, &of, 1.0);
        }
        for j in 0..count {
            for k in 0..j {
                let factor = l[(start + j, start + k)];
                for i in 0..rows {
                    let product = factor * here[(i, k)];
                    here[(i, j)] -= product;
                }
            }
            let scale = 1.0 / l[(start + j, start + j)];
            here.column_mut(j).scale_mut(scale);
        }
    }
}

/// A factored [`BlockTridiagonal`].
#[derive(Debug, Clone)]
pub struct Factor(BlockTridiagonal);

impl Factor {
    /// Replaces right-hand sides, one per column and cut into the blocks' rows, by their solutions.
    ///
    /// `None` if a block is singular.
    pub fn solve(&self, sides: &mut [DMatrix<f64>]) -> Option<()> {
        let BlockTridiagonal { diagonal, below } = &self.0;
        for i in 0..diagonal.len() {
            if !diagonal[i].solve_lower_triangular_mut(&mut sides[i]) {
                return None;
            }
            if let Some(below) = below.get(i) {
                let (done, rest) = sides.split_at_mut(i + 1);
                rest[0]
                    .rows_mut(0, below.nrows())
                    .gemm(-1.0, below, &done[i], 1.0);
            }
        }
        for i in (0..diagonal.len()).rev() {
            if let Some(below) = below.get(i) {
                let (here, after) = sides.split_at_mut(i + 1);
                let head = after[0].rows(0, below.nrows());
                here[i].gemm_tr(-1.0, below, &head, 1.0);
            }
            if !diagonal[i].tr_solve_lower_triangular_mut(&mut sides[i]) {
                return None;
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of three blocks, and the whole matrix.
    fn chain(sizes: [usize; 3], heads: [usize; 3]) -> (BlockTridiagonal, DMatrix<f64>) {
        let mut blocks = BlockTridiagonal::zeros(&sizes, &heads);
        let count = sizes.iter().sum();
        let mut whole = DMatrix::zeros(count, count);
        let place = |mut i: usize| {
            let mut block = 0;
            while i >= sizes[block] {
                (i, block) = (i - sizes[block], block + 1);
            }
            (block, i)
        };
        for i in 0..count {
            for j in 0..=i {
                let (row, column) = (place(i), place(j));
                let near = row.0 == column.0 || (row.0 == column.0 + 1 && row.1 < heads[row.0]);
                if near {
                    let value = (1.7 * i as f64 + 0.3 * (j * j) as f64).sin();
                    let value = if i == j { count as f64 } else { value };
                    blocks.add(row, column, value);
                    whole[(i, j)] = value;
                    whole[(j, i)] = value;
                }
            }
        }
        (blocks, whole)
    }

    #[test]
    fn solves_as_the_whole_matrix_does() {
        let sizes = [70, 5, 61];
        let (blocks, whole) = chain(sizes, [0, 5, 33]);
        let side = DMatrix::from_fn(whole.nrows(), 3, |i, j| ((i * (j + 2)) as f64).cos());
        let mut rows = 0;
        let mut cut: Vec<DMatrix<f64>> = sizes
            .iter()
            .map(|&n| {
                rows += n;
                side.rows(rows - n, n).into_owned()
            })
            .collect();
        blocks
            .factor()
            .expect("definite")
            .solve(&mut cut)
            .expect("solved");
        let mut found = DMatrix::zeros(0, 3);
        for block in cut {
            let start = found.nrows();
            found = found.insert_rows(start, block.nrows(), 0.0);
            found.rows_mut(start, block.nrows()).copy_from(&block);
        }
        assert!((whole * found - side).amax() < 1e-12);
    }

    #[test]
    fn what_is_not_definite_is_refused() {
        let (mut blocks, _) = chain([30, 4, 30], [0, 4, 4]);
        blocks.add((2, 29), (2, 29), -200.0);
        assert!(blocks.factor().is_none());
    }
}
