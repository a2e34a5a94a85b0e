//! The names of the stages, and which may follow which.

use super::Stage;
use crate::scalar::Real;

/// A stage without its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StageName {
    /// Is the input sound?
    Begin,
    /// The hinges that the starts lead to.
    Search,
    /// Does the best of them explain the poses?
    Judge,
    /// Poses that contradict the others are left out.
    Outliers,
    /// Is there a second axis?
    Second,
    /// Why nothing fits.
    Explain,
    /// Does the joint bend enough?
    Bend,
    /// The result and its covariance.
    Report,
    /// Another hinge that fits as well?
    Compare,
    /// Is the covariance true?
    Profile,
    /// Fault isolation.
    Isolate,
    /// The result stands, or a refusal.
    Done,
}

/// All transitions; the diagram of [`estimator`](super) is held against them by a test.
pub const TRANSITIONS: [(StageName, &str, StageName); 22] = {
    use StageName::{Begin, Bend, Compare, Done, Explain, Isolate, Judge, Outliers, Profile, Report, Search, Second};
    [
        (Begin, "sound", Search),
        (Begin, "refused", Done),
        (Search, "candidates", Judge),
        (Search, "none", Done),
        (Judge, "noise", Bend),
        (Judge, "otherwise", Outliers),
        (Outliers, "left out", Bend),
        (Outliers, "no hinge", Second),
        (Outliers, "nothing fits", Explain),
        (Outliers, "refused", Done),
        (Second, "refused", Done),
        (Explain, "refused", Done),
        (Bend, "enough", Report),
        (Bend, "refused", Done),
        (Report, "finished", Compare),
        (Report, "refused", Done),
        (Compare, "other", Report),
        (Compare, "accurate", Profile),
        (Compare, "refused", Done),
        (Profile, "true", Isolate),
        (Profile, "refused", Done),
        (Isolate, "isolated", Done),
    ]
};

/// May `to` follow `from`?
pub fn may_follow(from: StageName, to: StageName) -> bool {
    TRANSITIONS.iter().any(|(a, _, b)| (*a, *b) == (from, to))
}

impl<T: Real> Stage<T> {
    /// The stage's name.
    pub(super) const fn name(&self) -> StageName {
        match self {
            Self::Begin => StageName::Begin,
            Self::Search(_) => StageName::Search,
            Self::Judge => StageName::Judge,
            Self::Outliers(_) => StageName::Outliers,
            Self::Second(_) => StageName::Second,
            Self::Explain(_) => StageName::Explain,
            Self::Bend(_) => StageName::Bend,
            Self::Report(..) => StageName::Report,
            Self::Compare(_) => StageName::Compare,
            Self::Profile(_) => StageName::Profile,
            Self::Isolate(_) => StageName::Isolate,
            Self::Done(_) => StageName::Done,
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::TRANSITIONS;
    use std::collections::BTreeSet;
    use std::format;
    use std::string::String;

    #[test]
    fn the_diagram_shows_the_table() {
        let lines = include_str!("mod.rs").lines().filter_map(|line| line.strip_prefix("//! "));
        let words = |line: &str| {
            line.replace("--", " ").replace('>', " ").split_whitespace().collect::<std::vec::Vec<_>>().join(" ")
        };
        let drawn: BTreeSet<String> = lines.filter(|line| line.contains("-->")).map(words).collect();
        let table: BTreeSet<String> =
            TRANSITIONS.iter().map(|(from, why, to)| format!("{from:?} {why} {to:?}")).collect();
        assert_eq!(drawn, table);
    }
}
