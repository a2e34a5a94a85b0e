//! The outcome for people: a short table, or the reason and the remedy.

use super::causes::{self, CauseKind, Causes};
use super::held_report;
use super::lengths_file::LengthsFile;
use super::refusal::RefusalDetail;
use super::remedy;
use super::report::{Method, Precision, RejectedCable, Report, Setting};
use super::verification::Verification;
use super::wording::{counted, direction, fixed, pose, small};
use std::fmt::Write;

/// Noise this many times above what the rig should have makes one look twice.
const SUSPICIOUS_NOISE: f64 = 3.0;

/// Factor on the centre's standard deviation above which unknown encoder offsets dominate it.
const OFFSETS_DOMINATE: f64 = 1.5;

/// The whole text, several lines.
pub fn of(report: &Report, log: &LengthsFile, still: Option<&LengthsFile>, second: Option<&LengthsFile>) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = match report.refusal {
        Some(ref refusal) => refused(&mut text, report, refusal, log, still),
        None => table(&mut text, report)
            .and_then(|()| figures(&mut text, report, log))
            .and_then(|()| joint(&mut text, report, still))
            .and_then(|()| explanation(&mut text, report, log)),
    };
    let _ = method(&mut text, report, log);
    if let (Some(verification), Some(second)) = (&report.verification, second) {
        let _ = line(&mut text, "verification", &verified(verification, second));
    }
    text
}

fn refused(
    text: &mut String,
    report: &Report,
    refusal: &RefusalDetail,
    log: &LengthsFile,
    still: Option<&LengthsFile>,
) -> std::fmt::Result {
    let held = report.held.as_ref().filter(|held| held.refused).zip(still);
    let log = held.map_or(log, |(_, still)| still);
    writeln!(text, "Refused: {}.\n", report.reason.unwrap_or_default())?;
    line(text, "seen", &remedy::seen(refusal, log))?;
    if let Some(misread) = held.and_then(|(held, still)| held_report::left_out(held, still)) {
        line(text, "misread", &misread)?;
    }
    explanation(text, report, log)?;
    match &report.cause {
        // What a joint may do as well has its remedies besides.
        Some(Causes { best, or: None }) if !best.kind.may_be_the_joint() => Ok(()),
        _ => {
            let of_held = held.and_then(|(held, still)| held_report::remedy(refusal, held, still));
            line(text, "what to do", &of_held.unwrap_or_else(|| remedy::remedy(report, refusal)))
        }
    }
}

/// What is known of a joint that moves.
fn joint(text: &mut String, report: &Report, still: Option<&LengthsFile>) -> std::fmt::Result {
    if let Some(scatter_mm) = report.scatter_mm {
        let scatter =
            format!("a centre that moves with the arm, and scatters by {} mm along each axis", small(scatter_mm));
        line(text, "joint", &format!("{scatter}; x, y, z are where it is at the arm's mean direction"))?;
    }
    if let Some((held, still)) = report.held.as_ref().zip(still) {
        let left_out =
            held_report::left_out(held, still).map_or("none left out".to_owned(), |at| format!("left out: {at}"));
        line(text, "held phase", &format!("{} in {}, {left_out}", counted(held.poses, "pose"), still.file()))?;
        if report.joint == Some("ball") {
            line(text, "", "not used: a ball explains the free poses")?;
        }
    }
    Ok(())
}

/// What fits better, and what to do about it.
fn explanation(text: &mut String, report: &Report, log: &LengthsFile) -> std::fmt::Result {
    let is_that_joint = |found: &&Causes| found.best.kind == CauseKind::MovingJoint && has_moving_joint(report);
    if let Some(found) = report.cause.as_ref().filter(|found| !is_that_joint(found)) {
        line(text, "fits better", &causes::text(found, log))?;
        line(text, "what to do", causes::remedy(&found.best))?;
    }
    if let Some(cause) = &report.contradiction {
        let alone = Causes { best: *cause, or: None };
        line(text, "look twice", &format!("{}, which its tolerance does not allow", causes::text(&alone, log)))?;
        line(text, "", causes::remedy(cause))?;
    }
    Ok(())
}

