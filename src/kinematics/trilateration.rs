//! Trilateration: a point from its distances to three others (where three spheres meet).
//!
//! With the first centre as origin, x towards the second and the third in the plane of x and y, the differences of the
//! spheres' equations are linear, one in x and one in x and y.

use crate::linear_algebra::{non_negative_root, triad};
use crate::scalar::Real;
use nalgebra::Vector3;

/// The point at these distances from the three centres, relative to the first, on one `side` of their plane: 1 where
/// they are numbered counterclockwise, -1 on the other. When the spheres do not meet, the point of the plane on their
/// radical axis. Not finite when the centres lie on one line.
pub(super) fn trilaterate<T: Real>([a, b, c]: [&Vector3<T>; 3], [ra, rb, rc]: &[T; 3], side: T) -> Vector3<T> {
    let (second, third) = (b - a, c - a);
    let axes = triad(&second, &third);
    let (second, third) = (axes.tr_mul(&second).x, axes.tr_mul(&third));
    // Differences of squares as products: single precision would lose the digits that matter.
    let x = ((*ra - *rb) * (*ra + *rb) + second * second) / (second + second);
    let y = ((*ra - *rc) * (*ra + *rc) + third.x * (third.x - x - x) + third.y * third.y) / (third.y + third.y);
    let height = non_negative_root((*ra - x) * (*ra + x) - y * y) * side;
    axes * Vector3::new(x, y, height)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CENTRES: [[f64; 3]; 3] = [[10.0, -4.0, 2.0], [150.0, 30.0, -7.0], [-60.0, 120.0, 15.0]];

    /// Where the spheres through `point` meet, from the first centre.
    fn met<T: Real>(point: &Vector3<f64>, side: f64) -> Vector3<f64> {
        let [a, b, c] = CENTRES.map(Vector3::from);
        let radii = [a, b, c].map(|centre| T::of((point - centre).norm()));
        let [a, b, c] = [a, b, c].map(|centre| centre.map(T::of));
        trilaterate([&a, &b, &c], &radii, T::of(side)).map(Real::to_f64)
    }

    #[test]
    fn a_point_is_found_from_its_distances_on_either_side() {
        let [a, b, c] = CENTRES.map(Vector3::from);
        let normal = (b - a).cross(&(c - a)).normalize();
        for point in [[40.0, 60.0, 130.0], [-90.0, 20.0, 70.0], [200.0, 210.0, 55.0]].map(Vector3::from) {
            let from_first = point - a;
            let mirrored = from_first - normal * (2.0 * from_first.dot(&normal));
            let (above, below) =
                if from_first.dot(&normal) > 0.0 { (from_first, mirrored) } else { (mirrored, from_first) };
            assert!((met::<f64>(&point, 1.0) - above).norm() < 1e-11);
            assert!((met::<f64>(&point, -1.0) - below).norm() < 1e-11);
            assert!((met::<f32>(&point, 1.0) - above).norm() < 1e-3);
        }
    }

    #[test]
    fn spheres_that_do_not_meet_leave_a_point_of_the_plane() {
        let [a, b, c] = CENTRES.map(Vector3::from);
        // Too small for each other; equal, so that the point is as far from all three.
        let found = trilaterate([&a, &b, &c], &[20.0; 3], 1.0) + a;
        let distances = [a, b, c].map(|centre| (found - centre).norm());
        assert!((distances[0] - distances[1]).abs() < 1e-10 && (distances[0] - distances[2]).abs() < 1e-10);
        assert!((b - a).cross(&(c - a)).normalize().dot(&(found - a)).abs() < 1e-11);
    }

    #[test]
    fn centres_on_one_line_give_no_point() {
        let [a, b] = [Vector3::new(0.0, 0.0, 0.0), Vector3::new(1.0, 2.0, 3.0)];
        let found: Vector3<f64> = trilaterate([&a, &b, &(b * 2.0)], &[4.0, 3.0, 4.0], 1.0);
        assert!(!found.iter().all(|x| x.is_finite()));
    }
}
