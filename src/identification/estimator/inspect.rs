//! The gates of a moving centre: a slip between two poses, a joint that the model does not explain, too little
//! accuracy.
//!
//! The slip is a test for a change between two poses (Chow 1960): the poses from one on may have another joint centre,
//! six more unknowns ΔO and ΔC. Backwards over the poses; by how much χ² would fall follows from sums over the poses
//! after the split and the factor of the normal equations, without a refit.

use super::Next;
use super::fit::Fit;
use super::result::Accepted;
use super::scratch::Scratch;
use super::seen_pose::SeenPose;
use crate::identification::joint::{Joint, persistence};
use crate::identification::machine::Machine;
use crate::identification::parameters::MAX_UNKNOWNS;
use crate::identification::pose::Pose;
use crate::identification::refusal::Refusal;
use crate::linear_algebra::{NormalEquations, column, dot, largest_eigenpair, non_negative_root};
use crate::scalar::Real;
use core::ops::Range;
use nalgebra::{Matrix3, Vector3};

/// Minimum number of poses on either side of a slip, and their minimum share (one in so many).
const MIN_SIDE: usize = 6;
const SIDE_SHARE: usize = 8;

/// Rows of the six a slice.
const SPLIT_ROWS_A_SLICE: usize = 3;

/// Limit of F with six unknowns. At 60 poses, 800 sound sets stayed below 5.8, and slips of 3 mm exceeded 56.
const SLIP_F: f64 = 9.0;

/// Largest RMS residual of the poses' own centres in its worst direction, and largest scatter along an axis, mm. Sound
/// shoulders left at most 0.77 mm; three of 400 joints that jump by 3 mm left less than 0.9 in 30 poses, none in 60 (chosen on
/// `cargo study shoulder --seed 111` to 120).
const MAX_RESIDUAL_MM: f64 = 0.9;
const MAX_SCATTER_MM: f64 = 0.8;

/// Largest predicted standard deviation of the centre over the set's own poses, mm: across the arm, and in all.
const MAX_SIGMA_ACROSS_MM: f64 = 3.0;
const MAX_SIGMA_MM: f64 = 6.0;

/// The split of the poses that lowers χ² most.
#[derive(Clone, Copy, Debug)]
struct Split<T> {
    pose: usize,
    gain: T,
    of_base: Vector3<T>,
    of_cuff: Vector3<T>,
}

/// The sums over the poses from `next` on.
#[derive(Clone, Debug)]
pub(super) struct Inspect<T: Real> {
    /// Poses still to come, from the last.
    next: usize,
    /// Used poses seen.
    seen: usize,
    /// Information and gradient of ΔO, ΔC.
    split: NormalEquations<T, 6, 21>,
    /// L⁻¹ times the mixed block with the other unknowns, with L the factor of their equations: a row each of ΔO, ΔC.
    shared: [[T; MAX_UNKNOWNS]; 6],
    best: Option<Split<T>>,
    /// Σ δ̂ δ̂ᵀ, mm².
    residual: Matrix3<T>,
    /// Σ of δ̂ of each pose and the next, mm²; δ̂ of the pose before in this order, mm.
    of_neighbours_mm2: T,
    previous_mm: Vector3<T>,
    /// Σ of the variance of the predicted centre across the arm and in all, mm².
    across_mm2: T,
    all_mm2: T,
    step: Step<T>,
}

/// Where a pose stands.
#[derive(Clone, Copy, Debug)]
enum Step<T> {
    /// The next one is to be looked at.
    See,
    /// Its equations go to work.
    Begin,
    /// Their columns.
    Columns,
    /// What its equations share with the constants and C is whitened. With S of the pose.
    Shared(Matrix3<T>),
    /// How the predicted centre depends on the unknowns goes to work.
    BeginPath(Matrix3<T>),
    /// It is whitened.
    Path(Matrix3<T>),
    /// Times S it is what the pose's equations share with the gains and O.
    SharedByPath(Matrix3<T>),
    /// The split before it: its equations without the other unknowns, up to this row.
    Split(NormalEquations<T, 6, 21>, usize),
}

impl<T: Real> Inspect<T> {
    /// Begins at the last pose.
    pub fn new(poses: &[Pose<T>]) -> Self {
        Self {
            next: poses.len(),
            seen: 0,
            split: NormalEquations::new(6),
            shared: [[T::zero(); MAX_UNKNOWNS]; 6],
            best: None,
            residual: Matrix3::zeros(),
            of_neighbours_mm2: T::zero(),
            previous_mm: Vector3::zeros(),
            across_mm2: T::zero(),
            all_mm2: T::zero(),
            step: Step::See,
        }
    }