/// Was a centre that moves found, or refused for what such a centre lacks?
fn has_moving_joint(report: &Report) -> bool {
    let of_it = |refusal: &RefusalDetail| {
        matches!(
            refusal,
            RefusalDetail::TooFewForMovingCentre { .. }
                | RefusalDetail::MissingMotion { .. }
                | RefusalDetail::SlippedMidway { .. }
                | RefusalDetail::NotExplained { .. }
        )
    };
    report.joint == Some("moving") || report.refusal.as_ref().is_some_and(of_it)
}

fn table(text: &mut String, report: &Report) -> std::fmt::Result {
    let (Some(centre), Some(radii), Some(sigma)) = (report.centre_mm, report.radii_mm, report.sigma_mm) else {
        return Ok(());
    };
    writeln!(text, "Joint centre identified.\n")?;
    writeln!(text, "  mm        value     1 sigma")?;
    let names = ["x", "y", "z", "p1", "p2", "p3"];
    for ((name, value), sigma) in names.iter().zip(centre.iter().chain(&radii)).zip(sigma) {
        writeln!(text, "  {name:2} {:>12} {:>11}", fixed(*value, 4), small(sigma))?;
    }
    if let (Some(zeros), Some(sigmas)) = (report.zeros_mm, report.zero_sigmas_mm) {
        writeln!(text, "\n  mm too much at encoder")?;
        for (index, (zero, sigma)) in zeros.iter().zip(sigmas).enumerate() {
            writeln!(text, "  {:2} {:>12} {:>11}", index + 1, fixed(*zero, 4), small(sigma))?;
        }
    }
    writeln!(text)
}

fn figures(text: &mut String, report: &Report, log: &LengthsFile) -> std::fmt::Result {
    if let Some(worst) = report.worst_centre {
        let worst = format!("1 sigma of {} mm along {}", small(worst.sigma_mm), direction(&worst.direction));
        line(text, "worst of centre", &worst)?;
    }
    if let (Some(worst), Some(homed)) = (report.worst_centre, report.worst_sigma_if_homed_mm) {
        let dominated =
            if worst.sigma_mm > homed * OFFSETS_DOMINATE { "the centre depends on the zeros: " } else { "" };
        line(text, "homing", &format!("{dominated}with known zeros it would be {} mm", small(homed)))?;
    }
    if let Some(deviation) = report.deviation_mm {
        let of = match report.setting.method {
            Method::Full => "cable lengths",
            Method::Paper => "platform edges",
        };
        let steps = counted(report.iterations.into(), "iteration");
        line(text, "deviation", &format!("{} mm root mean square of the {of}, {steps}", small(deviation)))?;
    }
    let used = report.poses_used.unwrap_or_default();
    if let Some(noise) = report.noise_mm {
        let source = match report.setting.given_noise_mm {
            Some(_) => "as given".to_owned(),
            // The library lets what is expected of the rig weigh in, which matters for few poses.
            None => format!("estimated: {} degrees of freedom, and what the rig should have", 3 * used as i64 - 6),
        };
        line(text, "noise", &format!("{} mm, {source}", small(noise)))?;
        if let Some(warning) = noise_warning(noise, &report.setting) {
            line(text, "", &warning)?;
        }
    }
    let left_out = match report.setting.rows_used.count - used {
        0 => "none left out".to_owned(),
        count => format!("{count} left out:"),
    };
    line(text, "poses", &format!("{used} used, {left_out}"))?;
    let mut rest = report.rejected.as_slice();
    while let Some(first) = rest.first() {
        let (same, others) = rest.split_at(rest.iter().take_while(|entry| entry.pose == first.pose).count());
        line(text, "", &format!("{}: {}", pose(first.pose, log), suspects(same)))?;
        rest = others;
    }
    Ok(())
}

