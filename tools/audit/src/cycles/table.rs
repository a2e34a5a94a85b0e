//! The figures as people read them: Markdown.

use super::figures::{LITERAL, LITERAL_FOR_SPEED, POSES};
use super::record::Record;

/// Marks in a document between which the table stands.
pub const BEGIN: &str = "<!-- cycles: begin -->";
/// The mark behind.
pub const END: &str = "<!-- cycles: end -->";

/// What the paths are, in the order of the table.
const PATHS: [(&str, &str); 28] = [
    (LITERAL, "the paper written out, same flags"),
    (LITERAL_FOR_SPEED, "the paper written out, `opt-level = 3`"),
    ("paper", "the paper's iteration, from a start"),
    ("start-free", "no start: weights and covariance"),
    ("start-free-noise", "the same with ±0.1 mm of noise"),
    ("start-free-outlier", "the same with one outlier"),
    ("start-free-outliers", "the same with twenty outliers"),
    ("start-free-slice", "longest slice without a start"),
    ("start-free-offsets", "no start, six unknown encoder offsets"),
    ("start-free-machine", "no start, 18 unknown constants of the machine"),
    ("start-free-machine-slice", "longest slice of the same"),
    ("shoulder", "60 poses of a shoulder whose centre moves, an exact machine: 30 unknowns"),
    ("shoulder-machine", "the same, 18 unknown constants of the machine: 48 unknowns"),
    ("shoulder-machine-slice", "longest slice of the same"),
    ("predicted-accuracy", "σ predicted for one more pose"),
    ("predicted-accuracy-machine", "the same with 18 unknown constants"),
    ("forward-kinematics", "forward kinematics, no start"),
    ("tracking", "forward kinematics, tracking"),
    ("following", "the same by one step, 200 °/s at 1 kHz"),
    ("verify", "verification of one pose"),
    ("slip-detection", "slip detection, one sample"),
    ("elbow", "an elbow from four cables and 30 poses"),
    ("elbow-slice", "longest slice of the same"),
    ("elbow-outliers-slice", "longest slice with four outliers"),
    ("elbow-machine-slice", "longest slice with 20 unknown constants of the machine"),
    ("device-tick", "whole device, one tick"),
    ("device-sample", "whole device, one encoder sample"),
    ("device-frame", "whole device, one CAN command"),
];

/// The images whose sizes are told.
const PARTS: [(&str, &str); 4] = [
    ("paper", "the paper's iteration"),
    ("free", "no start, weights, covariance, predicted σ, forward kinematics"),
    ("machine", "the same with unknown constants of the machine"),
    ("full", "both, verification and slip detection"),
];

/// The whole table of one toolchain's figures.
pub fn markdown(record: &Record, toolchain: &str) -> String {
    let value = |path: &str, precision: &str, figure: &str| record.value(toolchain, path, precision, figure);
    let mut text = format!("Counted with {toolchain}.\n\n");
    text.push_str(
        "| path | | instructions | a pose and step | literal = 1 | est. cycles | state, B | stack, B |\n\
         |---|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for precision in ["f32", "f64"] {
        for (path, words) in PATHS {
            let Some(sum) = value(path, precision, "instructions") else { continue };
            // Of what is counted pose by pose, the longest.
            let worst = value(path, precision, "worst-instructions");
            // An elbow is another problem than the hundred poses.
            let is_comparable = worst.is_none() && !path.starts_with("elbow");
            let steps = value(path, precision, "steps").filter(|_| is_comparable);
            let each = steps.map(|steps| sum / (steps.max(1) * POSES));
            let ratio = value(LITERAL, precision, "instructions")
                .filter(|_| steps.is_some())
                .map(|literal| sum as f64 / literal as f64);
            let cycles = value(path, precision, if worst.is_some() { "worst-cycles" } else { "cycles" });
            text += &format!(
                "| {words} | {precision} | {} | {} | {} | {} | {} | {} |\n",
                grouped(worst.unwrap_or(sum)),
                each.map(grouped).unwrap_or_default(),
                ratio.map(|ratio| format!("{ratio:.2}")).unwrap_or_default(),
                cycles.map(grouped).unwrap_or_default(),
                value(path, precision, "state-bytes").map(grouped).unwrap_or_default(),
                value(path, precision, "stack-bytes").map(grouped).unwrap_or_default(),
            );
        }
    }
    text += "\n| flash, B | f32 | f64 |\n|---|--:|--:|\n";
    for (part, words) in PARTS {
        let [single, double] = ["f32", "f64"].map(|precision| value(part, precision, "flash-bytes"));
        if let (Some(single), Some(double)) = (single, double) {
            text += &format!("| {words} | {} | {} |\n", grouped(single), grouped(double));
        }
    }
    text
}

/// The document with the table between its marks; `None` when it has none.
pub fn inserted(document: &str, table: &str) -> Option<String> {
    let (before, rest) = document.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{table}{END}{after}"))
}

/// Digits in groups of three.
fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped() {
        assert_eq!(
            [0, 12, 999, 1000, 432_905, 1_215_250].map(grouped),
            ["0", "12", "999", "1 000", "432 905", "1 215 250"]
        );
    }

    #[test]
    fn a_run_is_told_a_pose_and_step_and_against_the_literal_form() {
        let csv = "toolchain,path,precision,figure,value\nrustup,literal,f32,instructions,800000\nrustup,literal,f32,steps,4\n\
                   rustup,paper,f32,instructions,200000\nrustup,paper,f32,steps,4\nrustup,verify,f32,instructions,9000\n\
                   rustup,verify,f32,worst-instructions,95\n";
        let table = markdown(&Record::from_csv(csv).unwrap(), "rustup");
        assert!(table.contains("| f32 | 200 000 | 500 | 0.25 |"), "{table}");
        assert!(table.contains("| f32 | 95 |  |  |"), "{table}");
    }

    #[test]
    fn the_table_stands_between_its_marks() {
        let document = format!("a\n{BEGIN}\nold\n{END}\nb\n");
        assert_eq!(inserted(&document, "new\n"), Some(format!("a\n{BEGIN}\nnew\n{END}\nb\n")));
        assert_eq!(inserted("a", "new\n"), None);
    }
}
