//! Normal equations, eigenvalues and inverses against nalgebra's dense algebra.

use crate::common::rng;
use glenoid::linear_algebra::{
    Eigen, NormalEquations, Singular, inverse_of_eliminated, inverse_of_positive_definite, largest_eigenpair,
    packed_index, rounding, solve_positive_definite, symmetric_eigen, triad, unit,
};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Rotation3, SMatrix, Vector3, Vector6};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Equations in up to nine unknowns.
type Nine = NormalEquations<f64, 9, 45>;

fn entries<const R: usize, const C: usize>(rng: &mut ChaCha8Rng) -> SMatrix<f64, R, C> {
    SMatrix::from_fn(|_, _| rng.random_range(-1.0..1.0))
}

/// Positive definite, with eigenvalues of random sizes.
fn positive(rng: &mut ChaCha8Rng) -> Matrix3<f64> {
    let rows = entries::<5, 3>(rng);
    rows.transpose() * rows
}

fn assert_close<const R: usize, const C: usize>(mine: &SMatrix<f64, R, C>, other: &SMatrix<f64, R, C>) {
    assert!((mine - other).amax() < 1e-9 * other.amax().max(1.0), "{mine} instead of {other}");
}

/// A random least-squares problem: rows, values, and the same streamed.
struct Problem {
    rows: DMatrix<f64>,
    values: DVector<f64>,
    equations: Nine,
}

impl Problem {
    fn new(rng: &mut ChaCha8Rng, unknowns: usize) -> Self {
        let rows = DMatrix::from_fn(unknowns + 4, unknowns, |_, _| rng.random_range(-1.0..1.0));
        let values = DVector::from_fn(unknowns + 4, |_, _| rng.random_range(-1.0..1.0));
        let mut equations = Nine::new(unknowns);
        for (row, value) in rows.row_iter().zip(&values) {
            equations.add_row(row.transpose().as_slice(), *value);
        }
        Self { rows, values, equations }
    }

    fn normal_matrix(&self) -> DMatrix<f64> {
        self.rows.transpose() * &self.rows
    }
}

#[test]
fn a_row_added_to_the_factor_is_as_one_added_before() {
    let mut rng = rng(5510);
    for trial in 0..200 {
        let unknowns = 1 + trial % 9;
        let mut problem = Problem::new(&mut rng, unknowns);
        let mut row = [0.0; 9];
        row.iter_mut().take(unknowns).for_each(|entry| *entry = rng.random_range(-2.0..2.0));
        let added = DVector::from_column_slice(&row[..unknowns]);
        let expected = (problem.normal_matrix() + &added * added.transpose()).try_inverse().unwrap();
        problem.equations.factor().expect("a regular problem");
        problem.equations.add_row_to_factor(&row);
        for column in 0..unknowns {
            let found = problem.equations.covariance_column(column, 0);
            let found = DVector::from_column_slice(&found[..unknowns]);
            let difference = (found - expected.column(column)).amax();
            assert!(difference < 1e-8 * expected.amax(), "{unknowns}: {difference}");
        }
    }
}

#[test]
fn the_step_is_the_least_squares_solution() {
    let mut rng = rng(5504);
    for trial in 0..500 {
        let unknowns = 1 + trial % 9;
        let Problem { rows, values, mut equations } = Problem::new(&mut rng, unknowns);
        assert!((equations.squares() - values.norm_squared()).abs() < 1e-12);
        let expected = rows.clone().svd(true, true).solve(&values, 1e-14).expect("a solution");
        equations.factor().expect("a regular problem");
        let step = equations.step();
        for (mine, other) in step.iter().zip(&expected) {
            assert!((mine - other).abs() < 1e-8 * expected.amax().max(1.0), "{step:?} instead of {expected}");
        }
        assert!(step[unknowns..].iter().all(|x| *x == 0.0));
        let left = (values - rows * expected).norm_squared();
        assert!((equations.squares_after(&step) - left).abs() < 1e-9);
    }
}

