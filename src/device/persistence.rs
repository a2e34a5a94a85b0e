//! The centre in use across power-down: from the record at power-up, to the record when a new one is accepted; and a
//! seal on it in between, since a centre that changes in memory is a wrong one.

use super::kept;
use super::seal::{seal, seal_of};
use super::slip_monitor::SlipMonitor;
use super::{Action, Device, LogEntry};
use crate::procedure::Reason;
use crate::record::{JointRecord, LoadError, Loaded, StoreError};
use crate::restart::ResetCause;

/// What is wrong with the record, None when all is well.
///
/// A store that failed leaves the centre in use, but only until power-down; a record that was refused leaves none.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Persistence {
    pub wrong: Option<Reason>,
    /// Checksum of the centre in use; None while there is none.
    seal: Option<u32>,
}

impl Device {
    /// The board has looked into its flash. A centre that it finds there is not confirmed yet: yesterday's strap is not
    /// today's.
    pub(super) fn power_up(&mut self, loaded: Loaded, out: &mut impl FnMut(Action)) {
        self.parameters_wrong = loaded.parameters.is_some();
        let journal = loaded.journal.unwrap_or_default();
        let last_run_id = match (loaded.journal, &loaded.record) {
            (None, Ok(record)) => record.run_id(),
            _ => journal.run_id,
        };
        self.boot = journal.boot.wrapping_add(1);
        // modulo 2^16
        self.procedure.resume_at(self.boot as u16, last_run_id);
        self.distrust = Reason::from_code(journal.distrust).filter(|reason| *reason != Reason::Fine);
        self.journal(out);
        let reason = match loaded.record {
            Ok(record) if record.rig() != self.fingerprint => Reason::RecordOfOtherRig,
            Ok(record) => {
                let resumed = match &record {
                    JointRecord::Ball(record) => self.procedure.resume_ball(kept::candidate(record)),
                    JointRecord::Hinge(record) => self.procedure.resume_hinge(kept::hinge_candidate(record)),
                };
                resumed.err().unwrap_or(Reason::Fine)
            }
            Err(error) => reason_of_load(error),
        };
        self.seal_live();
        self.slip_monitor = SlipMonitor::to_be_built();
        self.persistence.wrong = Some(reason).filter(|reason| *reason != Reason::Fine);
        out(Action::Log(LogEntry::Loaded { run_id: self.procedure.run_id(), reason }));
    }

    /// From now on the centre in use is looked at.
    pub(super) fn seal_live(&mut self) {
        self.persistence.seal = self.live_checksum();
    }

    /// Hands the new centre in use to the board, to be stored.
    pub(super) fn keep(&self, out: &mut impl FnMut(Action)) {
        if let Some(live) = self.procedure.live() {
            out(Action::Store(kept::record(&live, self.serial, self.fingerprint)));
        }
    }

    /// Looks whether the centre in use, and what it is judged by, is still what was taken into use. If not, memory cannot be
    /// trusted: the board starts anew, from the record.
    pub(super) fn check_live(&self, out: &mut impl FnMut(Action)) {
        if self.persistence.seal != self.live_checksum() || self.constants != seal_of(&self.procedure) {
            out(Action::Stop(ResetCause::MemoryError));
        }
    }

    fn live_checksum(&self) -> Option<u32> {
        self.procedure.live().map(|live| seal(&live, self.serial, self.fingerprint))
    }

    /// The board has tried to store.
    pub(super) fn stored(&mut self, result: Result<(), StoreError>, out: &mut impl FnMut(Action)) {
        let reason = result.map_or_else(reason_of_store, |()| Reason::Fine);
        self.persistence.wrong = result.err().map(reason_of_store);
        out(Action::Log(LogEntry::Stored { run_id: self.procedure.run_id(), reason }));
    }
}

fn reason_of_load(error: LoadError) -> Reason {
    match error {
        // so it is on a new board
        LoadError::Nothing => Reason::Fine,
        LoadError::Unreadable => Reason::RecordUnreadable,
        LoadError::Damaged => Reason::RecordDamaged,
        LoadError::OlderVersion => Reason::RecordOlder,
        LoadError::FromTheFuture => Reason::RecordNewer,
        LoadError::OtherRig => Reason::RecordOfOtherRig,
        LoadError::Unfit => Reason::RecordUnfit,
        LoadError::FlashLayout => Reason::FlashLayout,
    }
}

pub(super) fn reason_of_store(error: StoreError) -> Reason {
    match error {
        StoreError::Unfit => Reason::RecordUnfit,
        StoreError::EraseRefused | StoreError::WriteRefused => Reason::StoreRefused,
        StoreError::EraseIncomplete | StoreError::ReadBackDiffers => Reason::FlashWorn,
        StoreError::FlashLayout => Reason::FlashLayout,
    }
}

#[cfg(test)]
mod tests {
    use super::kept::{candidate, record_of_ball as record};
    use super::*;
    use crate::identification::joint::ShownMotion;
    use crate::identification::machine::MachineDeviation;
    use crate::identification::{Identified, Rejected, Termination};
    use crate::procedure::{Candidate, Limits, Settings, Verification};
    use crate::rig::{Parameters, Rig};
    use heapless::Vec;

