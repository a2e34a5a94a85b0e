//! One end-point from three distances (Eq. 1-9), by the tetrahedron proposition of Song and Kwon (the paper's reference 11).

use nalgebra::{RealField, Vector3, convert};

/// `OP_i`: the apex of the tetrahedron on O and two base points, in mm, relative to O.
///
/// `from_centre` holds the two base points relative to O, `radius` is the apex's distance from O (Eq. 1, 4, 7) and
/// `cables` its distances from the two base points (Eq. 2-3, 5-6, 8-9), all in mm.
///
/// # Method
/// In the tetrahedron's own coordinates, with the first axis from O to the first base point and the second in the
/// plane of the three base vertices, those are O = (0, 0, 0), B_a = (a, 0, 0) and B_b = (f, g, 0). Subtracting the three
/// sphere equations pairwise leaves
///
/// ```text
/// 2 a x         = p² - L_a² + a²
/// 2 f x + 2 g y = p² - L_b² + f² + g²
/// z²            = p² - x² - y²
/// ```
///
/// # Which of the two solutions
/// `z²` leaves the side of the plane O-B_a-B_b open. At home the end-point stands over the perpendicular bisector of
/// its two base points, farther up than O. Take the home numbers, base radius R, centre height h > 0, base points at
/// azimuth 0 and 120 degrees: `(B_a - O) × (B_b - O)` is `(R h √3/2, 3 R h / 2, R² √3/2)`, a vector that points along
/// azimuth 60 degrees and upward, and so does `OP`: the product is positive. The apex is thus on the side of
/// `(B_a - O) × (B_b - O)` when the base points are numbered counter-clockwise seen from the arm (from +z), and on the
/// other side when they are numbered clockwise; `counter_clockwise` says which. Under this rule the solution moves
/// continuously when the centre crosses the base plane. While the centre is above the base, it is the same as "the
/// side that the third base point is not on".
///
/// The rule describes the home pose and its neighbourhood. An end-point that swings far enough passes through the
/// plane, and the other solution becomes the true one: 3 % of end-points at 60 degrees of tilt and up to 60 of
/// torsion over a 120 mm base, 14 to 18 % at 75 degrees of tilt, none up to 50 degrees. The paper does not say what to do
/// then; here, as there, the rule stays.
///
/// Returns `None` when the lengths do not close (`z² < 0`), when O lies on the line of the two base points, and when a
/// number is not finite.
pub fn apex<T: RealField + Copy>(
    from_centre: [Vector3<T>; 2],
    radius: T,
    cables: [T; 2],
    counter_clockwise: bool,
) -> Option<Vector3<T>> {
    let two: T = convert(2.0);
    let [to_a, to_b] = from_centre;

    let a = to_a.norm();
    let axis_x = to_a / a;
    let f = axis_x.dot(&to_b);
    let beside = to_b - axis_x * f;
    let g = beside.norm();
    let axis_y = beside / g;
    let axis_z = axis_x.cross(&axis_y);

    let x = (radius * radius - cables[0] * cables[0] + a * a) / (two * a);
    let y = (radius * radius - cables[1] * cables[1] + f * f + g * g - two * f * x) / (two * g);
    let z_squared = radius * radius - x * x - y * y;
    if z_squared < T::zero() || !z_squared.is_finite() {
        return None;
    }
    let z = if counter_clockwise { z_squared.sqrt() } else { -z_squared.sqrt() };
    Some(axis_x * x + axis_y * y + axis_z * z)
}

/// Whether the three base points go round counter-clockwise when seen from +z of {B}, the side of the arm.
pub(super) fn counter_clockwise<T: RealField + Copy>(base_mm: &[Vector3<T>; 3]) -> bool {
    let [first, second, third] = base_mm;
    (second - first).cross(&(third - first)).z > T::zero()
}
