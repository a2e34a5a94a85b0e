//! Is the identified centre right? Held against the truth, which only the virtual wearer knows.

use glenoid::can::result::Parameter;
use glenoid::rig::Parameters;

/// An error may be this many times its expected standard deviation: once in 1.7 million for one normal number.
const SIGMAS: f64 = 5.0;
/// Beyond that an error of this size is granted, mm: single precision, and poses that are averaged while the arm is
/// still coming to rest.
const GRANTED_MM: f64 = 0.05;
/// However noisy the cables, an expectation worse than this is no identification, mm.
const WORST_EXPECTED_SIGMA_MM: f64 = 2.0;

/// The identified parameters beside the true ones. All arrays in the order x, y, z, p1, p2, p3, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// Identified minus true.
    pub error_mm: [f64; 6],
    /// Distance of the identified from the true centre, mm.
    pub centre_error_mm: f64,
    /// What the noise, the rounding to counts and the machine's tolerances make one expect.
    pub expected_sigma_mm: [f64; 6],
    /// Largest error that still counts as right.
    pub tolerance_mm: [f64; 6],
    /// Largest error of x, y, z that the board's own standard deviations allow.
    pub by_the_board_mm: [f64; 3],
}

/// Names of the six parameters in their order.
pub const NAMES: [&str; 6] = ["x", "y", "z", "p1", "p2", "p3"];

impl Verdict {
    /// Compares `identified` with the `truth`.
    pub fn new(identified: &[Parameter; 6], truth: &Parameters<f64>, expected_sigma_mm: [f64; 6]) -> Self {
        let truth = truth.to_array();
        let error_mm: [f64; 6] = std::array::from_fn(|k| f64::from(identified[k].value_mm) - truth[k]);
        let centre_error_mm = error_mm[..3].iter().map(|e| e * e).sum::<f64>().sqrt();
        let tolerance_mm = expected_sigma_mm.map(|sigma| SIGMAS * sigma + GRANTED_MM);
        let by_the_board_mm = std::array::from_fn(|k| SIGMAS * f64::from(identified[k].sigma_mm) + GRANTED_MM);
        Self { error_mm, centre_error_mm, expected_sigma_mm, tolerance_mm, by_the_board_mm }
    }

    /// What is wrong, in words; empty when everything is right. NaN is never right.
    pub fn objections(&self) -> Vec<String> {
        let mut objections = Vec::new();
        for (k, name) in NAMES.iter().enumerate() {
            let (error, tolerance) = (self.error_mm[k], self.tolerance_mm[k]);
            if !(error.abs() <= tolerance) {
                objections
                    .push(format!("{name} is off by {error:+.4} mm, more than the tolerance of {tolerance:.4} mm"));
            }
        }
        for (k, (name, most)) in NAMES.iter().zip(self.by_the_board_mm).enumerate() {
            let error = self.error_mm[k];
            if !(error.abs() <= most) {
                objections.push(format!(
                    "{name} is off by {error:+.4} mm, more than the {most:.4} mm that the board's own σ allows"
                ));
            }
        }
        let worst = self.expected_sigma_mm.into_iter().fold(0.0, f64::max);
        if !(worst <= WORST_EXPECTED_SIGMA_MM) {
            objections.push(format!("these poses and this noise fix the centre only to {worst:.2} mm (one sigma)"));
        }
        objections
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn verdict(x: f32, sigma: f64) -> Verdict {
        with_bar(x, sigma, 1.0)
    }

    /// The bound's σ and the board's.
    fn with_bar(x: f32, sigma: f64, sigma_mm: f32) -> Verdict {
        let truth = Parameters { centre_mm: Vector3::new(1.0, 2.0, 148.0), radii_mm: [140.0; 3] };
        let found =
            [x, 2.0, 148.0, 140.0, 140.0, 140.0].map(|value_mm| Parameter { run_id: 1, index: 0, value_mm, sigma_mm });
        Verdict::new(&found, &truth, [sigma; 6])
    }

    #[test]
    fn an_error_within_five_sigma_and_a_twentieth_is_right() {
        assert_eq!(verdict(1.0, 0.0).objections(), Vec::<String>::new());
        assert!(verdict(1.149, 0.02).objections().is_empty());
        let objections = verdict(1.151, 0.02).objections();
        assert_eq!(objections.len(), 1);
        assert!(objections[0].starts_with("x is off by +0.1510 mm"), "{objections:?}");
    }

    #[test]
    fn a_bar_that_does_not_hold_the_error_is_an_objection() {
        assert!(with_bar(1.3, 0.1, 0.06).objections().is_empty());
        let objections = with_bar(1.3, 0.1, 0.04).objections();
        assert_eq!(objections.len(), 1);
        assert!(objections[0].ends_with("that the board's own σ allows"), "{objections:?}");
    }

    #[test]
    fn no_number_is_never_right() {
        assert!(!verdict(f32::NAN, 0.02).objections().is_empty());
        assert!(!verdict(1.0, f64::NAN).objections().is_empty());
    }

    #[test]
    fn a_tolerance_so_wide_that_it_means_nothing_is_an_objection() {
        assert_eq!(verdict(1.0, 3.0).objections().len(), 1);
    }
}