#[test]
fn covariance_solution_and_whitening_are_those_of_the_dense_inverse() {
    let mut rng = rng(5507);
    for trial in 0..300 {
        let unknowns = 1 + trial % 9;
        let problem = Problem::new(&mut rng, unknowns);
        let inverse = problem.normal_matrix().lu().try_inverse().expect("a regular problem");
        let mut equations = problem.equations;
        equations.factor().expect("a regular problem");
        let close = 1e-8 * inverse.amax().max(1.0);
        for j in 0..unknowns {
            let column = equations.covariance_column(j, 0);
            assert!((0..unknowns).all(|i| (column[i] - inverse[(i, j)]).abs() < close), "{column:?}: {inverse}");
        }
        // L⁻¹ a and L⁻¹ b have the product aᵀ (JᵀJ)⁻¹ b.
        let vectors: [[f64; 9]; 2] = std::array::from_fn(|_| {
            std::array::from_fn(|k| if k < unknowns { rng.random_range(-1.0..1.0) } else { 0.0 })
        });
        let whitened = vectors.map(|mut vector| {
            equations.whiten(&mut vector);
            vector
        });
        let [a, b] = vectors.map(|vector| DVector::from_row_slice(&vector[..unknowns]));
        let product: f64 = whitened[0].iter().zip(&whitened[1]).map(|(a, b)| a * b).sum();
        assert!((product - a.dot(&(&inverse * &b))).abs() < 1e-8 * inverse.amax().max(1.0));
        let mut solved = vectors[0];
        equations.solve_for(&mut solved);
        let expected = &inverse * a;
        assert!((0..unknowns).all(|k| (solved[k] - expected[k]).abs() < close));
    }
}

#[test]
fn the_end_of_the_factor_has_the_unknowns_before_it_eliminated() {
    let mut rng = rng(5508);
    for _ in 0..200 {
        let problem = Problem::new(&mut rng, 9);
        let normal = problem.normal_matrix();
        let mut equations = problem.equations;
        let last: SMatrix<f64, 4, 4> = equations.trailing_matrix();
        assert!((0..4).all(|i| (0..4).all(|j| (last[(i, j)] - normal[(5 + i, 5 + j)]).abs() < 1e-12)));
        equations.factor().expect("a regular problem");
        // The covariance of the last four is the same whether the others are solved for or eliminated,
        let inverse = normal.clone().lu().try_inverse().expect("a regular problem");
        for j in 5..9 {
            let column = equations.covariance_column(j, 5);
            assert!((5..9).all(|i| (column[i] - inverse[(i, j)]).abs() < 1e-8 * inverse.amax().max(1.0)));
            assert!(column[..5].iter().all(|x| *x == 0.0));
        }
        // and its inverse is the Schur complement.
        let schur = normal.view((5, 5), (4, 4))
            - normal.view((5, 0), (4, 5))
                * normal.view((0, 0), (5, 5)).into_owned().lu().try_inverse().expect("regular")
                * normal.view((0, 5), (5, 4));
        let mut right = [0.0; 9];
        right[7] = 1.0;
        equations.solve_trailing(&mut right, 5);
        let product = schur * DVector::from_row_slice(&right[5..]);
        assert!((product - DVector::from_row_slice(&[0.0, 0.0, 1.0, 0.0])).amax() < 1e-8, "{right:?}");
    }
}

#[test]
fn entries_a_few_at_a_time_give_the_same_factor() {
    let mut rng = rng(5509);
    for products in 1..200 {
        let mut whole = Problem::new(&mut rng, 9).equations;
        let mut sliced = whole;
        assert!(sliced.is_unfactored() && !sliced.is_factored());
        let mut calls = 0;
        while !sliced.is_factored() {
            sliced.factor_some(products).expect("a regular problem");
            calls += 1;
        }
        // Nine rows, the last of eight entries and a diagonal, each entry worth at most 18 products.
        assert!(calls <= 45 && calls >= 45_usize.div_ceil(products), "{calls} calls of {products} products");
        whole.factor().expect("a regular problem");
        assert_eq!(whole, sliced);
    }
}

#[test]
fn entries_added_one_by_one_are_those_of_the_rows() {
    let mut rng = rng(5510);
    let problem = Problem::new(&mut rng, 7);
    let (normal, gradient) = (problem.normal_matrix(), problem.rows.transpose() * &problem.values);
    let mut equations = Nine::new(3);
    equations.add_to_entry(2, 1, 5.0);
    equations.clear(7);
    for i in 0..7 {
        for j in 0..=i {
            equations.add_to_entry(i, j, normal[(i, j)]);
        }
        equations.add_to_gradient(i, gradient[i]);
    }
    equations.add_squares(problem.values.norm_squared());
    for (mine, other) in equations.matrix().iter().zip(problem.equations.matrix()) {
        assert!((mine - other).abs() < 1e-12);
    }
    assert!(equations.gradient().iter().zip(problem.equations.gradient()).all(|(a, b)| (a - b).abs() < 1e-12));
    // As many equations three times over: a third of the covariance.
    let mut thrice = Nine::new(7);
    thrice.add_matrix(equations.matrix(), 3.0);
    equations.factor().expect("a regular problem");
    thrice.factor().expect("a regular problem");
    let (once, again) = (equations.covariance_column(0, 0)[0], thrice.covariance_column(0, 0)[0]);
    assert!((once / again - 3.0).abs() < 1e-9);
    assert_eq!((thrice.squares(), thrice.gradient()), (0.0, &[0.0; 9]));
}

