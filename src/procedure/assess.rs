//! What a captured pose promises: predicted a slice a tick, then reported with the pose.

use super::Procedure;
use super::outcome::PoseNotice;
use super::reason::Reason;
use super::state::PoseSet;

/// So many poses more would have to gain a tenth, or there are enough.
const MORE_POSES: usize = 10;

/// The pose of the first set that was captured last, while its accuracy is being predicted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Assessing {
    notice: PoseNotice,
    /// It was not captured by command.
    is_automatic: bool,
}

impl Procedure {
    /// The notice of a pose that can be sent at once; `None` for one that is to be assessed before.
    pub(super) fn assessed(&mut self, notice: PoseNotice, is_automatic: bool) -> Option<PoseNotice> {
        let is_assessed_first = notice.reason == Reason::Fine && notice.set == PoseSet::Identification;
        if is_assessed_first && let Some(pose) = self.poses.poses().last() {
            self.accuracy.begin(pose);
            self.assessing = Some(Assessing { notice, is_automatic });
        }
        (!is_assessed_first).then_some(notice)
    }

    /// The next slice of the prediction; after the last the notice of the pose, and whether it was captured automatically.
    /// The estimator has nothing to do meanwhile, so that its workspace serves.
    pub(super) fn assess(&mut self) -> Option<(PoseNotice, bool)> {
        let Assessing { notice, is_automatic } = self.assessing?;
        // No other is captured meanwhile.
        let pose = self.poses.poses().last()?;
        let prediction = self.accuracy.advance(&self.machine, pose, MORE_POSES, self.work.workspace())?;
        self.predicted_sigma_mm = prediction.now.map(|predicted| predicted.sigma_mm);
        self.sigma_with_more_mm = prediction.sigma_with_more_mm;
        self.assessing = None;
        Some((PoseNotice { sigma_mm: self.predicted_sigma_mm, ..notice }, is_automatic))
    }
}
