//! The few statistics that the studies need.

/// The value below which `share` (0 to 1) of the values lie, by linear interpolation between ranks; NaN of nothing.
/// Sorts `values`.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
    let rank = share.clamp(0.0, 1.0) * last as f64;
    let below = rank as usize;
    let above = (below + 1).min(last);
    values[below] + (values[above] - values[below]) * (rank - below as f64)
}

/// Root mean square; NaN of nothing.
pub fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| (sum + value * value, count + 1));
    libm::sqrt(sum / count as f64)
}

/// How many events there may be at most where so many were seen, at 95 % confidence: for none the rule of three (Hanley and
/// Lippman-Hand 1983), else generous.
pub fn most_events(seen: usize) -> f64 {
    let seen = seen as f64;
    seen + 3.0 + 1.7 * libm::sqrt(seen)
}

/// Largest value; NaN of nothing.
pub fn largest(values: impl Iterator<Item = f64>) -> f64 {
    // The maximum of a number and NaN is the number.
    values.fold(f64::NAN, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate_between_ranks() {
        let mut values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(quantile(&mut values, 0.0), 1.0);
        assert_eq!(quantile(&mut values, 0.5), 2.5);
        assert_eq!(quantile(&mut values, 1.0), 4.0);
        assert!(quantile(&mut [], 0.5).is_nan());
    }

    #[test]
    fn the_largest_of_nothing_is_none() {
        assert_eq!(largest([1.0, 3.0, 2.0].into_iter()), 3.0);
        assert!(largest(std::iter::empty()).is_nan());
    }

    #[test]
    fn root_mean_square_of_three_and_four() {
        assert_eq!(root_mean_square([3.0, -4.0].into_iter()), libm::sqrt(12.5));
        assert!(root_mean_square(std::iter::empty()).is_nan());
    }
}
