//! Explanations as columns: how the six lengths of each pose would change if one were true.

use super::all_poses_fit::{AllPosesFit, FittedPose, by_cable};
use super::{Cause, CauseKind, Scored};
use glenoid::identification::Machine;
use glenoid::identification::machine::{MachineEstimate, MachineParameter};
use glenoid::identification::parameters::PoseAt;
use glenoid::kinematics::{CableLengths, LengthJacobian};
use glenoid::rig::{CABLES, Rig, Tolerance};
use nalgebra::{DMatrix, DVector, Matrix3x6, Vector6};

/// Added to the diagonal of a small matrix before it is inverted, relative to its trace.
const RIDGE: f64 = 1e-9;

/// By how much χ² falls when columns (6 x q of each pose) are added to the fit, and their sizes: a score test, no refit.
pub fn score(fit: &AllPosesFit, columns: &[DMatrix<f64>]) -> (f64, DVector<f64>) {
    let count = columns.first().map_or(0, DMatrix::ncols);
    let unknowns = fit.covariance.nrows();
    let mut information = DMatrix::zeros(count, count);
    let mut mixed = DMatrix::zeros(unknowns, count);
    let mut gradient = DVector::zeros(count);
    for (pose, columns) in fit.poses.iter().zip(columns) {
        let rows = pose.rows * columns;
        information += rows.tr_mul(&rows);
        mixed += pose.jacobian.tr_mul(&rows);
        gradient += rows.tr_mul(&pose.residual);
    }
    information -= mixed.tr_mul(&(&fit.covariance * &mixed));
    gain(information, &gradient)
}

/// gᵀ S⁻¹ g and S⁻¹ g.
pub fn gain(mut information: DMatrix<f64>, gradient: &DVector<f64>) -> (f64, DVector<f64>) {
    let ridge = information.trace().abs() * RIDGE + f64::MIN_POSITIVE;
    for i in 0..information.nrows() {
        information[(i, i)] += ridge;
    }
    match information.cholesky() {
        Some(factor) => {
            let sizes = factor.solve(gradient);
            (gradient.dot(&sizes), sizes)
        }
        None => (0.0, DVector::zeros(gradient.len())),
    }
}

/// What one cable or the whole machine may have, all poses alike.
pub fn of_the_machine(fit: &AllPosesFit, rig: &Rig<f64>, lengths: &[CableLengths<f64>]) -> Vec<Scored> {
    let cost = (3.0 * fit.poses.len() as f64).ln();
    let home = Vector6::from(rig.drum().home_length_mm);
    let mut scored = Vec::new();
    let mut push = |kind, cable, columns: &[DMatrix<f64>], size: fn(&DVector<f64>) -> f64| {
        let (gain, sizes) = score(fit, columns);
        let cause = Cause { cable, size: size(&sizes), ..Cause::of(kind) };
        scored.extend(Scored::within(cause, fit, gain, cost * sizes.len() as f64));
    };
    let single = |column: &dyn Fn(usize, &FittedPose) -> Vector6<f64>| -> Vec<DMatrix<f64>> {
        fit.poses
            .iter()
            .enumerate()
            .map(|(index, pose)| DMatrix::from_column_slice(6, 1, column(index, pose).as_slice()))
            .collect()
    };
    let first = |sizes: &DVector<f64>| sizes[0];
    let lag = lags(&home, lengths);
    for cable in 0..CABLES {
        let only = |values: &Vector6<f64>| Vector6::ith(cable, values[cable]);
        let number = Some(cable as u8 + 1);
        let drum = single(&|_, pose| only(&(pose.modelled_mm - home)));
        push(CauseKind::DrumScale, number, &drum, |sizes| 100.0 * sizes[0]);
        push(CauseKind::EncoderOffset, number, &single(&|_, _| Vector6::ith(cable, 1.0)), first);
        push(CauseKind::Hysteresis, number, &single(&|index, _| only(&lag[index])), first);
    }
    push(CauseKind::Hysteresis, None, &single(&|index, _| lag[index]), first);
    for (kind, is_meant) in [
        (CauseKind::BaseShape, (|p| matches!(p, MachineParameter::Base(_))) as fn(MachineParameter) -> bool),
        (CauseKind::PlatformShape, |p| matches!(p, MachineParameter::Ends(_))),
    ] {
        if let Some(columns) = shape(fit, rig, lengths, is_meant) {
            push(kind, None, &columns, |sizes| sizes.norm());
        }
    }
    scored
}

/// Half a millimetre in the direction of the last movement: what 1 mm of hysteresis leaves. The first pose is come to
/// from home.
fn lags(home: &Vector6<f64>, lengths: &[CableLengths<f64>]) -> Vec<Vector6<f64>> {
    let mut before = *home;
    lengths
        .iter()
        .map(|lengths| {
            let now = Vector6::from(*lengths.as_mm());
            let moved = now - before;
            before = now;
            moved.map(|moved| 0.5 * moved.signum())
        })
        .collect()
}