    /// The next pose towards the first, a slice of it.
    pub fn advance(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, poses: &mut [Pose<T>]) -> Option<Next<T>> {
        self.step = match self.step {
            Step::See => {
                let Some(index) = self.next.checked_sub(1) else { return Some(self.judge(fit)) };
                self.next = index;
                let pose = poses.get(index).filter(|pose| pose.is_used())?;
                fit.see(machine, pose)?;
                self.seen += 1;
                Step::Begin
            }
            Step::Begin => {
                if let Scratch::Seen(seen) = &fit.scratch {
                    self.add(seen);
                }
                fit.put_to_work();
                Step::Columns
            }
            Step::Columns if !fit.add_columns(machine) => Step::Columns,
            Step::Columns => {
                // It is there: it went to work in the step before.
                let in_work = fit.scratch.pose()?;
                let (information, rows) = (*in_work.information(), in_work.sensitivity_beside_path());
                fit.scratch.put_rows(&rows);
                Step::Shared(information)
            }
            Step::Shared(information) if !fit.whiten() => Step::Shared(information),
            Step::Shared(information) => {
                let rotation = poses.get(self.next)?.rotation();
                self.add_shared(&rotation, &Matrix3::identity(), fit.scratch.rows());
                Step::BeginPath(information)
            }
            Step::BeginPath(information) => {
                let rows = fit.path_rows(&poses.get(self.next)?.rotation());
                fit.scratch.put_rows(&rows);
                Step::Path(information)
            }
            Step::Path(information) if !fit.whiten() => Step::Path(information),
            Step::Path(information) => {
                let rotation = poses.get(self.next)?.rotation();
                self.add_path(fit, &rotation);
                Step::SharedByPath(information)
            }
            Step::SharedByPath(information) => {
                let rotation = poses.get(self.next)?.rotation();
                self.add_shared(&rotation, &information, fit.scratch.rows());
                let side = MIN_SIDE.max(fit.residuals.used / SIDE_SHARE);
                let is_possible = self.seen >= side && fit.residuals.used >= side + self.seen;
                if is_possible { Step::Split(self.split, 0) } else { Step::See }
            }
            Step::Split(mut split, row) if row < 6 => {
                let last = (row + SPLIT_ROWS_A_SLICE).min(6);
                self.eliminate_shared(fit, &mut split, row..last);
                Step::Split(split, last)
            }
            Step::Split(split, _) => {
                self.try_split(fit, split);
                Step::See
            }
        };
        None
    }

    /// Adds what a pose says of ΔO and ΔC.
    fn add(&mut self, seen: &SeenPose<T>) {
        let (rotation, information, gradient) =
            (&seen.rotation, seen.marginal.information(), seen.marginal.gradient_mm());
        let turned = information * rotation;
        let in_platform = rotation.tr_mul(&turned);
        let gradient_in_platform = rotation.tr_mul(&gradient);
        for i in 0..3 {
            for j in 0..3 {
                self.split.add_to_entry(3 + i, j, -turned[(j, i)]);
                if j <= i {
                    self.split.add_to_entry(i, j, information[(i, j)]);
                    self.split.add_to_entry(3 + i, 3 + j, in_platform[(i, j)]);
                }
            }
            self.split.add_to_gradient(i, gradient[i]);
            self.split.add_to_gradient(3 + i, -gradient_in_platform[i]);
        }
        let own = seen.own_centre_mm;
        self.residual += own * own.transpose();
        self.of_neighbours_mm2 += own.dot(&self.previous_mm);
        self.previous_mm = own;
    }

    /// Adds what it says of them together with the other unknowns: of unknown u, Kᵤᵀ and -(Rᵀ Kᵤ)ᵀ, K = `information` times the
    /// rows, which are whitened.
    fn add_shared(&mut self, rotation: &Matrix3<T>, information: &Matrix3<T>, rows: &[[T; MAX_UNKNOWNS]]) {
        let [x, y, z] = rows else { return };
        let [a, b, c, d, e, f] = &mut self.shared;
        let columns = x.iter().zip(y).zip(z).map(|((x, y), z)| Vector3::new(*x, *y, *z));
        let shared = a.iter_mut().zip(b).zip(c).zip(d).zip(e).zip(f);
        for (column, (((((a, b), c), d), e), f)) in
            columns.zip(shared).filter(|(column, _)| *column != Vector3::zeros())
        {
            let column = information * column;
            let of_platform = -rotation.tr_mul(&column);
            *a += column.x;
            *b += column.y;
            *c += column.z;
            *d += of_platform.x;
            *e += of_platform.y;
            *f += of_platform.z;
        }
    }

    /// Adds how well the centre is predicted in a pose: its rows are whitened.
    fn add_path(&mut self, fit: &Fit<T>, rotation: &Matrix3<T>) {
        let covariance = fit.covariance_of_whitened();
        let along = column(rotation, 2);
        self.all_mm2 += covariance.trace();
        self.across_mm2 += covariance.trace() - along.dot(&(covariance * along));
    }

