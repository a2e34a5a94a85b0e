//! `D` by central differences of the literal `p_ij`: the derivative that owes nothing to the Appendix.

use super::{estimate, parameters};
use host_tests::literal::{Estimate, Lengths, Machine, PoseModel, pose_model};

/// The smallest distance of an end-point from its plane O-B_a-B_b, mm.
///
/// The edges have an infinite derivative where this is zero, so no difference quotient is of use near it.
pub fn flattest_mm(machine: &Machine<f64>, at: &Estimate<f64>, model: &PoseModel<f64>) -> f64 {
    let height = |end_point: usize| {
        let a = machine.base_mm[end_point] - at.centre_mm;
        let b = machine.base_mm[(end_point + 1) % 3] - at.centre_mm;
        model.end_points_mm[end_point].dot(&a.cross(&b).normalize()).abs()
    };
    (0..3).map(height).fold(f64::INFINITY, f64::min)
}

/// The 3x6 derivative of `p12`, `p23`, `p31` by the six parameters, by six-point central differences.
///
/// An apex at height `h` over its plane moves like `sqrt(h² + 2 p δ)`, so the edges vary on a scale of `h² / 2p`. The
/// step is 0.003 of that, measured to be the best (1.6e-10 of the largest entry over 10 000 random poses with `h` above
/// 1 mm): rounding wins below, truncation above.
///
/// `None` when a tetrahedron does not close here or a few steps away.
pub fn central_differences(
    machine: &Machine<f64>,
    at: &Estimate<f64>,
    lengths: &Lengths<f64>,
) -> Option<[[f64; 6]; 3]> {
    let here = pose_model(machine, at, lengths, 0).ok()?;
    let flattest = flattest_mm(machine, at, &here);
    let step = (0.003 * flattest * flattest / 280.0).min(0.2);
    let mut derivative = [[0.0; 6]; 3];
    for parameter in 0..6 {
        for (weight, offset) in [(45.0, 1.0), (-9.0, 2.0), (1.0, 3.0)] {
            let edges_at = |offset: f64| {
                let mut moved = parameters(at);
                moved[parameter] += offset * step;
                pose_model(machine, &estimate(moved), lengths, 0).ok().map(|model| model.edges_mm)
            };
            let (ahead, behind) = (edges_at(offset)?, edges_at(-offset)?);
            for edge in 0..3 {
                derivative[edge][parameter] += weight * (ahead[edge] - behind[edge]) / (60.0 * step);
            }
        }
    }
    Some(derivative)
}

/// The largest difference of two 3x6 matrices, each row relative to the largest entry of that row in the second.
pub fn relative_difference(one: &[[f64; 6]; 3], other: &[[f64; 6]; 3]) -> f64 {
    let rows = one.iter().zip(other).map(|(one, other)| {
        let largest = other.iter().fold(0.0, |max: f64, entry| max.max(entry.abs()));
        one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
    });
    rows.fold(0.0, f64::max)
}