#[test]
fn the_pivot_ratio_tells_how_much_worse_the_weakest_combination_is_seen() {
    // Two unknowns seen together, and by ε apart: their difference has ε² of what their sum has.
    for small in [0.1, 0.01, 0.003] {
        let mut equations = Nine::new(2);
        equations.add_row(&[1.0, 1.0], 0.0);
        equations.add_row(&[small, -small], 0.0);
        equations.factor().expect("above the smallest pivot");
        // The diagonal 1 + ε² against the pivot 1 + ε² - (1 - ε²)² / (1 + ε²) = 4 ε² / (1 + ε²).
        let expected: f64 = (1.0 + small * small) * (1.0 + small * small) / (4.0 * small * small);
        assert!((equations.pivot_ratio() / expected - 1.0).abs() < 1e-9, "{} for {small}", equations.pivot_ratio());
    }
    let mut alone = Nine::new(1);
    alone.add_row(&[7.0], 0.0);
    alone.factor().expect("regular");
    assert_eq!(alone.pivot_ratio(), 1.0);
}

#[test]
fn what_is_not_determined_is_singular() {
    let mut rng = rng(5505);
    let rows = entries::<9, 6>(&mut rng);
    for unknown in 0..6 {
        // Two unknowns that are only seen together.
        let mut rows = rows;
        let other = rows.column((unknown + 2) % 6) * 2.0;
        rows.set_column(unknown, &other);
        let mut equations = Nine::new(6);
        rows.row_iter().for_each(|row| equations.add_row(row.transpose().as_slice(), 1.0));
        assert_eq!(equations.factor(), Err(Singular), "unknown {unknown}");
    }
    assert_eq!(Nine::new(6).factor(), Err(Singular));
    let mut nothing = Nine::new(1);
    nothing.add_row(&[f64::NAN], 1.0);
    assert_eq!(nothing.factor(), Err(Singular));
    // Nothing unknown, nothing to determine.
    assert_eq!(Nine::new(0).factor(), Ok(()));
}

#[test]
fn inverses_are_those_of_full_matrices() {
    let mut rng = rng(5501);
    for _ in 0..300 {
        let matrix = positive(&mut rng);
        let inverse = inverse_of_positive_definite(&matrix, 1e-14).expect("positive definite");
        assert_close(&inverse, &matrix.try_inverse().expect("regular"));
    }
}

/// The lower triangle alone is read, so what stands above it does not matter.
#[test]
fn solutions_fulfil_their_equations() {
    let mut rng = rng(5507);
    for _ in 0..300 {
        let matrix = positive(&mut rng);
        let right: Vector3<f64> = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let x = solve_positive_definite(&matrix.lower_triangle(), &right, 1e-14).expect("positive definite");
        let exact = matrix.lu().solve(&right).expect("regular");
        assert!((x - exact).amax() <= 1e-9 * exact.amax(), "{x} for {exact}");
    }
    assert!(
        solve_positive_definite(&Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 0.0)), &Vector3::x(), 0.0).is_none()
    );
}

#[test]
fn a_pivot_is_judged_against_what_it_came_from() {
    let diagonal = |x, y, z| Matrix3::from_diagonal(&Vector3::new(x, y, z));
    let matrix = diagonal(1.0, 2.0, 3e-3);
    assert!(inverse_of_positive_definite(&matrix, 1e-2).is_some());
    assert!(inverse_of_eliminated(&matrix, &diagonal(1.0, 2.0, 3.0), 1e-2).is_none());
    assert!(inverse_of_eliminated(&matrix, &diagonal(1.0, 2.0, 3.0), 1e-4).is_some());
    assert!(inverse_of_eliminated(&diagonal(1.0, 2.0, 0.0), &matrix, 0.0).is_none());
    assert!(inverse_of_eliminated(&diagonal(1.0, -2.0, 3.0), &matrix, 0.0).is_none());
    assert!(inverse_of_eliminated(&diagonal(f64::NAN, 2.0, 3.0), &matrix, 0.0).is_none());
}

