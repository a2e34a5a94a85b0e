//! What `candump` recorded during a run: the poses' lengths, as the board sent them.
//!
//! Both of candump's own forms are read, that of `candump -l` and what it prints. Of several runs in one recording the
//! last one with a whole pose is taken, and that is said.

use super::board_result::{BoardResult, offset_prior_mm};
use super::text::{Text, lines};
use super::{Columns, LengthsFile, Row};
use crate::identify::input_error::InputError;
use glenoid::can::message::BLOCK;
use glenoid::can::report::RawLength;
use glenoid::can::{BaseId, Frame, Message};
use glenoid::procedure::PoseSet;
use glenoid::rig::CABLES;
use std::collections::BTreeMap;

/// Is this a candump recording? Its first line with anything in it says so.
pub(super) fn is_one(text: &str) -> bool {
    lines(text).find(|(_, line)| !line.trim().is_empty()).is_some_and(|(_, line)| frame(line).is_ok())
}

/// The poses of one run, by set and index.
struct Run {
    id: u16,
    poses: BTreeMap<(bool, u8), Pose>,
    board: BoardResult,
}

#[derive(Clone, Copy, Default)]
struct Pose {
    last_line: usize,
    lengths_mm: [Option<f32>; CABLES],
    samples: Option<u16>,
}

/// Reads a recording.
///
/// # Errors
/// [`InputError`] for a line that is no frame, and for a recording without a whole pose.
pub(super) fn parse(file: &str, text: &Text) -> Result<LengthsFile, InputError> {
    let mut log = LengthsFile::new(file);
    log.columns.push(Columns { from_line: 1, of_cable: [0; CABLES] });
    let (mut runs, mut frames, mut ours) = (Vec::<Run>::new(), 0_usize, 0_usize);
    let mut all = lines(&text.content).filter(|(_, line)| !line.trim().is_empty()).peekable();
    let mut last = 1;
    let mut prior_mm = 0.0;
    while let Some((line, content)) = all.next() {
        last = line;
        match frame(content) {
            Ok(Some(frame)) => {
                frames += 1;
                ours += usize::from(BaseId::DEFAULT.owns(frame.raw_id()));
                prior_mm = offset_prior_mm(&frame).unwrap_or(prior_mm);
                match (Message::unpack(&frame, BaseId::DEFAULT), runs.last_mut()) {
                    (Ok(Message::RawLength(length)), _) => take(&mut runs, line, &length, prior_mm),
                    (Ok(Message::PoseSamples(of)), Some(run)) if run.id == of.run_id => {
                        run.poses.entry((of.set == PoseSet::HeldOut, of.index)).or_default().samples = Some(of.samples);
                    }
                    (Ok(message), Some(run)) => run.board.take(run.id, &message),
                    _ => {}
                }
            }
            Ok(None) => frames += 1,
            // A recording that was stopped in the middle of its last line.
            Err(_) if all.peek().is_none() => log.notes.push(format!("the last line ({line}) is cut and left out")),
            Err(column) => return Err(InputError::at(file, line, column, "this is no frame as candump writes it")),
        }
    }
    runs.retain(|run| run.poses.values().any(Pose::is_whole));
    let Some(run) = runs.last() else {
        let base = BaseId::DEFAULT.command().as_raw();
        let message = match ours {
            0 => format!(
                "{frames} frames, but none with an identifier of the board ({base:03X} to {:03X})",
                base + BLOCK - 1
            ),
            _ => format!(
                "{ours} frames of the board, but no pose with all six lengths: record during the calibration, or read \
                 the poses out afterwards"
            ),
        };
        return Err(InputError::at(file, last, 1, message));
    };
    log.notes.push(told(&runs, run));
    log.board = Some(run.board);
    for ((held_out, index), pose) in &run.poses {
        match pose.whole() {
            Some(row) if *held_out => log.second_set.push(row),
            Some(row) => log.rows.push(row),
            None => log.notes.push(format!(
                "pose {index} of set {} is left out: not all six lengths were recorded (line {})",
                u8::from(*held_out) + 1,
                pose.last_line
            )),
        }
    }
    log.notes.extend(lost(&run.poses));
    if log.rows.is_empty() {
        return Err(InputError::at(file, last, 1, "no pose of the first set has all six lengths"));
    }
    Ok(log)
}

/// Poses of which no length was recorded although later ones were.
fn lost(poses: &BTreeMap<(bool, u8), Pose>) -> impl Iterator<Item = String> {
    [false, true].into_iter().flat_map(move |held_out| {
        let last = poses.keys().filter(|key| key.0 == held_out).map(|key| key.1).max().unwrap_or(0);
        (0..last).filter(move |index| !poses.contains_key(&(held_out, *index))).map(move |index| {
            format!("pose {index} of set {} is left out: no length of it was recorded", u8::from(held_out) + 1)
        })
    })
}

impl Pose {
    fn is_whole(&self) -> bool {
        self.lengths_mm.iter().all(Option::is_some)
    }

