//! How the arm gets from one pose to the next.

use super::rotation;
use nalgebra::{Rotation3, Vector3};

/// Shares of the way at each sample, one every `period_ms`, ending with exactly 1 at `duration_ms`.
pub(crate) fn samples(duration_ms: u32, period_ms: u32) -> impl Iterator<Item = f64> {
    let period_ms = period_ms.max(1);
    let steps = duration_ms.div_ceil(period_ms).max(1);
    (1..=steps).map(move |step| match step == steps {
        true => 1.0,
        false => minimum_jerk(f64::from(step * period_ms) / f64::from(duration_ms)),
    })
}

/// Share of the way at a share of the time: the quintic with zero speed and acceleration at both ends (Flash and
/// Hogan, "The coordination of arm movements", 1985).
fn minimum_jerk(t: f64) -> f64 {
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// The rotation at `share` of the way from `from` to `to`, about their one common axis.
pub(super) fn between(from: &Rotation3<f64>, to: &Rotation3<f64>, share: f64) -> Rotation3<f64> {
    let change = to * from.inverse();
    let m = change.matrix();
    // Twice the axis times the sine of the angle; the trace gives its cosine.
    let twice = Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]);
    let sine = libm::sqrt(twice.norm_squared()) / 2.0;
    // Poses within a shoulder's range are far from half a turn apart, where the axis would be lost.
    if sine < 1e-12 {
        return *from;
    }
    let angle = libm::atan2(sine, (m.trace() - 1.0) / 2.0);
    rotation(twice, angle * share) * from
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arm_starts_and_ends_at_rest() {
        let way: Vec<f64> = samples(1000, 10).collect();
        assert_eq!(way.len(), 100);
        assert_eq!(way[99], 1.0);
        assert!((way[49] - 0.5).abs() < 1e-12, "half the way at half the time");
        assert!(way.windows(2).all(|w| w[0] < w[1]));
        assert!(way[0] < 2e-5 && 1.0 - way[98] < 2e-5);
    }

    #[test]
    fn half_of_a_turn_about_one_axis_is_half_its_angle() {
        let from = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.3);
        let to = Rotation3::from_axis_angle(&Vector3::x_axis(), -0.5);
        assert!(between(&from, &to, 0.5).angle_to(&Rotation3::from_axis_angle(&Vector3::x_axis(), -0.1)) < 1e-7);
        assert!(between(&from, &to, 1.0).angle_to(&to) < 1e-7);
        assert!(between(&from, &from, 0.5).angle_to(&from) < 1e-7);
    }
}