#[test]
fn a_flat_matrix_has_no_inverse_beyond_rounding() {
    let mut rng = rng(5506);
    for _ in 0..500 {
        let rows = entries::<2, 3>(&mut rng);
        let flat = rows.transpose() * rows;
        // Its first two pivots are sound, the third is all rounding.
        if flat.m21 * flat.m21 > 0.9 * flat.m11 * flat.m22 {
            continue;
        }
        assert!(inverse_of_positive_definite(&flat, rounding()).is_none(), "the inverse of {flat}");
        let single = flat.map(|entry| entry as f32);
        let inverse = inverse_of_positive_definite(&single, rounding());
        assert!(inverse.is_none_or(|inverse| inverse.amax() > 1e4), "the inverse of {single}");
    }
}

/// Asserts that these are the eigenvalues and eigenvectors of a matrix.
fn assert_eigen<const N: usize>(matrix: &SMatrix<f64, N, N>, found: &Eigen<f64, N>) {
    let scale = matrix.amax();
    let mut mine: Vec<f64> = found.values.iter().copied().collect();
    let dense = DMatrix::from_fn(N, N, |i, j| matrix[(i, j)]);
    let mut expected: Vec<f64> = dense.symmetric_eigenvalues().iter().copied().collect();
    mine.sort_by(f64::total_cmp);
    expected.sort_by(f64::total_cmp);
    for (mine, expected) in mine.iter().zip(&expected) {
        assert!((mine - expected).abs() < 1e-12 * scale, "{mine} instead of {expected}");
    }
    let rebuilt = found.vectors * SMatrix::from_diagonal(&found.values) * found.vectors.transpose();
    assert!((rebuilt - matrix).amax() < 1e-12 * scale);
    assert!((found.vectors.tr_mul(&found.vectors) - SMatrix::identity()).amax() < 1e-13);
}

#[test]
fn eigenvalues_and_eigenvectors_are_those_of_the_dense_algebra() {
    let mut rng = rng(5511);
    for _ in 0..300 {
        let scale = 10f64.powf(rng.random_range(-8.0..8.0));
        let three = entries::<3, 3>(&mut rng);
        let three = (three + three.transpose()) * scale;
        assert_eigen(&three, &symmetric_eigen(&three));
        // Down to rank three of six.
        let rows = entries::<3, 6>(&mut rng);
        let six: Matrix6<f64> =
            rows.transpose() * rows * scale + Matrix6::identity() * (scale * rng.random_range(0.0..1e-3));
        assert_eigen(&six, &symmetric_eigen(&six));
    }
    assert_eq!(symmetric_eigen(&Matrix6::<f64>::zeros()).values, Vector6::zeros());
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
        let (value, direction) = largest_eigenpair(&matrix);
        assert!((value / scale - 1.0).abs() < 1e-9, "{value} instead of {scale}");
        assert!(direction.dot(&(turn * Vector3::y())).abs() > 1.0 - 1e-9, "{second} {third}");
        let (single, towards) = largest_eigenpair(&matrix.map(|entry| entry as f32));
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
        let (value, direction) = largest_eigenpair(&matrix);
        assert!((value - 1.0).abs() < 1e-6 && (direction.norm() - 1.0).abs() < 1e-12);
        assert!(direction.dot(&(turn * Vector3::z())).abs() <= 1e-6, "{third}: {direction}");
    }
    // None at all.
    assert_eq!(largest_eigenpair(&Matrix3::<f32>::zeros()).0, 0.0);
    assert!(!largest_eigenpair(&Matrix3::from_element(f32::NAN)).0.is_finite());
    assert!(!largest_eigenpair(&Matrix3::from_element(f32::INFINITY)).0.is_finite());
}

#[test]
fn axes_from_two_vectors_are_orthonormal() {
    let mut rng = rng(5512);
    for _ in 0..200 {
        let (first, second) = (entries::<3, 1>(&mut rng), entries::<3, 1>(&mut rng));
        let axes = triad(&first, &second);
        assert!((axes.tr_mul(&axes) - Matrix3::identity()).amax() < 1e-12 && axes.determinant() > 0.0);
        assert!((axes.column(0) - first.normalize()).amax() < 1e-14);
        assert!(axes.column(2).dot(&second).abs() < 1e-14 && axes.column(1).dot(&second) > 0.0);
        assert!((unit(&first) - first.normalize()).amax() < 1e-14);
    }
    let along = Vector3::new(1.0, 2.0, 3.0);
    assert!(!triad(&along, &(along * 2.0)).iter().all(|x| f64::is_finite(*x)));
    assert_eq!((packed_index(0, 0), packed_index(3, 1), packed_index(8, 8)), (0, 7, 44));
}
