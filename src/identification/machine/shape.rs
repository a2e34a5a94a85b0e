//! Shape modes: displacements of a body's points orthogonal to all rigid motions.

use crate::linear_algebra::non_negative_root;
use crate::rig::{CABLES, POINTS};
use crate::scalar::Real;
use nalgebra::Vector3;

/// Maximum number of modes: six points have eighteen coordinates, six of which are rigid motions.
pub const MAX_MODES: usize = 3 * CABLES - RIGID;
/// Rigid motions of a body.
const RIGID: usize = 6;

/// Smallest squared norm that is left of a unit vector in a new direction; rounding leaves far less of an old one.
const NEW_DIRECTION: f64 = 1e-3;

/// Displacements of the ends of the six cables, mm per mm of a mode's coefficient.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeModes<T> {
    count: usize,
    modes: [[Vector3<T>; CABLES]; MAX_MODES],
}

impl<T: Real> ShapeModes<T> {
    /// No modes: a body that is exactly known.
    pub fn none() -> Self {
        Self { count: 0, modes: [[Vector3::zeros(); CABLES]; MAX_MODES] }
    }

    /// Three points, each the end of two cables: `of_cable` names the point (from 0) of each. Three orthonormal modes:
    /// when every coordinate of a point has the same standard deviation, so has every mode.
    pub fn set_triangle(&mut self, &[a, b, c]: &[Vector3<T>; POINTS], of_cable: &[usize]) {
        let none = Vector3::zeros();
        self.find(&[a, b, c, none, none, none], POINTS, of_cable);
    }

    /// Six points of their own: twelve orthonormal modes.
    pub fn set_six(&mut self, points_mm: &[Vector3<T>; CABLES]) {
        self.find(points_mm, CABLES, &[0, 1, 2, 3, 4, 5]);
    }

    /// The three edges p12, p23, p31 of a triangle P1 = (0, 0, 0), P2 = (p12, 0, 0), P3 = (x, y, 0) as modes: each end
    /// moves as its point does when one edge grows. From x = (p12² + p31² - p23²) / 2 p12 and y² = p31² - x².
    pub fn set_edges(&mut self, platform_mm: &[Vector3<T>; POINTS]) {
        let [_, second, third] = platform_mm;
        let (p12, x, y) = (second.x, third.x, third.y);
        let (p31, p23) = (third.norm_squared().root(), (third - second).norm_squared().root());
        let dx = [(p12 - x) / p12, -p23 / p12, p31 / p12];
        let dy = [-x * dx[0] / y, -x * dx[1] / y, (p31 - x * dx[2]) / y];
        let zero = T::zero();
        self.count = 3;
        for (edge, mode) in self.modes.iter_mut().take(3).enumerate() {
            let grows = if edge == 0 { T::one() } else { zero };
            let points = [Vector3::zeros(), Vector3::new(grows, zero, zero), Vector3::new(dx[edge], dy[edge], zero)];
            *mode = core::array::from_fn(|cable| points[cable / 2]);
        }
    }

    /// Number of modes.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The displacement of every cable's end in one mode.
    pub fn mode(&self, index: usize) -> &[Vector3<T>; CABLES] {
        &self.modes[if index < MAX_MODES { index } else { 0 }]
    }

    /// Moves the ends by `coefficients` of the modes.
    pub fn displace(&self, ends_mm: &mut [Vector3<T>; CABLES], coefficients: &[T]) {
        for (mode, coefficient) in self.modes.iter().take(self.count).zip(coefficients) {
            ends_mm.iter_mut().zip(mode).for_each(|(end, moved)| *end += moved * *coefficient);
        }
    }

    /// The modes of the first `count` points. `of_cable`: the point at which each cable ends.
    fn find(&mut self, points_mm: &Points<T>, count: usize, of_cable: &[usize]) {
        self.count = 0;
        for_each_mode(points_mm.get(..count).unwrap_or_default(), |mode| {
            if let Some(kept) = self.modes.get_mut(self.count) {
                for (end, point) in kept.iter_mut().zip(of_cable) {
                    *end = mode.get(*point).copied().unwrap_or_else(Vector3::zeros);
                }
                self.count += 1;
            }
        });
    }
}

/// Displacements of up to six points.
type Points<T> = [Vector3<T>; CABLES];

/// Orthonormal displacements.
type Basis<T> = heapless::Vec<Points<T>, { 3 * CABLES }>;

/// The modes of up to six points, by Gram-Schmidt: rigid motions first, then every coordinate of every
/// point; what is linearly independent is a mode.
pub fn for_each_mode<T: Real>(points_mm: &[Vector3<T>], mut found: impl FnMut(&Points<T>)) {
    let mut basis = Basis::new();
    let middle = points_mm.iter().fold(Vector3::zeros(), |sum, p| sum + p) / T::of_integer(points_mm.len() as i32);
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    // Along the axes, about them, then each point along each.
    for index in 0..RIGID + 3 * points_mm.len() {
        let axis = &axes[index % 3];
        let mut vector = [Vector3::zeros(); CABLES];
        for (at, (moved, point)) in vector.iter_mut().zip(points_mm).enumerate() {
            match index / 3 {
                0 => *moved = *axis,
                1 => *moved = axis.cross(&(point - middle)),
                free if free == at + 2 => *moved = *axis,
                _ => {}
            }
        }
        let mode = extend(&mut basis, &vector);
        if let Some(mode) = mode.filter(|_| index >= RIGID) {
            found(mode);
        }
    }
}

/// Adds the part of `vector` that is orthogonal to the basis; gives it, if there is one.
fn extend<'a, T: Real>(basis: &'a mut Basis<T>, vector: &Points<T>) -> Option<&'a Points<T>> {
    let added = orthonormal(basis, *vector)?;
    basis.push(added).ok()?;
    basis.last()
}

/// The part of `vector` orthogonal to the basis, normalised; `None` when hardly anything is left.
fn orthonormal<T: Real>(basis: &[Points<T>], vector: Points<T>) -> Option<Points<T>> {
    let dot = |a: &Points<T>, b: &Points<T>| a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + a.dot(b));
    let whole = dot(&vector, &vector);
    let mut left = vector;
    // Twice: single precision leaves too much the first time (Kahan: twice is enough).
    for _ in 0..2 {
        for known in basis {
            let share = dot(known, &left);
            left.iter_mut().zip(known).for_each(|(left, known)| *left -= known * share);
        }
    }
    let rest = dot(&left, &left);
    (rest > whole * T::of(NEW_DIRECTION)).then(|| {
        let scale = T::one() / non_negative_root(rest);
        left.map(|part| part * scale)
    })
}
