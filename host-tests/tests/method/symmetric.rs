//! Symmetric 3x3 matrices and least squares by blocks, against nalgebra's dense matrices.

use crate::common::rng;
use glenoid::identification::blocks::{BlockEquations, Blocks};
use glenoid::identification::normal_equations::Singular;
use glenoid::scalar::Real;
use glenoid::symmetric::{Symmetric, rounding};
use nalgebra::{Matrix3, Matrix6, Rotation3, SMatrix, Vector3, Vector6};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

fn entries<const R: usize, const C: usize>(rng: &mut ChaCha8Rng) -> SMatrix<f64, R, C> {
    SMatrix::from_fn(|_, _| rng.random_range(-1.0..1.0))
}

fn symmetric(dense: &Matrix3<f64>) -> Symmetric<f64> {
    Symmetric([dense.m11, dense.m21, dense.m22, dense.m31, dense.m32, dense.m33])
}

/// Positive definite, with eigenvalues of random sizes.
fn positive(rng: &mut ChaCha8Rng) -> Matrix3<f64> {
    let rows = entries::<5, 3>(rng);
    rows.transpose() * rows
}

fn dense(blocks: &Blocks<f64>) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| blocks.entry(i.max(j), i.min(j)))
}

fn blocks(dense: &Matrix6<f64>) -> Blocks<f64> {
    let block = |i, j| dense.fixed_view::<3, 3>(i, j).into_owned();
    Blocks { first: symmetric(&block(0, 0)), mixed: block(3, 0), second: symmetric(&block(3, 3)) }
}

fn assert_close<const R: usize, const C: usize>(mine: &SMatrix<f64, R, C>, other: &SMatrix<f64, R, C>) {
    assert!((mine - other).amax() < 1e-9 * other.amax().max(1.0), "{mine} instead of {other}");
}

fn inverse<T: Real>(mut matrix: Symmetric<T>, of: &Symmetric<T>, smallest: T) -> Option<Symmetric<T>> {
    let before = matrix;
    if matrix.invert(of, smallest) {
        return Some(matrix);
    }
    // NaN too is left as it was.
    assert_eq!(format!("{matrix:?}"), format!("{before:?}"));
    None
}

#[test]
fn products_and_inverses_are_those_of_full_matrices() {
    let mut rng = rng(5501);
    for _ in 0..300 {
        let matrix = positive(&mut rng);
        let packed = symmetric(&matrix);
        let (other, vector) = (entries::<3, 3>(&mut rng), entries::<3, 1>(&mut rng));
        assert_close(&packed.to_matrix(), &matrix);
        assert_close(&packed.image(&vector), &(matrix * vector));
        let mut product = other;
        packed.apply_to(&mut product);
        assert_close(&product, &(matrix * other));
        let mut sum = packed;
        sum.add_product(&other, &(matrix * other), 0.5);
        assert_close(&sum.to_matrix(), &(matrix + other.transpose() * matrix * other * 0.5));
        assert_close(&packed.adjugate().to_matrix(), &(matrix.try_inverse().unwrap() * matrix.determinant()));
        assert_close(&inverse(packed, &packed, 1e-14).unwrap().to_matrix(), &matrix.try_inverse().unwrap());
        assert!((packed.trace() - matrix.trace()).abs() < 1e-14);
        let mut sum = packed;
        sum.add(&symmetric(&(matrix * 2.0)), -0.25);
        sum.add_square(&vector);
        assert_close(&sum.to_matrix(), &(matrix * 0.5 + vector * vector.transpose()));
    }
}

#[test]
fn a_pivot_is_judged_against_what_it_came_from() {
    let diagonal = |x, y, z| Symmetric([x, 0.0, y, 0.0, 0.0, z]);
    let matrix = diagonal(1.0, 2.0, 3e-3);
    assert!(inverse(matrix, &matrix, 1e-2).is_some());
    assert!(inverse(matrix, &diagonal(1.0, 2.0, 3.0), 1e-2).is_none());
    assert!(inverse(matrix, &diagonal(1.0, 2.0, 3.0), 1e-4).is_some());
    assert!(inverse(diagonal(1.0, 2.0, 0.0), &matrix, 0.0).is_none());
    assert!(inverse(diagonal(1.0, -2.0, 3.0), &matrix, 0.0).is_none());
    assert!(inverse(diagonal(f64::NAN, 2.0, 3.0), &matrix, 0.0).is_none());
}

#[test]
fn a_flat_matrix_has_no_inverse_beyond_rounding() {
    let mut rng = rng(5506);
    for _ in 0..500 {
        let rows = entries::<2, 3>(&mut rng);
        let flat = symmetric(&(rows.transpose() * rows));
        // Its first two pivots are sound, the third is all rounding.
        let [xx, yx, yy, ..] = flat.0;
        if yx * yx > 0.9 * xx * yy {
            continue;
        }
        assert!(inverse(flat, &flat, rounding()).is_none(), "the inverse of {flat:?}");
        let single = Symmetric(flat.0.map(|entry| entry as f32));
        let inverse = inverse(single, &single, rounding());
        assert!(inverse.is_none_or(|inverse| inverse.to_matrix().amax() > 1e4), "the inverse of {single:?}");
    }
}

