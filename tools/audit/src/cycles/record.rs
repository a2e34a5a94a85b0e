//! All figures as one list, kept in the tree: a toolchain's own rows, since compilers differ.
//!
//! CSV with the header `toolchain,path,precision,figure,value`. A change that makes the code slower or larger by more
//! than [`GROWTH_LIMIT_PERCENT`] is found by comparing a run with the list.

use std::fmt;

use super::agreement::Traced;
use super::figures::Path;

/// Growth of a figure that is taken for a change for the worse, %.
pub const GROWTH_LIMIT_PERCENT: u64 = 3;

/// Distance of an identified centre from the true one at which the figures are those of a wrong result, nm: the
/// paper's tolerance of 1e-3 mm.
pub const ERROR_LIMIT_NM: u64 = 1_000;

/// The same where the lengths have noise of ±0.1 mm: five standard deviations of the centre from 100 poses.
pub const ERROR_LIMIT_WITH_NOISE_NM: u64 = 110_000;

/// The same where the machine's own parameters are estimated too.
pub const ERROR_LIMIT_WITH_MACHINE_NM: u64 = 500_000;

/// The same of a shoulder in one phase, which leaves open where the centre is along the arm: `cargo study shoulder` judges it.
pub const ERROR_LIMIT_OF_SHOULDER_NM: u64 = 10_000_000;

/// The same of the foot point of an elbow's axis, from 30 poses: five standard deviations.
pub const ERROR_LIMIT_OF_ELBOW_NM: u64 = 1_000_000;

/// Most estimated cycles of an event of the device and of a slice of the estimator, however hard the set: 59 µs at 170 MHz. A
/// turn of the board's main loop has several: up to four commands, a sample and a tick.
pub const EVENT_LIMIT_CYCLES: u64 = 10_000;

/// The limit of the longest piece of a path, if it has one beside the growth.
fn piece_limit(path: &str) -> Option<u64> {
    let is_piece = path.ends_with("-slice") || path.starts_with("device-");
    is_piece.then_some(EVENT_LIMIT_CYCLES)
}

/// The limit for a path by its name in the speed image.
fn error_limit_nm(path: &str) -> u64 {
    if path.contains("shoulder") {
        ERROR_LIMIT_OF_SHOULDER_NM
    } else if path.contains("elbow") {
        ERROR_LIMIT_OF_ELBOW_NM
    } else if path.contains("machine") {
        ERROR_LIMIT_WITH_MACHINE_NM
    } else if path.contains("noise") || path.contains("outlier") {
        ERROR_LIMIT_WITH_NOISE_NM
    } else {
        ERROR_LIMIT_NM
    }
}

const HEADER: &str = "toolchain,path,precision,figure,value";

/// One figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// `rustup` or `debian`, and the compiler's version.
    pub toolchain: String,
    /// Name of the path, or `image` for flash.
    pub path: String,
    /// `f32` or `f64`.
    pub precision: String,
    /// What is counted.
    pub figure: String,
    /// How much.
    pub value: u64,
}

/// Every figure of one run or several.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Record {
    /// The rows in their order.
    pub rows: Vec<Row>,
}

/// Why the list cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Malformed {
    /// The line, from 1.
    pub line: usize,
}

impl fmt::Display for Malformed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {} is not \"{HEADER}\"", self.line)
    }
}

impl std::error::Error for Malformed {}

