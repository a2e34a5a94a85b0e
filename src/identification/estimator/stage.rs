//! The names of the stages, and which may follow which.

use super::Stage;
use crate::scalar::Real;

/// A stage without its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StageName {
    /// Placing poses.
    Place,
    /// Gauss-Newton.
    Refine,
    /// Rotational excitation.
    Excite,
    /// Is it the machine that looks like a moving centre?
    Compare,
    /// The gates of a moving centre.
    Inspect,
    /// Leave-one-out.
    Check,
    /// Fault isolation.
    Isolate,
    /// The result stands, or a refusal.
    Done,
}

/// All transitions; the diagram of [`estimator`](super) is held against them by a test.
pub const TRANSITIONS: [(StageName, &str, StageName); 21] = {
    use StageName::{Check, Compare, Done, Excite, Inspect, Isolate, Place, Refine};
    [
        (Place, "placed", Refine),
        (Place, "singular", Excite),
        (Place, "refused", Done),
        (Refine, "otherwise", Refine),
        (Refine, "converged", Excite),
        (Refine, "refused", Done),
        (Excite, "accepted", Check),
        (Excite, "not fixed", Refine),
        (Excite, "refused", Done),
        (Excite, "moving", Refine),
        (Refine, "explained", Compare),
        (Compare, "moving", Refine),
        (Compare, "refused", Done),
        (Refine, "compared", Inspect),
        (Refine, "held", Check),
        (Inspect, "accepted", Check),
        (Inspect, "refused", Done),
        (Place, "moving", Excite),
        (Check, "redundant", Isolate),
        (Check, "refused", Done),
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
            Self::Place(_) => StageName::Place,
            Self::Refine(_) => StageName::Refine,
            Self::Excite(_) => StageName::Excite,
            Self::Compare(_) => StageName::Compare,
            Self::Inspect(_) => StageName::Inspect,
            Self::Check(_) => StageName::Check,
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
