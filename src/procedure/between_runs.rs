//! What holds from run to run: the boot, the wearer, the centre of before a power-down, how well the encoder offsets are known.

use super::{Candidate, Procedure, Reason, StateName};

impl Procedure {
    /// Goes on after a power-down: in which boot, and from which run id on. Nothing has happened yet since power-up.
    pub fn resume_at(&mut self, boot: u16, last_run_id: u16) {
        self.calibration.resume_at(boot, last_run_id);
    }

    /// Takes over the centre of an earlier run, of before the power was switched off.
    ///
    /// # Errors
    /// What about it cannot be; there is no centre in use then.
    pub fn resume(&mut self, live: Candidate) -> Result<(), Reason> {
        self.check_plausible(&live.identified).map_err(|detail| detail.reason)?;
        if self.state() == StateName::Idle {
            self.live = Some(live);
        }
        Ok(())
    }

    /// Sets whose arm the runs to come are made for; 0 = not said. Not while a run is under way.
    pub fn set_wearer(&mut self, wearer: u16) -> Reason {
        self.calibration.set_wearer(wearer)
    }

    /// Whose arm the runs to come, or the one under way, are made for.
    pub const fn wearer(&self) -> u16 {
        self.calibration.wearer
    }

    /// The boot that is under way.
    pub const fn boot(&self) -> u16 {
        self.calibration.boot
    }

    /// How well the encoder zeros are known in the runs to come, 1σ, mm; 0 = as the rig's tolerance says.
    pub const fn zero_prior_mm(&self) -> f32 {
        self.zero_prior_mm
    }

    /// Sets how well the encoder zeros are known in the runs to come, 1σ, mm, until power-down; 0 = as the
    /// rig's tolerance says. Not while a run is under way: its poses were collected for another question.
    ///
    /// Every run begins from the raw lengths, never from lengths corrected by the zeros in use: an error in these cannot
    /// get into the next centre, and the standard deviation of a run depends on its own poses and the stated prior alone.
    pub fn set_zero_prior(&mut self, prior_mm: f32) -> Reason {
        if !self.calibration.is_between_runs() {
            return Reason::AlreadyRunning;
        }
        if !(prior_mm >= 0.0 && prior_mm.is_finite()) {
            return Reason::BadArgument;
        }
        self.zero_prior_mm = prior_mm;
        self.machine.set_offset_prior(self.rig.offset_prior_mm(prior_mm));
        Reason::Fine
    }
}
