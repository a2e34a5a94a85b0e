//! The posture against the joints: its lengths have some to spare, and those must agree with what the module's log shows.

use crate::identify::wording::fixed;
use glenoid::identification::statistics::{FALSE_ALARM, chi_square_quantile};
use serde::Serialize;

/// A wrong length is looked for this far to either side, in these steps, mm.
const FARTHEST_MM: f64 = 300.0;
const STEP_MM: f64 = 2.0;
/// The golden section of an interval, and how often it is taken.
const SECTION: f64 = 0.618_033_988_749_894_9;
const SECTIONS: usize = 30;

/// Lengths of a posture that no angle or rotation of the joint explains.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contradiction {
    /// What the lengths leave, over noise and covariance; `None` where they fit no pose at all.
    pub chi_square: Option<f64>,
    /// One sound posture in 10 000 leaves more.
    pub limit: f64,
    /// What alone would explain it, each by itself, the best first.
    pub causes: Vec<Cause>,
}

/// What alone would explain a contradiction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Cause {
    /// One length is wrong.
    Cable {
        /// From 1.
        cable: usize,
        /// By how much it is too long, mm.
        too_long_mm: f64,
    },
    /// Two lengths stand in each other's place.
    Exchanged {
        /// Both, from 1.
        cables: [usize; 2],
    },
}

/// Holds lengths, mm, against a joint: `chi_square` of any lengths, with so many degrees of freedom.
pub fn contradiction<const N: usize>(
    lengths_mm: [f64; N],
    cables: usize,
    freedom: usize,
    chi_square: impl Fn(&[f64; N]) -> Option<f64>,
) -> Option<Contradiction> {
    let limit = chi_square_quantile(freedom as f64, FALSE_ALARM);
    let found = chi_square(&lengths_mm);
    if found.is_some_and(|found| found <= limit) {
        return None;
    }
    let squares = |lengths_mm: &[f64; N]| chi_square(lengths_mm).unwrap_or(f64::INFINITY);
    let (freedom_left, mut causes) = (freedom.saturating_sub(1), Vec::new());
    // With one length less nothing could contradict the others.
    if freedom_left > 0 {
        let limit_left = chi_square_quantile(freedom_left as f64, FALSE_ALARM);
        for cable in 0..cables {
            let (too_long_mm, left) = best_correction(&squares, lengths_mm, cable);
            if left <= limit_left {
                causes.push((left, Cause::Cable { cable: cable + 1, too_long_mm }));
            }
        }
    }
    for one in 0..cables {
        for other in one + 1..cables {
            let mut exchanged = lengths_mm;
            exchanged.swap(one, other);
            let left = squares(&exchanged);
            if left <= limit {
                causes.push((left, Cause::Exchanged { cables: [one + 1, other + 1] }));
            }
        }
    }
    causes.sort_by(|one, other| one.0.total_cmp(&other.0));
    Some(Contradiction { chi_square: found, limit, causes: causes.into_iter().map(|(_, cause)| cause).collect() })
}

/// By how much a length has to be shortened to agree best with the others, mm, and the χ² that is left then.
fn best_correction<const N: usize>(
    squares: &impl Fn(&[f64; N]) -> f64,
    lengths_mm: [f64; N],
    cable: usize,
) -> (f64, f64) {
    let at = |too_long_mm: f64| {
        let mut lengths_mm = lengths_mm;
        lengths_mm[cable] -= too_long_mm;
        if lengths_mm[cable] > 0.0 { squares(&lengths_mm) } else { f64::INFINITY }
    };
    let steps = (FARTHEST_MM / STEP_MM) as i32;
    let tried = (-steps..=steps).map(|step| f64::from(step) * STEP_MM);
    let middle = tried.map(|mm| (mm, at(mm))).min_by(|one, other| one.1.total_cmp(&other.1)).map_or(0.0, |best| best.0);
    let (mut low, mut high) = (middle - STEP_MM, middle + STEP_MM);
    for _ in 0..SECTIONS {
        let (left, right) = (high - SECTION * (high - low), low + SECTION * (high - low));
        if at(left) < at(right) {
            high = right;
        } else {
            low = left;
        }
    }
    let best_mm = (low + high) / 2.0;
    (best_mm, at(best_mm))
}

impl Contradiction {
    /// What was seen, in words.
    pub fn seen(&self) -> String {
        let squares = self.chi_square.map_or_else(
            || "no pose of the joint has such lengths".to_owned(),
            |found| {
                let found = if found < 1e6 { fixed(found, 0) } else { format!("{found:.0e}") };
                format!("chi-square {found}, at most {} is accepted", fixed(self.limit, 0))
            },
        );
        let causes: Vec<_> = self.causes.iter().map(Cause::text).collect();
        match causes[..] {
            [] => squares,
            _ => format!("{squares}; this alone would explain it: {}", causes.join("; or: ")),
        }
    }
}

impl Cause {
    fn text(&self) -> String {
        match *self {
            Self::Cable { cable, too_long_mm } => {
                let way = if too_long_mm > 0.0 { "long" } else { "short" };
                format!("the length of cable {cable} is {} mm too {way}", fixed(too_long_mm.abs(), 1))
            }
            Self::Exchanged { cables: [one, other] } => {
                format!("the lengths of cables {one} and {other} are exchanged")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two measurements of one number and two of another, each with σ = 1: χ² with two degrees of freedom, and one for the
    /// pair of pairs, whose difference is 10.
    fn chi_square(x: &[f64; 4]) -> Option<f64> {
        let pair = |a: f64, b: f64| (a - b) * (a - b) / 2.0;
        let between = (x[0] + x[1] - x[2] - x[3]) / 2.0 + 10.0;
        Some(pair(x[0], x[1]) + pair(x[2], x[3]) + between * between)
    }

    #[test]
    fn lengths_that_agree_contradict_nothing() {
        assert_eq!(contradiction([100.0, 101.0, 110.5, 110.0], 4, 3, chi_square), None);
    }

    #[test]
    fn a_wrong_length_is_named_with_its_error() {
        let found = contradiction([100.0, 100.0, 137.0, 110.0], 4, 3, chi_square).unwrap();
        let [Cause::Cable { cable: 3, too_long_mm }] = found.causes[..] else { panic!("{found:?}") };
        assert!((too_long_mm - 27.0).abs() < 0.01, "{too_long_mm}");
        assert!(found.seen().ends_with("explain it: the length of cable 3 is 27.0 mm too long"), "{}", found.seen());
    }

    #[test]
    fn exchanged_lengths_are_named_where_only_one_exchange_explains_them() {
        // Each of four numbers is known by itself.
        let known = |x: &[f64; 4]| Some((0..4).map(|k| (x[k] - [10.0, 20.0, 40.0, 80.0][k]).powi(2)).sum());
        let found = contradiction([10.0, 40.0, 20.0, 80.0], 4, 4, known).unwrap();
        assert_eq!(found.causes, [Cause::Exchanged { cables: [2, 3] }]);
    }

    #[test]
    fn two_wrong_lengths_have_no_single_cause() {
        let found = contradiction([100.0, 150.0, 160.0, 110.0], 4, 3, chi_square).unwrap();
        assert_eq!(found.causes, []);
    }
}
