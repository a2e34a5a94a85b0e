//! Is it millimetres? A log or a rig in another unit is reported, not solved.

use super::lengths_file::Row;
use nalgebra::Vector3;

/// No rehabilitator is this small: a median length or a longest side below it is in another unit, mm.
const MIN_SIZE: f64 = 10.0;

/// Cables this many times longer than a side of the base are in another unit: nothing that turns about one joint
/// reaches that far.
const LONGEST_REACH: f64 = 50.0;

/// The size of an elbow's cables, mm.
const TYPICAL_MM: f64 = 200.0;

/// What people use instead of millimetres, and how many millimetres it is.
const UNITS: [(&str, f64); 4] = [("metres", 1000.0), ("inches", 25.4), ("centimetres", 10.0), ("micrometres", 1e-3)];

/// Tells lengths that are not millimetres, for a base with these attachment points, mm.
///
/// An end-point needs cables that together span its base edge, so the six lengths of a pose add up to at least the
/// base's circumference. A log in which most poses do not is in a larger unit.
pub fn complaint_about_lengths(rows: &[Row], base_mm: &[Vector3<f64>; 3]) -> Option<String> {
    let side = sides(base_mm).iter().sum::<f64>() / 3.0;
    let length = median(rows.iter().flat_map(|row| row.lengths_mm));
    let mean = median(rows.iter().map(|row| row.lengths_mm.iter().sum::<f64>() / 6.0));
    let sound = length >= MIN_SIZE && mean >= side / 2.0 && mean <= side * LONGEST_REACH;
    (!sound).then(|| complaint(length, side, "the base"))
}

/// The longest of a hinge's cables at home is no longer than so many times the median of what its log holds, and no shorter.
const HOME_WITHIN: f64 = 4.0;

/// Tells lengths about a hinge that are not millimetres. Where the rig states lengths at home, most poses are of that size.
pub fn complaint_about_hinge(lengths_mm: impl Iterator<Item = f64>, home_mm: &[f64]) -> Option<String> {
    let (length, home) = (median(lengths_mm), home_mm.iter().fold(0.0_f64, |longest, home| longest.max(*home)));
    let is_of_that_size = home == 0.0 || (home / HOME_WITHIN..=home * HOME_WITHIN).contains(&length);
    let (size, what) = if home > 0.0 { (home, "the cables at home") } else { (TYPICAL_MM, "an elbow") };
    (length < MIN_SIZE || !is_of_that_size).then(|| complaint(length, size, what))
}

/// Tells a rig that is not in millimetres. `what` is what these lengths are.
pub fn complaint_about_rig(what: &str, lengths: &[f64]) -> Option<String> {
    let longest = lengths.iter().fold(0.0, |longest: f64, length| longest.max(*length));
    (longest < MIN_SIZE).then(|| {
        let unit = if longest < 1.5 { "metres" } else { "inches" };
        format!("the longest {what} is {longest:.4}: this looks like {unit}; millimetres are wanted")
    })
}

/// The three sides of the base, mm.
pub fn sides(base_mm: &[Vector3<f64>; 3]) -> [f64; 3] {
    let [b1, b2, b3] = base_mm;
    [(b2 - b1).norm(), (b3 - b2).norm(), (b1 - b3).norm()]
}

/// Lengths of another size than what they belong to, `size` mm: another unit, if they come closer in it, or another machine.
fn complaint(length: f64, size: f64, what: &str) -> String {
    let distance = |factor: f64| (length * factor / size).ln().abs();
    let closest = UNITS.iter().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
    match closest.filter(|(_, factor)| length < MIN_SIZE || distance(*factor) < distance(1.0)) {
        Some((unit, _)) => {
            format!("the median length is {length:.4}: these look like {unit}; millimetres are wanted")
        }
        None => format!(
            "the median length is {length:.4} mm, which does not go with {what} of {size:.1} mm: is it the log of another \
             machine, or the rig's file that of one?"
        ),
    }
}

/// The median; of an even number of values the upper one, and zero of none.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