/// What one should know about noise that is larger than the rig's, mm.
fn noise_warning(noise_mm: f64, setting: &Setting) -> Option<String> {
    let (expected, limit) = (setting.expected_noise_mm, setting.noise_limit_mm);
    match setting.method {
        Method::Paper if noise_mm > limit => Some(format!(
            "more than the {limit:.2} mm that noise may be: these poses have no common centre, or some are bad. The \
             paper's method takes any residual for noise; --method full refuses, or leaves out the bad ones"
        )),
        Method::Full if setting.given_noise_mm.is_none() && noise_mm > expected * SUSPICIOUS_NOISE => Some(format!(
            "more than the {expected:.3} mm expected of this rig: the joint centre may not be fixed, or the rig file be off; \
             --noise {expected:.3} tests it"
        )),
        _ => None,
    }
}

/// The faulty cables of one pose.
fn suspects(entries: &[RejectedCable]) -> String {
    let cables: Vec<String> = entries.iter().filter_map(|entry| entry.cable).map(|cable| cable.to_string()).collect();
    match cables.as_slice() {
        [] => "no single cable explains it".to_owned(),
        [one] => format!("cable {one}"),
        several => format!("cables {}: one of them, or exchanged", several.join(" and ")),
    }
}

/// How it was computed, and from which rows.
fn method(text: &mut String, report: &Report, log: &LengthsFile) -> std::fmt::Result {
    let precision = match report.setting.precision {
        Precision::F32 => "single precision",
        Precision::F64 => "double precision",
    };
    match report.setting.start {
        None => line(text, "method", &format!("start-free, {precision}"))?,
        Some(start) => {
            let values = start.values_mm.map(|value| fixed(value, 2)).join(", ");
            line(text, "method", &format!("the paper's, {precision}"))?;
            line(text, "start", &format!("{values} ({})", start.from))?;
        }
    }
    let rows = report.setting.rows_used;
    let at = |row: usize| log.rows().get(row).map_or(0, |row| row.line);
    let (first, last) = (at(rows.first), at(rows.last));
    if rows.is_partial() {
        let used = format!(
            "{} of {} used, evenly spread: row 0 (line {first}), then every {:.2} rows, to row {} (line {last})",
            rows.count, rows.of, rows.step, rows.last
        );
        line(text, "rows", &used)
    } else {
        line(text, "rows", &format!("{}, lines {first} to {last}", rows.of))
    }
}

fn verified(found: &Verification, log: &LengthsFile) -> String {
    let of = found.limit_mm.map_or("platform edges", |_| "cable lengths");
    let mut text = match (found.deviation_mm, found.worst_pose, found.worst_deviation_mm) {
        (Some(deviation), Some(worst), Some(its)) => format!(
            "{} mm root mean square of the {of} over {} poses of {}, worst {} mm at {}",
            small(deviation),
            found.pose_count - found.contradicting.len(),
            log.file(),
            small(its),
            pose(worst, log)
        ),
        _ => format!("no pose of {} can be checked", log.file()),
    };
    match (found.agrees, found.limit_mm) {
        (Some(true), _) => text += "; they agree with the result",
        (Some(false), Some(limit)) => {
            text += &format!("; they contradict the result: {} mm at most is expected", small(limit))
        }
        _ => {}
    }
    if let Some(first) = found.contradicting.first() {
        let count = found.contradicting.len();
        text += &format!("; {count} contradict the centre altogether, the first is {}", pose(*first, log));
    }
    text
}

/// One entry: its name, and its value in lines of a readable width beside it.
pub(crate) fn line(text: &mut String, name: &str, value: &str) -> std::fmt::Result {
    const WIDTH: usize = 92;
    write!(text, "  {name:16}")?;
    let mut column = 0;
    for word in value.split(' ') {
        let width = word.chars().count();
        if column > 0 && column + 1 + width > WIDTH {
            write!(text, "\n  {:16}", "")?;
            column = 0;
        } else if column > 0 {
            text.push(' ');
            column += 1;
        }
        text.push_str(word);
        column += width;
    }
    writeln!(text)
}