/// Columns of the shape of the base or of the platform, whatever its tolerance.
fn shape(
    fit: &AllPosesFit,
    rig: &Rig<f64>,
    lengths: &[CableLengths<f64>],
    is_meant: fn(MachineParameter) -> bool,
) -> Option<Vec<DMatrix<f64>>> {
    let loose = Tolerance { base_mm: 1.0, edges_mm: 1.0, ..Tolerance::exact() };
    let machine = Machine::new(&rig.with_tolerance(loose).ok()?);
    let estimate = MachineEstimate::new(&machine);
    let meant: Vec<_> = (0..machine.parameters()).filter(|index| is_meant(machine.parameter(*index))).collect();
    let of_pose = |(pose, lengths): (&FittedPose, &CableLengths<f64>)| {
        let jacobian = LengthJacobian::new(machine.geometry(), &fit.centre, &pose.rotation, lengths);
        let at = PoseAt { rotation: &pose.rotation, lengths, jacobian: &jacobian };
        let columns: Vec<_> = meant
            .iter()
            .map(|index| by_cable(estimate.column(&machine, *index, &at)))
            .flat_map(|column| column.as_slice().to_vec())
            .collect();
        DMatrix::from_vec(6, meant.len(), columns)
    };
    Some(fit.poses.iter().zip(lengths).map(of_pose).collect())
}

/// What changed once, between two poses: counts lost by one cable, or a slip. The pose is found as well, which costs two
/// parameters more.
pub fn from_a_pose_on(fit: &AllPosesFit) -> Vec<Scored> {
    let poses = fit.poses.len();
    let cost = (3.0 * poses as f64).ln();
    let best = |kind, cable: Option<u8>, margin: usize, rows: &dyn Fn(&FittedPose) -> DMatrix<f64>| {
        let mut best: Option<Scored> = None;
        let mut tail = Tail::none(fit, rows);
        for (from, pose) in fit.poses.iter().enumerate().rev() {
            tail.add(pose, rows);
            if from < margin || from + margin >= poses {
                continue;
            }
            let (gain, sizes) = tail.gain(fit);
            let cause = Cause { cable, pose: Some(from), size: sizes.norm() * signum(&sizes), ..Cause::of(kind) };
            let Some(scored) = Scored::within(cause, fit, gain, cost * (sizes.len() + 2) as f64) else { continue };
            if best.as_ref().is_none_or(|best| scored.score < best.score) {
                best = Some(scored);
            }
        }
        best
    };
    let mut scored = Vec::new();
    for cable in 0..CABLES {
        let column = |pose: &FittedPose| DMatrix::from_column_slice(3, 1, pose.rows.column(cable).as_slice());
        scored.extend(best(CauseKind::LostCounts, Some(cable as u8 + 1), 3, &column));
    }
    let moved = |rows: &Matrix3x6<f64>, pose: &FittedPose| rows * pose.translation;
    let base = |pose: &FittedPose| DMatrix::from_column_slice(3, 3, moved(&pose.rows, pose).as_slice());
    let cuff =
        |pose: &FittedPose| DMatrix::from_column_slice(3, 3, (-moved(&pose.rows, pose) * pose.rotation).as_slice());
    scored.extend(best(CauseKind::BaseSlipped, None, 4, &base));
    scored.extend(best(CauseKind::CuffSlipped, None, 4, &cuff));
    scored
}

/// The sign of a single size; several have none.
fn signum(sizes: &DVector<f64>) -> f64 {
    if sizes.len() == 1 { sizes[0].signum() } else { 1.0 }
}

/// Sums over all poses from one on.
struct Tail {
    information: DMatrix<f64>,
    mixed: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Tail {
    fn none(fit: &AllPosesFit, rows: &dyn Fn(&FittedPose) -> DMatrix<f64>) -> Self {
        let count = fit.poses.first().map_or(0, |pose| rows(pose).ncols());
        Self {
            information: DMatrix::zeros(count, count),
            mixed: DMatrix::zeros(fit.covariance.nrows(), count),
            gradient: DVector::zeros(count),
        }
    }

    fn add(&mut self, pose: &FittedPose, rows: &dyn Fn(&FittedPose) -> DMatrix<f64>) {
        let rows = rows(pose);
        self.information += rows.tr_mul(&rows);
        self.mixed += pose.jacobian.tr_mul(&rows);
        self.gradient += rows.tr_mul(&pose.residual);
    }

    fn gain(&self, fit: &AllPosesFit) -> (f64, DVector<f64>) {
        let left = &self.information - self.mixed.tr_mul(&(&fit.covariance * &self.mixed));
        gain(left, &self.gradient)
    }
}
