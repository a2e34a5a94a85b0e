//! The evidence of a suspicious stretch of an elbow's motion, fitted with each possible cause.

use super::warning::{Cause, Explanation, Squares, Warning, best_cable};
use crate::identification::hinge::{HINGE_UNKNOWNS, Hinge, HingeSample, MAX_CABLES, across, is_direction};
use crate::linear_algebra::{NormalEquations, dot};
use crate::scalar::Real;

/// How far a slip turns an axis at the most, rad, and moves it, mm, 1σ: what the motion so far does not determine stays
/// within that.
const USUAL_TURN: f64 = 0.1;
const USUAL_MOVE_MM: f64 = 10.0;

/// χ² by which one slip must explain more than the other to be named: 5 σ.
const APART: f64 = 25.0;

/// Unknowns of a hinge that change when the base slips: axis and foot point in the base, and along the axis; and when the
/// cuff does.
const OF_STRAP: [usize; 5] = [0, 1, 2, 3, 8];
const OF_CUFF: [usize; 5] = [4, 5, 6, 7, 8];

/// Sums over the samples of a stretch of motion.
#[derive(Clone, Debug)]
pub(super) struct HingeEvidence<T> {
    cables: usize,
    squares: Squares<T>,
    hinge: NormalEquations<T, HINGE_UNKNOWNS, 45>,
    /// Weight and gradient of each cable's own error.
    of_cables: [(T, T); MAX_CABLES],
}

impl<T: Real> HingeEvidence<T> {
    /// None, of a rig with so many cables.
    pub fn none(cables: usize) -> Self {
        Self {
            cables,
            squares: Squares::none(cables.saturating_sub(1).max(1) as i32),
            hinge: NormalEquations::new(HINGE_UNKNOWNS),
            of_cables: [(T::zero(), T::zero()); MAX_CABLES],
        }
    }

    /// Back to none.
    pub fn clear(&mut self) {
        self.squares = Squares::none(self.spare());
        self.hinge.clear(HINGE_UNKNOWNS);
        self.of_cables = [(T::zero(), T::zero()); MAX_CABLES];
    }

    /// Lengths to spare in a sample.
    pub fn spare(&self) -> i32 {
        self.squares.spare()
    }

    /// Samples added.
    pub fn samples(&self) -> u16 {
        self.squares.samples()
    }

    /// Do more samples tell one cause from another? Two or three cables leave too little to spare.
    pub fn tells_apart(&self) -> bool {
        self.cables == MAX_CABLES
    }

    /// Adds a sample, its angle eliminated.
    pub fn add(&mut self, sample: &HingeSample<T>) {
        self.squares.add(sample.squares_mm2());
        for (row, residual) in sample.by_hinge.iter().zip(&sample.residual_mm).take(self.cables) {
            self.hinge.add_row(row, *residual);
        }
        let of_sample = sample.left_of_cable.iter().zip(&sample.residual_mm);
        for ((weight, gradient), (left, residual)) in self.of_cables.iter_mut().zip(of_sample).take(self.cables) {
            *weight += *left;
            *gradient += *residual;
        }
    }

    /// A slip of the base: how far the axis' foot point moved in {B}.
    pub fn strap(&self, hinge: &Hinge<T>, variance_mm2: T) -> Explanation<T> {
        let ([.., x, y, along], explained) = self.slip(OF_STRAP, variance_mm2)?;
        let [e1, e2] = across(hinge.axis());
        Some((Cause::StrapSlipped(e1 * x + e2 * y + hinge.axis() * along), explained, OF_STRAP.len() as i32))
    }

    /// A slip of the cuff: how far the axis' foot point moved in {P}.
    pub fn cuff(&self, hinge: &Hinge<T>, variance_mm2: T) -> Explanation<T> {
        let ([.., x, y, along], explained) = self.slip(OF_CUFF, variance_mm2)?;
        let axis = hinge.axis_in_platform();
        let [f1, f2] = across(&axis);
        Some((Cause::CuffSlipped(f1 * x + f2 * y - axis * along), explained, OF_CUFF.len() as i32))
    }

    /// The change of some of the unknowns that fits best, and the squares that it explains, mm².
    fn slip(&self, unknowns: [usize; 5], variance_mm2: T) -> Option<([T; 5], T)> {
        // Of the size that the ball's evidence has: one copy of the code for both.
        let mut equations = NormalEquations::<T, 6, 21>::new(unknowns.len());
        for (i, k) in unknowns.into_iter().enumerate() {
            for (j, l) in unknowns.into_iter().enumerate().take(i + 1) {
                equations.add_to_entry(i, j, self.hinge.entry(k, l));
            }
            let usual = T::of(if is_direction(k) { USUAL_TURN } else { USUAL_MOVE_MM });
            equations.add_to_entry(i, i, variance_mm2 / (usual * usual));
            equations.add_to_gradient(i, self.hinge.gradient().get(k).copied().unwrap_or_else(T::zero));
        }
        equations.factor().ok()?;
        let step = equations.step();
        let [a, b, c, d, e, _] = step;
        Some(([a, b, c, d, e], dot(&step, equations.gradient())))
    }

    /// The cause that explains the evidence; `None` when there is nothing to explain. `slips`: of base and cuff.
    pub fn judge(&self, variance_mm2: T, suspicious: T, usual: T, slips: [Explanation<T>; 2]) -> Option<Warning<T>> {
        let causes = [best_cable(&self.of_cables), better(slips, variance_mm2)];
        let told_apart = if self.tells_apart() { causes.as_slice() } else { &[] };
        self.squares.judge(variance_mm2, suspicious, usual, told_apart)
    }
}

/// The better one of two explanations with as many unknowns; `None` when the evidence does not tell them apart.
fn better<T: Real>([one, other]: [Explanation<T>; 2], variance_mm2: T) -> Explanation<T> {
    let ((_, of_one, _), (_, of_other, _)) = (one?, other?);
    if (of_one - of_other).abs() < variance_mm2 * T::of(APART) {
        return None;
    }
    if of_one > of_other { one } else { other }
}