    /// Eliminates the other unknowns from some rows of a split's equations (Schur complement).
    fn eliminate_shared(&self, fit: &Fit<T>, split: &mut NormalEquations<T, 6, 21>, rows: Range<usize>) {
        for i in rows {
            for j in 0..=i {
                split.add_to_entry(i, j, -fit.product_of_rows(&self.shared, i, j));
            }
        }
    }

    /// By how much χ² would fall with another centre from the present pose on.
    fn try_split(&mut self, fit: &Fit<T>, mut split: NormalEquations<T, 6, 21>) {
        if split.factor().is_err() {
            return;
        }
        let step = split.step();
        let gain = dot(&step, split.gradient()) / fit.variance_mm2();
        if self.best.is_none_or(|best| gain > best.gain) {
            let [x, y, z, u, v, w] = step;
            let (of_base, of_cuff) = (Vector3::new(x, y, z), Vector3::new(u, v, w));
            self.best = Some(Split { pose: self.next, gain, of_base, of_cuff });
        }
    }

    fn judge(&self, fit: &mut Fit<T>) -> Next<T> {
        match self.refusal(fit) {
            Some(refusal) => Next::Done(Err(refusal)),
            None => {
                if let Joint::Moving(moving) = &mut fit.joint {
                    moving.persistence = self.persistence();
                }
                fit.path_sigmas_mm = [self.across_mm2, self.all_mm2].map(|sum| self.sigma_mm(fit, sum));
                Next::Check(Accepted::Moving)
            }
        }
    }

    /// By how much variances are larger because what one pose leaves it leaves to the next as well, as in a continuous motion.
    fn persistence(&self) -> T {
        persistence(self.of_neighbours_mm2 / self.residual.trace().max(T::default_epsilon()))
    }

    /// 1σ of the path from the sum of its variances by the fit, with what the model does not explain and an arm that may lie askew
    /// to the platform, both in the two axes across the arm.
    fn sigma_mm(&self, fit: &Fit<T>, variances_mm2: T) -> T {
        let mean = variances_mm2 / T::of_integer(self.seen as i32);
        let not_explained = fit.joint.lack_of_fit_mm2() + fit.joint.askew_mm2() * T::of(2.0);
        non_negative_root(mean * fit.joint.variance_factor() + not_explained)
    }

    fn refusal(&self, fit: &Fit<T>) -> Option<Refusal> {
        if let Some(distance) = fit.held.and_then(|held| held.contradiction_mm(&fit.centre_in_platform())) {
            return Some(Refusal::HeldOfAnotherWearing { distance_mm: distance.to_f32() });
        }
        let freedom = fit.residuals.freedom;
        if let Some(split) = &self.best {
            let gain = split.gain.min(freedom - T::of(7.0));
            let six = T::of(6.0);
            if (gain / six) > (freedom - gain) / (freedom - six) * T::of(SLIP_F) * self.persistence() {
                let (base, cuff) = (split.of_base.norm_squared(), split.of_cuff.norm_squared());
                let size_mm = non_negative_root(base.max(cuff)).to_f32();
                return Some(Refusal::SlippedMidway { pose: split.pose as u32, size_mm, is_cuff: cuff > base });
            }
        }
        let poses = T::of_integer(self.seen as i32);
        let (largest, _) = largest_eigenpair(&(self.residual / (poses - T::of(8.0)).max(T::one())));
        let residual_mm = non_negative_root(largest);
        let scatter_mm = fit.joint.scatter_mm2().root();
        if residual_mm > T::of(MAX_RESIDUAL_MM) || scatter_mm > T::of(MAX_SCATTER_MM) {
            // Outliers name what to look for better than the joint does.
            let not_explained = Refusal::NotExplained { residual_mm: residual_mm.to_f32() };
            let outliers = fit.ball_refusal.filter(|refusal| matches!(refusal, Refusal::TooManyOutliers { .. }));
            return Some(outliers.unwrap_or(not_explained));
        }
        let across_mm = non_negative_root(self.across_mm2 / poses);
        let all_mm = non_negative_root(self.all_mm2 / poses);
        // Also refuses NaN.
        if !(across_mm <= T::of(MAX_SIGMA_ACROSS_MM) && all_mm <= T::of(MAX_SIGMA_MM)) {
            let direction = match &fit.joint {
                Joint::Moving(moving) => moving.frame.home().map(Real::to_f32).into(),
                Joint::Ball | Joint::Held(_) => [0.0; 3],
            };
            return Some(Refusal::Weak { direction, sigma_mm: across_mm.max(all_mm).to_f32() });
        }
        None
    }
}