    /// Every field has a value of its own, so that none can be taken for another.
    fn live() -> Candidate {
        Candidate {
            run_id: 1,
            boot: 40,
            wearer: 41,
            identified: Identified {
                parameters: Parameters::from_array([2.0, 3.0, 4.0, 5.0, 6.0, 7.0]),
                covariance_mm2: core::array::from_fn(|k| 100.0 + k as f32),
                noise_mm: 8.0,
                rms_residual_mm: 9.0,
                rms_residuals_mm: Vec::new(),
                iterations: 10,
                termination: Termination::Settled,
                poses: 11,
                rejected: Vec::from_slice(&[Rejected { pose: 12, cables: 13 }, Rejected { pose: 14, cables: 15 }])
                    .unwrap(),
                excitation_rad: 16.0,
                offsets_mm: [20.0, 21.0, 22.0, 23.0, 24.0, 25.0],
                offset_sigmas_mm: [30.0, 31.0, 32.0, 33.0, 34.0, 35.0],
                machine: MachineDeviation {
                    base_mm: core::array::from_fn(|k| 50.0 + k as f32),
                    ends_mm: core::array::from_fn(|k| 70.0 + k as f32),
                    scale: core::array::from_fn(|k| 90.0 + k as f32),
                },
            },
            motion: Some(ShownMotion::from_parts(core::array::from_fn(|k| {
                [k as i16 + 50, k as i16 + 60, k as i16 + 70]
            }))),
            verification: Verification { deviation_mm: 17.0, limit_mm: 18.0, poses: 19 },
        }
    }

    /// The same, as it could be on the shoulder.
    fn plausible() -> Candidate {
        let mut live = live();
        live.identified.parameters = Parameters::from_array([2.0, 3.0, 148.0, 140.0, 141.0, 142.0]);
        live.identified.covariance_mm2 = core::array::from_fn(|k| 0.01 + 1e-3 * k as f32);
        live
    }

    /// One bit of any number of the centre in use, and the board has to start anew.
    #[test]
    fn a_centre_that_changes_in_memory_is_noticed() {
        let rig = crate::rig::Rig::shoulder(150.0).unwrap();
        let mut device = Device::new(&crate::device::Config::for_rig(rig));
        let stops = |device: &mut Device| {
            let mut stops = 0;
            for now_ms in 0..200 {
                device.handle(now_ms, crate::device::Event::Tick, &mut |action| {
                    stops += u32::from(action == Action::Stop(ResetCause::MemoryError));
                });
            }
            stops
        };
        assert_eq!(stops(&mut device), 0, "without a centre");
        let loaded = Ok(record(&plausible(), 0, device.fingerprint));
        device.handle(0, crate::device::Event::PowerUp(loaded.into()), &mut |_| {});
        assert_eq!(stops(&mut device), 0, "with a sound one");
        let spoilt: [fn(&mut Candidate); 5] = [
            |live| live.motion = None,
            |live| {
                live.identified.parameters.centre_mm.x =
                    f32::from_bits(live.identified.parameters.centre_mm.x.to_bits() ^ 1)
            },
            |live| live.identified.parameters.radii_mm[2] = -live.identified.parameters.radii_mm[2],
            |live| live.identified.covariance_mm2[20] = 0.0,
            |live| live.run_id ^= 0x8000,
        ];
        for spoil in spoilt {
            let mut spoilt = device.clone();
            spoil(spoilt.procedure.ball_mut().unwrap().live_mut().as_mut().unwrap());
            assert!(stops(&mut spoilt) > 0);
        }
        *device.procedure.ball_mut().unwrap().live_mut() = None;
        assert!(stops(&mut device) > 0, "a centre that vanishes");
    }

    /// The same of what the procedure goes by, whether there is a centre or not.
    #[test]
    fn a_rig_and_limits_that_change_in_memory_are_noticed() {
        let rig = Rig::shoulder(150.0).unwrap();
        let device = Device::new(&crate::device::Config::for_rig(rig));
        let limits = |settings| Limits::new(&rig, settings).unwrap();
        let settings = Settings::for_rig(&rig);
        let noisier = rig.with_noise(rig.length_noise_mm(), 0.01).unwrap();
        let spoilt = [
            (rig, limits(settings), false),
            (Rig::shoulder(150.001).unwrap(), limits(settings), true),
            (noisier, limits(settings), true),
            (rig, limits(Settings { review_timeout_ms: settings.review_timeout_ms ^ 1, ..settings }), true),
            (rig, limits(Settings { capture_in_motion: true, ..settings }), true),
            (rig, Limits::new(&noisier, settings).unwrap(), false),
            (rig, Limits::new(&Rig::wrist().unwrap(), settings).unwrap(), true),
        ];
        for (case, (rig, limits, is_noticed)) in spoilt.into_iter().enumerate() {
            let mut device = device.clone();
            device.procedure.ball_mut().unwrap().spoil_constants(rig, limits);
            let mut is_stopped = false;
            for now_ms in 0..200 {
                device.handle(now_ms, crate::device::Event::Tick, &mut |action| {
                    is_stopped |= action == Action::Stop(ResetCause::MemoryError);
                });
            }
            assert_eq!(is_stopped, is_noticed, "case {case}");
        }
    }

    #[test]
    fn a_centre_comes_back_as_it_was_kept() {
        assert_eq!(candidate(&record(&live(), 8, 7)), live());
        assert_eq!(record(&live(), 8, 7).rig, 7);
        assert_eq!(record(&live(), 8, 7).check(), Ok(()));
    }
}