    /// The row, if all six lengths are there and can be lengths.
    fn whole(&self) -> Option<Row> {
        let mut lengths_mm = [0.0; CABLES];
        for (row, length) in lengths_mm.iter_mut().zip(self.lengths_mm) {
            *row = f64::from(length.filter(|mm| *mm > 0.0)?);
        }
        Some(Row { line: self.last_line, lengths_mm, samples: self.samples.unwrap_or(1) })
    }
}

/// Keeps a length. One that contradicts what was kept belongs to another run, even under the same number: a board that
/// was reset may begin its numbers again.
fn take(runs: &mut Vec<Run>, line: usize, length: &RawLength, offset_prior_mm: f64) {
    let Some(cable) = usize::from(length.cable).checked_sub(1).filter(|cable| *cable < CABLES) else { return };
    let key = (length.set == PoseSet::HeldOut, length.index);
    let known = |run: &Run| run.poses.get(&key).and_then(|pose| pose.lengths_mm[cable]);
    let same_run = runs.last().is_some_and(|run| {
        run.id == length.run_id && known(run).is_none_or(|mm| mm.to_bits() == length.length_mm.to_bits())
    });
    if !same_run {
        let board = BoardResult::new(offset_prior_mm);
        runs.push(Run { id: length.run_id, poses: BTreeMap::new(), board });
    }
    if let Some(run) = runs.last_mut() {
        let pose = run.poses.entry(key).or_default();
        pose.lengths_mm[cable] = Some(length.length_mm);
        pose.last_line = line;
    }
}

fn told(runs: &[Run], run: &Run) -> String {
    let count = |held_out: bool| run.poses.iter().filter(|(key, pose)| key.0 == held_out && pose.is_whole()).count();
    let others = match runs.len() {
        1 => String::new(),
        number => format!(", the last of {number} runs"),
    };
    format!(
        "a candump recording: run {}{others}, {} poses, and {} held out to verify them",
        run.id,
        count(false),
        count(true)
    )
}

/// The frame in a line: None for one that cannot be the board's (extended, remote, FD, error). Err is the column, from
/// 1, where it stops being a frame.
fn frame(line: &str) -> Result<Option<Frame>, usize> {
    let column = |rest: &str| line.chars().count() - rest.chars().count() + 1;
    let mut rest = line.trim_start();
    if let Some(timed) = rest.strip_prefix('(') {
        let (time, after) = timed.split_once(')').ok_or(column(rest))?;
        if time.is_empty() || !time.chars().all(|c| c.is_ascii_digit() || ".-: ".contains(c)) {
            return Err(column(rest));
        }
        rest = after.trim_start();
    }
    let (_interface, after) = rest.split_once(char::is_whitespace).ok_or(column(rest))?;
    let after = after.trim();
    let digits = after.find(|c: char| !c.is_ascii_hexdigit()).unwrap_or(after.len());
    let (id, data) = after.split_at(digits);
    let raw = u32::from_str_radix(id, 16).map_err(|_| column(after))?;
    let standard = id.len() == 3;
    if !standard && id.len() != 8 {
        return Err(column(after));
    }
    let bytes = if let Some(data) = data.strip_prefix("##") {
        return if data.chars().all(|c| c.is_ascii_hexdigit()) { Ok(None) } else { Err(column(data)) };
    } else if let Some(data) = data.strip_prefix('#') {
        // candump -l; an extra column tells whether the frame was sent or received
        let data = data.split_whitespace().next().unwrap_or("");
        if data.starts_with(['R', 'r']) {
            return Ok(None);
        }
        hexadecimal(data).ok_or_else(|| column(after))?
    } else {
        let (len, data) = data.trim_start().strip_prefix('[').and_then(|d| d.split_once(']')).ok_or(column(data))?;
        if data.contains("remote") || data.contains("ERRORFRAME") {
            return Ok(None);
        }
        // candump -a shows the bytes as text behind them
        let data = data.split_once('\'').map_or(data, |(data, _)| data);
        let bytes = hexadecimal(&data.replace(' ', "")).ok_or(column(data))?;
        if len.trim().parse() != Ok(bytes.len()) {
            return Err(column(data));
        }
        bytes
    };
    match u16::try_from(raw) {
        Ok(id) if standard && bytes.len() <= 8 => Frame::new(id, &bytes).map(Some).map_err(|_| column(after)),
        _ => Ok(None),
    }
}

/// Pairs of hexadecimal digits as bytes.
fn hexadecimal(digits: &str) -> Option<Vec<u8>> {
    let (pairs, rest) = digits.as_bytes().as_chunks::<2>();
    let digit = |byte: u8| char::from(byte).to_digit(16).and_then(|digit| u8::try_from(digit).ok());
    let bytes = pairs.iter().map(|[high, low]| Some(digit(*high)? << 4 | digit(*low)?)).collect::<Option<Vec<u8>>>()?;
    rest.is_empty().then_some(bytes)
}
