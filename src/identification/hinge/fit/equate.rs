//! The normal equations at the present estimate, pose by pose, a part of a pose a slice.

use super::Fit;
use crate::identification::hinge::joint::HINGE_UNKNOWNS;
use crate::identification::hinge::pose::{HingePose, PoseAt, PoseRows};
use crate::identification::hinge::rig::MAX_CABLES;
use crate::scalar::Real;

/// Priors of the drawing that a slice adds.
const PRIORS_A_SLICE: usize = 3;

/// The sum under way.
#[derive(Clone, Copy, Debug)]
pub struct Equate {
    /// The pose that is worked on.
    pose: usize,
    part: Part,
}

/// What comes next of a pose. Rows are counted from 0.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// There are no equations yet.
    Begin,
    /// Its rows from this one on.
    Make(usize),
    /// The angle's elimination from them.
    Eliminate,
    /// They are added, from this one on.
    Add(usize),
    /// The drawing's priors, from this one on.
    Priors(usize),
    /// The priors of the machine's constants.
    Constants,
}

impl Equate {
    /// Before the first pose.
    pub const fn new() -> Self {
        Self { pose: 0, part: Part::Begin }
    }

    /// One slice; true at the end.
    pub fn advance<T: Real>(&mut self, fit: &mut Fit<T>, rows: &mut PoseRows<T>, poses: &[HingePose<T>]) -> bool {
        // A row of 33 unknowns takes as long as ten of 9.
        let a_slice = if fit.constants { 1 } else { MAX_CABLES };
        let pose = poses.get(self.pose);
        self.part = match (self.part, pose) {
            (Part::Constants, _) => {
                fit.add_priors_of_constants();
                return true;
            }
            (Part::Priors(from), _) => {
                fit.add_priors(from..from + PRIORS_A_SLICE);
                let next = from + PRIORS_A_SLICE;
                if next < HINGE_UNKNOWNS { Part::Priors(next) } else { Part::Constants }
            }
            (_, None) => Part::Priors(0),
            (Part::Begin, _) => {
                fit.equations.clear(fit.unknowns());
                Part::Make(0)
            }
            (Part::Make(_), Some(pose)) if !pose.is_used() => {
                self.pose += 1;
                Part::Make(0)
            }
            (Part::Make(from), Some(pose)) => {
                let at = PoseAt::new(&fit.hinge, &fit.machine);
                rows.set(&at, &pose.lengths_mm, pose.angle_rad, fit.constants, from..from + a_slice);
                if from + a_slice < MAX_CABLES { Part::Make(from + a_slice) } else { Part::Eliminate }
            }
            (Part::Eliminate, Some(pose)) => {
                let by_angle = rows.by_angle;
                rows.eliminate(&by_angle, fit.unknowns());
                rows.scale(pose.weight.root());
                Part::Add(0)
            }
            (Part::Add(from), _) => {
                let pairs = rows.jacobian.iter().zip(&rows.residual_mm).take(fit.machine.cables());
                pairs.skip(from).take(a_slice).for_each(|(row, residual)| fit.equations.add_row(row, *residual));
                if from + a_slice < MAX_CABLES {
                    Part::Add(from + a_slice)
                } else {
                    self.pose += 1;
                    Part::Make(0)
                }
            }
        };
        false
    }
}
