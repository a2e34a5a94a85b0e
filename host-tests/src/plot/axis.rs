//! Axes: what they measure, where data falls on them, and which values are written beside them.

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equal distances.
    Linear,
    /// Equal ratios are equal distances (powers of ten are labelled).
    Log10,
}

/// One axis: title with unit, scale, and values that it must show whatever the data.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub(super) title: String,
    pub(super) scale: Scale,
    including: Vec<f64>,
    whole: bool,
}

impl Axis {
    /// A linear axis. The title carries the unit: `"cable noise (mm)"`.
    pub fn linear(title: &str) -> Self {
        Self { title: title.to_string(), scale: Scale::Linear, including: Vec::new(), whole: false }
    }

    /// A logarithmic axis, for positive values only.
    pub fn log10(title: &str) -> Self {
        Self { scale: Scale::Log10, ..Self::linear(title) }
    }

    /// The axis of a count: linear, from 0 or 1 upwards, labelled at whole numbers only.
    pub fn count(title: &str) -> Self {
        Self { whole: true, ..Self::linear(title) }
    }

    /// Extends the axis so that it shows `value` too.
    #[must_use]
    pub fn including(mut self, value: f64) -> Self {
        self.including.push(value);
        self
    }

    /// Whether `value` has a place on this axis.
    pub(super) fn holds(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0)
    }

    /// The range that the axis covers for data between `least` and `most`, ending on labelled values, and its ticks.
    /// None when a value that it must include has no place on it.
    pub(super) fn ticks(&self, least: f64, most: f64) -> Option<Ticks> {
        if !self.including.iter().all(|&value| self.holds(value)) {
            return None;
        }
        let least = self.including.iter().fold(least, |a, &b| a.min(b));
        let most = self.including.iter().fold(most, |a, &b| a.max(b));
        Some(match self.scale {
            Scale::Linear => linear_ticks(least, most, self.whole),
            Scale::Log10 => logarithmic_ticks(least, most),
        })
    }
}

/// A range and what is written along it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ticks {
    pub(super) lowest: f64,
    pub(super) highest: f64,
    /// Labelled values with their labels, ascending.
    pub(super) major: Vec<(f64, String)>,
    /// Values with a faint grid line and no label.
    pub(super) minor: Vec<f64>,
}

/// Steps of 1, 2 or 5 times a power of ten, four to nine of them.
fn linear_ticks(least: f64, most: f64, whole: bool) -> Ticks {
    // A single value gets a range about it, so that the step is not zero.
    let (least, most) = if most > least { (least, most) } else { (least - 0.5, most + 0.5) };
    let rough = (most - least) / 7.0;
    let power = libm::floor(libm::log10(rough)) as i32;
    let unit = power_of_ten(power);
    let mut step = [1.0, 2.0, 5.0, 10.0].map(|m| m * unit).into_iter().find(|&s| s >= rough).unwrap_or(10.0 * unit);
    let mut decimals = if step >= 10.0 * unit { -power - 1 } else { -power }.max(0) as usize;
    if whole && step < 1.0 {
        (step, decimals) = (1.0, 0);
    }
    // 1e-9 of a step forgives the rounding of values that lie on a tick.
    let first = libm::floor(least / step + 1e-9) as i64;
    let last = libm::ceil(most / step - 1e-9) as i64;
    let major = (first..=last).map(|k| (k as f64 * step, format!("{:.decimals$}", k as f64 * step))).collect();
    Ticks { lowest: first as f64 * step, highest: last as f64 * step, major, minor: Vec::new() }
}

/// Powers of ten, at most eight of them labelled; within a narrow range also 2 and 5 times a power of ten.
fn logarithmic_ticks(least: f64, most: f64) -> Ticks {
    let narrow = most / least < 30.0;
    let marks: &[f64] = if narrow { &[1.0, 2.0, 5.0] } else { &[1.0] };
    // Rounded outward to the next mark.
    let below = libm::floor(libm::log10(least) + 1e-12) as i32;
    let above = libm::ceil(libm::log10(most) - 1e-12) as i32;
    let all: Vec<f64> = (below..=above)
        .flat_map(|p| marks.iter().map(move |m| m * power_of_ten(p)))
        .filter(|&v| v <= power_of_ten(above))
        .collect();
    let lowest = all.iter().copied().filter(|&v| v <= least * (1.0 + 1e-9)).fold(power_of_ten(below), f64::max);
    let highest = all.iter().copied().filter(|&v| v >= most * (1.0 - 1e-9)).fold(power_of_ten(above), f64::min);
    let (lowest, highest) = if lowest < highest { (lowest, highest) } else { (lowest, lowest * 10.0) };
    let decades = (above - below).max(1) as usize;
    let stride = decades.div_ceil(8) as i32;
    let major = all
        .iter()
        .copied()
        .filter(|&v| v >= lowest && v <= highest)
        .filter(|&v| narrow || (libm::round(libm::log10(v)) as i32).rem_euclid(stride) == 0)
        .map(|v| (v, logarithmic_label(v)))
        .collect();
    let minor = if decades > 8 {
        all
    } else {
        (below..=above).flat_map(|p| (2..10).map(move |m| f64::from(m) * power_of_ten(p))).collect()
    };
    let minor = minor.into_iter().filter(|&v| v > lowest && v < highest).collect();
    Ticks { lowest, highest, major, minor }
}

