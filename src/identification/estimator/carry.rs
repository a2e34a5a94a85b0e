//! A point of the platform carried into the base's frame through the identified ball, with all that is uncertain about
//! it: the lengths of the pose, the joint centre in both bodies, the machine's constants.

use super::Estimator;
use super::fit::Fit;
use crate::identification::carried_point::CarriedPoint;
use crate::identification::joint::Joint;
use crate::identification::machine::Machine;
use crate::identification::parameters::{CENTRE_UNKNOWNS, Column, Equations, MAX_UNKNOWNS, PoseAt, Rows};
use crate::identification::pose::Pose;
use crate::kinematics::LengthJacobian;
use crate::linear_algebra::{column, inverse_of_positive_definite, rounding};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

impl<T: Real> Estimator<T> {
    /// Where a point fixed in the platform ({P}) stands in {B} in a pose with these lengths. `None` when no rotation fits
    /// them, or the joint's centre moves.
    ///
    /// X = O + R (Y − C), R from the lengths about the centre: ω = G⁺ (δL − U (δO − R δC) − M δm) for errors of the lengths,
    /// the centre and the machine, and δX = δO − R δC + ω × (X − O).
    pub fn carry(&self, machine: &Machine<T>, pose: &Pose<T>, point: &CarriedPoint<T>) -> Option<CarriedPoint<T>> {
        self.carry_by(machine, pose, point, &self.fit.equations)
    }

    /// The same as it would be with further poses in the set, which are placed: of their lengths only the samples that they are
    /// the mean of count.
    pub fn carry_with(
        &self,
        machine: &Machine<T>,
        pose: &Pose<T>,
        point: &CarriedPoint<T>,
        further: &[Pose<T>],
    ) -> Option<CarriedPoint<T>> {
        let mut equations = self.fit.equations;
        for pose in further {
            self.fit.learn(machine, pose, &mut equations)?;
        }
        self.carry_by(machine, pose, point, &equations)
    }

    fn carry_by(
        &self,
        machine: &Machine<T>,
        pose: &Pose<T>,
        point: &CarriedPoint<T>,
        equations: &Equations<T>,
    ) -> Option<CarriedPoint<T>> {
        let fit = &self.fit;
        if matches!(fit.joint, Joint::Moving(_)) {
            return None;
        }
        let placed = fit.place_about_centre(machine, pose)?;
        let rotation = placed.rotation();
        let arm = rotation * (point.at_mm - fit.centre.in_platform_mm);
        let lengths = fit.estimate.corrected(machine, placed.lengths());
        let jacobian = fit.jacobian(&rotation, &lengths);
        let mut information = Matrix3::zeros();
        for row in &jacobian.rows {
            information += row.rotation_mm * row.rotation_mm.transpose();
        }
        // How the point moves for what the lengths say of a rotation: ω × arm, ω = (GᵀG)⁻¹ Gᵀ δL.
        let by_turn = -arm.cross_matrix();
        let turn = inverse_of_positive_definite(&information, rounding())?;
        let at = PoseAt { rotation: &rotation, lengths: &lengths, jacobian: &jacobian };
        let rows = fit.carrying_rows(machine, &at, &(by_turn * turn));
        let variance = fit.result.noise_mm * fit.result.noise_mm * machine.relative_variance(pose.samples);
        let own = by_turn * turn * by_turn.transpose() * variance + fit.covariance_by(equations, &rows);
        let mut carried = point.moved(&rotation, fit.centre.in_base_mm + arm);
        carried.covariance_mm2 += own;
        Some(carried)
    }

    /// The joint centre in {B} with its covariance; for a moving one, at the middle of the arm's directions.
    pub fn centre_point(&self) -> CarriedPoint<T> {
        let fit = &self.fit;
        let first = fit.equations.unknowns() - CENTRE_UNKNOWNS;
        let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
        for (axis, row) in rows.iter_mut().enumerate() {
            if let Some(entry) = row.get_mut(first + axis) {
                *entry = T::one();
            }
        }
        CarriedPoint { at_mm: fit.centre.in_base_mm, covariance_mm2: fit.covariance_of(&rows) }
    }
}

impl<T: Real> Fit<T> {
    /// Adds a placed pose, its rotation eliminated, to factored equations. `None` where it determines no rotation.
    fn learn(&self, machine: &Machine<T>, pose: &Pose<T>, equations: &mut Equations<T>) -> Option<()> {
        let seen = self.seen(machine, pose)?;
        let weight = (T::one() / machine.relative_variance(pose.samples)).root();
        for mut row in self.with_all_columns(machine, &seen).equations() {
            row.iter_mut().for_each(|entry| *entry *= weight);
            equations.add_row_to_factor(&row);
        }
        Some(())
    }

    /// Derivative of the point with the unknowns. `by_gradient`: with Gᵀ δL.
    fn carrying_rows(&self, machine: &Machine<T>, at: &PoseAt<'_, T>, by_gradient: &Matrix3<T>) -> Rows<T> {
        let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
        let mut put = |unknown: usize, motion: Vector3<T>| {
            for (row, value) in rows.iter_mut().zip(&motion) {
                if let Some(entry) = row.get_mut(unknown) {
                    *entry = *value;
                }
            }
        };
        for index in 0..self.estimate.count() {
            let column = self.estimate.column(machine, index, at);
            put(index, -(by_gradient * gradient(at.jacobian, &column)));
        }
        let first = self.equations.unknowns() - CENTRE_UNKNOWNS;
        for axis in 0..3 {
            let unit = column(&Matrix3::identity(), axis);
            for (place, motion) in [(first + axis, unit), (first + 3 + axis, -(at.rotation * unit))] {
                put(place, motion - by_gradient * gradient_of_motion(at.jacobian, &motion));
            }
        }
        rows
    }
}

/// Gᵀ δL for the lengths that a parameter changes.
fn gradient<T: Real>(jacobian: &LengthJacobian<T>, column: &Column<T>) -> Vector3<T> {
    match column {
        Column::OneCable(cable, change) => {
            jacobian.rows.get(*cable).map_or_else(Vector3::zeros, |row| row.rotation_mm * *change)
        }
        Column::AllCables(changes) => {
            let rows = jacobian.rows.iter().zip(changes);
            rows.fold(Vector3::zeros(), |sum, (row, change)| sum + row.rotation_mm * *change)
        }
    }
}

/// Gᵀ δL for the lengths that a motion of the centre changes.
fn gradient_of_motion<T: Real>(jacobian: &LengthJacobian<T>, moved: &Vector3<T>) -> Vector3<T> {
    let rows = jacobian.rows.iter();
    rows.fold(Vector3::zeros(), |sum, row| sum + row.rotation_mm * row.translation.dot(moved))
}