impl Record {
    /// The figures of one run: counted paths, estimated cycles of those that were traced, flash by part.
    pub fn of_run(toolchain: &str, paths: &[Path], traced: &[Option<Traced>], flash: &[(String, u64)]) -> Self {
        let mut record = Self::default();
        let mut push = |path: &str, precision: &str, figure: &str, value| {
            record.rows.push(Row {
                toolchain: toolchain.to_owned(),
                path: path.to_owned(),
                precision: precision.to_owned(),
                figure: figure.to_owned(),
                value,
            });
        };
        for (index, path) in paths.iter().enumerate() {
            let mut push = |figure: &str, value| push(&path.name, &path.precision, figure, value);
            let traced = traced.get(index).and_then(Option::as_ref);
            push("counts", path.counts);
            push("instructions", path.instructions);
            if !path.is_whole() {
                push("worst-instructions", path.worst);
            }
            if let Some(traced) = traced {
                push("cycles", traced.sum.cycles());
                if !path.is_whole() {
                    push("worst-cycles", traced.worst.cycles());
                }
            }
            push("state-bytes", path.state_bytes);
            push("stack-bytes", path.stack_bytes);
            if path.steps > 0 {
                push("steps", path.steps);
                push("error-nm", path.error_nm);
            }
        }
        for (part, bytes) in flash {
            let (path, precision) = part.split_once('-').unwrap_or((part, ""));
            push(path, precision, "flash-bytes", *bytes);
        }
        record
    }

    /// Reads the list.
    ///
    /// # Errors
    /// [`Malformed`].
    pub fn from_csv(text: &str) -> Result<Self, Malformed> {
        let mut lines = text.lines().enumerate();
        if lines.next().map(|(_, line)| line.trim()) != Some(HEADER) {
            return Err(Malformed { line: 1 });
        }
        let row = |(index, line): (usize, &str)| {
            let malformed = Malformed { line: index + 1 };
            let fields: Vec<&str> = line.trim().split(',').collect();
            let [toolchain, path, precision, figure, value] = fields[..] else { return Err(malformed) };
            let value = value.parse().map_err(|_| malformed)?;
            let [toolchain, path, precision, figure] = [toolchain, path, precision, figure].map(str::to_owned);
            Ok(Row { toolchain, path, precision, figure, value })
        };
        Ok(Self { rows: lines.filter(|(_, line)| !line.trim().is_empty()).map(row).collect::<Result<_, _>>()? })
    }

    /// The list as it is kept.
    pub fn to_csv(&self) -> String {
        let mut text = format!("{HEADER}\n");
        for row in &self.rows {
            text += &format!("{},{},{},{},{}\n", row.toolchain, row.path, row.precision, row.figure, row.value);
        }
        text
    }

    /// This list with the rows of a run in place of the toolchain's own.
    #[must_use]
    pub fn updated(&self, run: &Self) -> Self {
        let others = self.rows.iter().filter(|row| run.rows.iter().all(|new| new.toolchain != row.toolchain));
        let mut rows: Vec<Row> = others.chain(&run.rows).cloned().collect();
        rows.sort_by(|a, b| b.toolchain.cmp(&a.toolchain));
        Self { rows }
    }

    /// The value of a figure.
    pub fn value(&self, toolchain: &str, path: &str, precision: &str, figure: &str) -> Option<u64> {
        let found = |row: &&Row| {
            row.toolchain == toolchain && row.path == path && row.precision == precision && row.figure == figure
        };
        self.rows.iter().find(found).map(|row| row.value)
    }