/// The nearest floating-point number to a power of ten.
fn power_of_ten(power: i32) -> f64 {
    // Decimal parsing is correctly rounded, which repeated multiplication is not.
    format!("1e{power}").parse().unwrap_or(f64::NAN)
}

/// `0.001` to `10000` in full, beyond that as a power of ten.
fn logarithmic_label(value: f64) -> String {
    if (0.9e-3..1.1e4).contains(&value) {
        return format!("{}", (value * 1e6).round() / 1e6);
    }
    let power = libm::floor(libm::log10(value) + 1e-9) as i32;
    let mantissa = libm::round(value / power_of_ten(power)) as i32;
    let raised: String = power
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            other => char::from_u32('⁰' as u32 + other.to_digit(10).unwrap_or(0)).unwrap_or(other),
        })
        .collect();
    if mantissa == 1 { format!("10{raised}") } else { format!("{mantissa}·10{raised}") }
}

/// Places values between two positions on the sheet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ruler {
    scale: Scale,
    lowest: f64,
    span: f64,
    start: f32,
    length: f32,
}

impl Ruler {
    /// `start` and `end` are where the lowest and the highest value of `ticks` come to lie, CSS pixels.
    pub(super) fn new(scale: Scale, ticks: &Ticks, start: f32, end: f32) -> Self {
        let place = |value| if scale == Scale::Log10 { libm::log10(value) } else { value };
        let lowest = place(ticks.lowest);
        Self { scale, lowest, span: place(ticks.highest) - lowest, start, length: end - start }
    }

    /// Where `value` lies, CSS pixels.
    pub(super) fn at(&self, value: f64) -> f32 {
        let place = if self.scale == Scale::Log10 { libm::log10(value) } else { value };
        self.start + ((place - self.lowest) / self.span) as f32 * self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &Ticks) -> Vec<&str> {
        ticks.major.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn a_linear_axis_ends_on_round_numbers_around_the_data() {
        let ticks = linear_ticks(0.0, 97.0, false);
        assert_eq!(labels(&ticks), ["0", "20", "40", "60", "80", "100"]);
        let ticks = linear_ticks(-0.13, 0.31, false);
        assert_eq!(labels(&ticks), ["-0.2", "-0.1", "0.0", "0.1", "0.2", "0.3", "0.4"]);
    }

    #[test]
    fn an_axis_of_counts_has_no_half_labels() {
        assert_eq!(labels(&linear_ticks(0.0, 3.0, true)), ["0", "1", "2", "3"]);
        assert_eq!(labels(&linear_ticks(0.0, 3.0, false)), ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0"]);
    }

    #[test]
    fn a_logarithmic_axis_labels_powers_of_ten() {
        let ticks = logarithmic_ticks(3e-6, 31.57);
        assert_eq!(labels(&ticks), ["10⁻⁶", "10⁻⁵", "10⁻⁴", "0.001", "0.01", "0.1", "1", "10", "100"]);
        assert!(ticks.minor.contains(&2.0));
    }

    #[test]
    fn a_narrow_logarithmic_axis_also_labels_two_and_five() {
        assert_eq!(labels(&logarithmic_ticks(0.07, 0.4)), ["0.05", "0.1", "0.2", "0.5"]);
    }

    #[test]
    fn a_ruler_places_the_geometric_mean_in_the_middle_of_a_logarithmic_axis() {
        let ticks = logarithmic_ticks(1e-4, 1e4);
        let ruler = Ruler::new(Scale::Log10, &ticks, 100.0, 500.0);
        assert_eq!(ruler.at(1.0), 300.0);
        assert_eq!(ruler.at(1e-4), 100.0);
    }
}
