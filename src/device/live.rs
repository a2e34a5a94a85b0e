//! The centre in use as others see it: which one, whose, and whether it may be used.

use super::slip_monitor::SlipMonitor;
use super::{Action, Device, shown};
use crate::can::identity::Naming;
use crate::can::live_set::{Estimate, LiveSet, Standing};
use crate::procedure::elbow::ElbowCandidate;
use crate::procedure::module::FoundJoint;
use crate::procedure::{Candidate, Reason};
use crate::record::JournalEntry;

impl Device {
    /// May the centre in use be used, and if not, why.
    pub(super) fn standing(&self) -> (Standing, Reason) {
        match (self.procedure.live(), self.distrust) {
            (None, _) => (Standing::NoCentre, Reason::Fine),
            (Some(_), Some(reason)) => (Standing::NotToBeUsed, reason),
            (Some(_), None) if !self.confirmed => (Standing::Unconfirmed, Reason::Unconfirmed),
            (Some(_), None) => (Standing::Confirmed, Reason::Fine),
        }
    }

    /// Somebody says that the centre in use is right for the arm that is in the machine now.
    pub(super) fn confirm(&mut self, out: &mut impl FnMut(Action)) -> Reason {
        self.trust(None, out);
        self.confirmed = true;
        self.slip_monitor = SlipMonitor::to_be_built();
        Reason::Fine
    }

    /// Notes, for restarts too, why the centre in use is not to be used; None when nothing speaks against it.
    pub(super) fn trust(&mut self, distrust: Option<Reason>, out: &mut impl FnMut(Action)) {
        if self.distrust != distrust {
            self.distrust = distrust;
            self.journal(out);
        }
    }

    /// Has the board note where it stands, so that boot and run never repeat and a distrust outlives a restart.
    pub(super) fn journal(&mut self, out: &mut impl FnMut(Action)) {
        out(Action::Journal(JournalEntry {
            boot: self.boot,
            run_id: self.procedure.run_id(),
            distrust: self.distrust.map_or(0, Reason::code),
        }));
    }

    /// What names the new centre that waits for a decision; None before it was shown.
    pub(super) fn shown_candidate(&self) -> Option<Naming> {
        let candidate = self.procedure.candidate()?;
        self.reporter.naming_of_candidate(&candidate)
    }

    /// What names the centre in use.
    pub(super) fn shown_live(&self) -> Option<Naming> {
        let live = self.procedure.live()?;
        // Formed at once only where it was never shown since power-up.
        self.reporter.naming_of_live(&live).or_else(|| shown::naming(&live))
    }

    /// Everything that a controller acts on.
    pub fn live_set(&self) -> LiveSet {
        let (standing, reason) = self.standing();
        let identity = LiveSet {
            standing,
            reason: reason.code(),
            serial: self.serial,
            rig: self.versions.rig,
            ..LiveSet::default()
        };
        let Some(live) = self.procedure.live() else { return identity };
        let Candidate { identified, motion, .. } = match live {
            FoundJoint::Ball(live) => live,
            FoundJoint::Hinge(live) => return self.live_hinge(identity, live),
        };
        let (values, sigmas) = (identified.parameters.to_array(), identified.sigma_mm());
        let estimates = values.iter().zip(sigmas);
        let mut parameters = [Estimate::default(); 6];
        for (estimate, (value_mm, sigma_mm)) in parameters.iter_mut().zip(estimates) {
            *estimate = Estimate { value_mm: *value_mm, sigma_mm };
        }
        let mut offsets = [Estimate::default(); 6];
        let found = identified.offsets_mm.iter().zip(&identified.offset_sigmas_mm);
        for (estimate, (value_mm, sigma_mm)) in offsets.iter_mut().zip(found) {
            *estimate = Estimate { value_mm: *value_mm, sigma_mm: *sigma_mm };
        }
        LiveSet {
            moves: motion.is_some(),
            wearer: live.wearer(),
            boot: live.boot(),
            run_id: live.run_id(),
            parameters,
            offsets,
            ..identity
        }
    }

    /// The same of a hinge.
    fn live_hinge(&self, identity: LiveSet, live: &ElbowCandidate) -> LiveSet {
        let estimate = |[value_mm, sigma_mm]: [f32; 2]| Estimate { value_mm, sigma_mm };
        let ElbowCandidate { run_id, boot, wearer, found, .. } = live;
        LiveSet {
            hinge: true,
            wearer: *wearer,
            boot: *boot,
            run_id: *run_id,
            parameters: core::array::from_fn(|k| {
                estimate(if k < 3 { found.number(k) } else { found.common_point(k - 3) })
            }),
            offsets: core::array::from_fn(|k| estimate(found.number(k + 6))),
            ..identity
        }
    }
}