    /// What of `run` is worse than this list, one sentence a figure; empty when nothing is.
    pub fn worsened(&self, run: &Self) -> Vec<String> {
        let mut findings = Vec::new();
        if let Some(new) = run.rows.iter().find(|new| self.rows.iter().all(|old| old.toolchain != new.toolchain)) {
            return vec![format!("the list has no figures of {}, and compilers differ: keep them", new.toolchain)];
        }
        for new in &run.rows {
            let Row { toolchain, path, precision, figure, value } = new;
            let name = format!("{path} {precision}, {figure} ({toolchain})");
            if figure == "error-nm" {
                // An error of a few nanometres is rounding; only its size as such means something.
                let limit = error_limit_nm(path);
                if *value > limit {
                    findings.push(format!("{name}: {value}, and at most {limit} is allowed"));
                }
                continue;
            }
            if let (Some(limit), "worst-cycles", "f32") = (piece_limit(path), figure.as_str(), precision.as_str())
                && *value > limit
            {
                findings.push(format!("{name}: {value}, and at most {limit} is allowed"));
            }
            match self.value(toolchain, path, precision, figure) {
                None => findings.push(format!("{name}: {value}, and the list has no such row")),
                Some(old) if value * 100 > old * (100 + GROWTH_LIMIT_PERCENT) => {
                    let percent = (*value as f64 / (old as f64).max(1.0) - 1.0) * 100.0;
                    findings.push(format!("{name}: {old} before, {value} now (+{percent:.1} %)"));
                }
                Some(_) => {}
            }
        }
        for old in &self.rows {
            let runs = run.rows.iter().any(|new| new.toolchain == old.toolchain);
            if runs && run.value(&old.toolchain, &old.path, &old.precision, &old.figure).is_none() {
                findings.push(format!(
                    "{} {}, {} ({}): not measured any more",
                    old.path, old.precision, old.figure, old.toolchain
                ));
            }
        }
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEPT: &str = "toolchain,path,precision,figure,value\n\
                        rustup,paper,f32,instructions,1000\nrustup,paper,f32,error-nm,25\ndebian,paper,f32,instructions,900\n";

    fn with(value: u64, error: u64) -> Record {
        let text = format!("{HEADER}\nrustup,paper,f32,instructions,{value}\nrustup,paper,f32,error-nm,{error}\n");
        Record::from_csv(&text).unwrap()
    }

    #[test]
    fn the_list_survives_writing_and_reading() {
        assert_eq!(Record::from_csv(KEPT).unwrap().to_csv(), KEPT);
        assert_eq!(Record::from_csv("a,b\n"), Err(Malformed { line: 1 }));
        assert_eq!(Record::from_csv(&format!("{HEADER}\nrustup,paper,f32,instructions\n")), Err(Malformed { line: 2 }));
        assert_eq!(Record::from_csv(&format!("{HEADER}\nrustup,paper,f32,cycles,-1\n")), Err(Malformed { line: 2 }));
    }

    #[test]
    fn growth_beyond_three_percent_is_named() {
        let kept = Record::from_csv(KEPT).unwrap();
        assert_eq!(kept.worsened(&with(1030, 999)), [""; 0]);
        assert_eq!(kept.worsened(&with(1, 25)), [""; 0]);
        let findings = kept.worsened(&with(1031, 25));
        assert_eq!(findings.len(), 1);
        assert!(findings[0].contains("paper f32, instructions") && findings[0].contains("+3.1 %"), "{findings:?}");
        assert_eq!(kept.worsened(&with(1000, 1001)).len(), 1);
    }

    #[test]
    fn a_slice_that_is_too_long_is_named_whatever_the_list_says() {
        let list = |value: u64| {
            Record::from_csv(&format!("{HEADER}\nrustup,device-frame,f32,worst-cycles,{value}\n")).unwrap()
        };
        assert_eq!(list(10_000).worsened(&list(10_000)), [""; 0]);
        assert!(list(10_001).worsened(&list(10_001))[0].contains("at most 10000"));
    }

    #[test]
    fn a_row_too_many_or_too_few_is_named() {
        let kept = Record::from_csv(KEPT).unwrap();
        let missing = Record { rows: kept.rows[..1].to_vec() };
        assert!(kept.worsened(&missing)[0].contains("not measured"));
        assert!(missing.worsened(&with(1000, 25)).is_empty(), "an error has no row to be compared with");
        assert!(Record { rows: kept.rows[1..].to_vec() }.worsened(&with(1000, 25))[0].contains("no such row"));
    }

    #[test]
    fn an_update_leaves_the_other_toolchain_alone() {
        let updated = Record::from_csv(KEPT).unwrap().updated(&with(700, 24));
        assert_eq!(updated.value("debian", "paper", "f32", "instructions"), Some(900));
        assert_eq!(updated.value("rustup", "paper", "f32", "instructions"), Some(700));
        assert_eq!(updated.rows.len(), 3);
    }
}