#[test]
fn the_largest_eigenvalue_and_its_direction() {
    let mut rng = rng(5502);
    for _ in 0..1000 {
        // Apart by a factor of 1.001 to 1000, in any order and direction.
        let turn = Rotation3::new(entries::<3, 1>(&mut rng) * 3.0);
        let second = 10f64.powf(rng.random_range(-3.0..-0.000_5));
        let third = second * rng.random_range(0.0..1.0);
        let scale = 10f64.powf(rng.random_range(-8.0..8.0));
        let matrix = turn * Matrix3::from_diagonal(&Vector3::new(second, 1.0, third)) * turn.transpose() * scale;
        let (value, direction) = symmetric(&matrix).largest();
        assert!((value / scale - 1.0).abs() < 1e-9, "{value} instead of {scale}");
        assert!(direction.dot(&(turn * Vector3::y())).abs() > 1.0 - 1e-9, "{second} {third}");
        let (single, towards) = Symmetric(symmetric(&matrix).0.map(|entry| entry as f32)).largest();
        assert!((f64::from(single) / scale - 1.0).abs() < 1e-3, "{single} instead of {scale}");
        // The nearer the next, the less it matters which of them is given.
        let towards = towards.map(f64::from);
        let along = towards.dot(&(matrix * towards)) / scale;
        assert!((along - 1.0).abs() < 1e-5, "{along} where the next is {second}");
    }
}

#[test]
fn where_two_are_largest_the_direction_is_between_them() {
    let mut rng = rng(5503);
    for _ in 0..300 {
        let turn = Rotation3::new(entries::<3, 1>(&mut rng) * 3.0);
        let third = rng.random_range(0.0..0.5);
        let matrix = turn * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, third)) * turn.transpose();
        let (value, direction) = symmetric(&matrix).largest();
        assert!((value - 1.0).abs() < 1e-6 && (direction.norm() - 1.0).abs() < 1e-12);
        // Seen through M itself at least: the smallest has no more than its share.
        assert!(direction.dot(&(turn * Vector3::z())).abs() <= 0.75, "{third}: {direction}");
    }
    // None at all.
    let (value, direction) = Symmetric::<f32>::zero().largest();
    assert_eq!((value, direction.norm()), (0.0, 0.0));
    assert!(!Symmetric([f32::NAN; 6]).largest().0.is_finite());
    assert!(!Symmetric([f32::INFINITY; 6]).largest().0.is_finite());
}

#[test]
fn elimination_inverse_and_step_are_those_of_the_whole_matrix() {
    let mut rng = rng(5504);
    for _ in 0..300 {
        let rows = entries::<9, 6>(&mut rng);
        let values = entries::<9, 1>(&mut rng);
        let whole = rows.transpose() * rows;
        let inverse = whole.try_inverse().unwrap();
        let matrix = blocks(&whole);
        assert_close(&dense(&matrix), &whole);

        let mut eliminated = matrix;
        eliminated.eliminate(1e-14).unwrap();
        let block = |i, j| whole.fixed_view::<3, 3>(i, j).into_owned();
        let second = block(3, 3).try_inverse().unwrap();
        assert_close(&eliminated.second.to_matrix(), &second);
        assert_close(&eliminated.mixed, &(second * block(3, 0)));
        assert_close(&eliminated.first.to_matrix(), &(block(0, 0) - block(0, 3) * second * block(3, 0)));

        let mut inverted = matrix;
        inverted.invert().unwrap();
        assert_close(&dense(&inverted), &inverse);
        let first = matrix.first_inverse().unwrap().to_matrix();
        assert_close(&first, &inverse.fixed_view::<3, 3>(0, 0).into_owned());

        let right = rows.transpose() * values;
        let gradient = [right.fixed_rows::<3>(0).into_owned(), right.fixed_rows::<3>(3).into_owned()];
        let equations = BlockEquations { matrix, gradient, squares: values.norm_squared() };
        let step = Vector6::from(equations.solve().unwrap());
        assert_close(&step, &(inverse * right));
        let left = (values - rows * step).norm_squared();
        assert!((equations.squares - equations.gained(&step.into()) - left).abs() < 1e-9);
    }
}

#[test]
fn what_is_not_determined_is_singular() {
    let mut rng = rng(5505);
    let rows = entries::<9, 6>(&mut rng);
    for unknown in 0..6 {
        // Two unknowns that are only seen together, across the blocks and within them.
        let mut rows = rows;
        let other = rows.column((unknown + 2) % 6) * 2.0;
        rows.set_column(unknown, &other);
        let matrix = blocks(&(rows.transpose() * rows));
        assert_eq!(matrix.first_inverse(), Err(Singular), "unknown {unknown}");
        let equations = BlockEquations { matrix, ..BlockEquations::new() };
        assert_eq!(equations.solve(), Err(Singular), "unknown {unknown}");
    }
    assert_eq!(Blocks::<f64>::zero().first_inverse(), Err(Singular));
}
