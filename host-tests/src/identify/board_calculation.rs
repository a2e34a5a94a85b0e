//! The board's own calculation once more, from the lengths that it sent: is it to the last digit what the board showed?

use super::lengths_file::{BoardResult, LengthsFile};
use super::rig_file;
use crate::rehearse::{KnownMachine, replay};
use glenoid::can::result::Parameter;
use glenoid::rig::{CABLES, Rig};

/// What to say of a recording that holds the board's own result; None when it does not.
pub fn note(log: &LengthsFile, rig: &Rig<f64>) -> Option<String> {
    let BoardResult { offset_prior_mm, .. } = *log.board()?;
    let board = log.board()?.parameters()?;
    let found = format!("the board found {} in run {}", centre(&board), board[0].run_id);
    // the lengths came as single-precision numbers
    let taken: Vec<([f32; CABLES], u16)> =
        log.rows().iter().map(|row| (row.lengths_mm.map(|mm| mm as f32), row.samples)).collect();
    // the compiled-in machine as the board makes it from its parameters, to the last digit
    let rig = match KnownMachine::compiled_in() {
        Ok(known) if known.double == *rig => known.single,
        _ => rig_file::in_precision::<f32>(rig).ok()?,
    };
    Some(match replay::identify::<f32>(&rig, &taken, offset_prior_mm) {
        Err(refusal) => {
            format!("{found}; from these poses its calculation is refused here ({}): {WHY}", refusal.text())
        }
        Ok(again) => match replay::difference_mm(&board, &again.parameters) {
            0.0 => format!("{found}; its calculation gives the same here, to the last digit"),
            off_mm => format!("{found}; its calculation is up to {off_mm:.6} mm off that here: {WHY}"),
        },
    })
}

const WHY: &str = "it goes by other parameters (give --rig), or poses are missing from the recording";

fn centre([x, y, z, ..]: &[Parameter; 6]) -> String {
    format!("{} {} {} mm", x.value_mm, y.value_mm, z.value_mm)
}
