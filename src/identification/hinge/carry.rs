//! A point of the platform carried into the base's frame through the identified hinge, with all that is uncertain about
//! it: the lengths of the pose, the hinge, the machine's constants.

use super::estimator::HingeEstimator;
use super::fit::Equations;
use super::joint::{AXIS, AXIS_IN_PLATFORM, FOOT, across};
use super::pose::{AngleSearch, MAX_UNKNOWNS, PoseAt};
use super::rig::MAX_CABLES;
use crate::identification::carried_point::CarriedPoint;
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Gauss-Newton rounds for the angle.
const ROUNDS: usize = 8;

/// Three linear functions of the unknowns.
type Rows<T> = [[T; MAX_UNKNOWNS]; 3];

impl<T: Real> HingeEstimator<T> {
    /// Where a point fixed in the platform ({P}) stands in {B} in a pose with these lengths. `None` when they are no
    /// numbers. After [`run`](Self::run) has given a result.
    ///
    /// The angle follows from the lengths: δθ = D⁺ (δL − J δξ) for errors of the lengths and of the unknowns ξ.
    pub fn carry(&self, lengths_mm: &[T; MAX_CABLES], point: &CarriedPoint<T>) -> Option<CarriedPoint<T>> {
        self.carry_by(lengths_mm, point, &self.work.fit.equations)
    }

    /// The same as it would be with further poses in the set, at these angles from the hinge's own zero, rad.
    pub fn carry_with(
        &self,
        lengths_mm: &[T; MAX_CABLES],
        point: &CarriedPoint<T>,
        further_rad: &[T],
    ) -> Option<CarriedPoint<T>> {
        let mut equations = self.work.fit.equations;
        further_rad.iter().for_each(|angle| self.learn(&mut equations, *angle));
        self.carry_by(lengths_mm, point, &equations)
    }

    fn carry_by(
        &self,
        lengths_mm: &[T; MAX_CABLES],
        point: &CarriedPoint<T>,
        equations: &Equations<T>,
    ) -> Option<CarriedPoint<T>> {
        let fit = &self.work.fit;
        let hinge = &fit.hinge;
        let at = PoseAt::new(hinge, &fit.machine);
        let from = AngleSearch::new(hinge, &fit.machine, fit.range_rad()).nearest_rad(lengths_mm, fit.machine.cables());
        let (angle, squares) = at.best_angle(lengths_mm, from, ROUNDS);
        if !squares.is_a_number() {
            return None;
        }
        let rotation = hinge.rotation(angle);
        let arm = point.at_mm - hinge.foot_in_platform_mm();
        let [of_hinge @ .., turning] = hinge.motions(&hinge.frame(), &rotation, &arm);
        let rows = at.rows(lengths_mm, angle, fit.constants);
        let information = rows.by_angle.iter().fold(T::zero(), |sum, d| sum + *d * *d).max(T::of(1e-9));
        let mut carrying = [[T::zero(); MAX_UNKNOWNS]; 3];
        for unknown in 0..fit.unknowns() {
            let pairs = rows.by_angle.iter().zip(&rows.jacobian);
            let gradient =
                pairs.fold(T::zero(), |sum, (d, row)| sum + *d * row.get(unknown).copied().unwrap_or_else(T::zero));
            let direct = of_hinge.get(unknown).copied().unwrap_or_else(Vector3::zeros);
            put(&mut carrying, unknown, &(direct - turning * (gradient / information)));
        }
        let variance = self.work.found.noise_mm * self.work.found.noise_mm;
        let mut carried = point.moved(&rotation, hinge.platform_foot_mm() + rotation * arm);
        carried.covariance_mm2 += turning * turning.transpose() * (variance / information);
        carried.covariance_mm2 += self.covariance_by(equations, &carrying);
        Some(carried)
    }

    /// The point of the axis in the base nearest to the middle of the base's points.
    pub fn axis_point(&self) -> CarriedPoint<T> {
        let hinge = &self.work.fit.hinge;
        let points = self.work.fit.machine.base_mm();
        let count = T::of_integer(points.len().max(1) as i32);
        let middle = points.iter().fold(Vector3::zeros(), |sum, point| sum + point) / count;
        let along = hinge.axis().dot(&middle);
        let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
        for (k, e) in across(hinge.axis()).iter().enumerate() {
            put(&mut rows, AXIS + k, &(e * along));
            put(&mut rows, FOOT + k, e);
        }
        CarriedPoint { at_mm: hinge.nearest_mm(&middle), covariance_mm2: self.covariance_of(&rows) }
    }

    /// Distance of a point from the axis, mm, and its 1σ; `in_platform`: a point of the platform, else of the base.
    pub fn distance_to_axis_mm(&self, point: &CarriedPoint<T>, in_platform: bool) -> (T, T) {
        let hinge = &self.work.fit.hinge;
        let (axis, foot, first) = if in_platform {
            (hinge.axis_in_platform(), *hinge.foot_in_platform_mm(), AXIS_IN_PLATFORM)
        } else {
            (*hinge.axis(), *hinge.foot_mm(), AXIS)
        };
        let along = axis.dot(&point.at_mm);
        let from_axis = point.at_mm - foot - axis * along;
        let distance = from_axis.norm_squared().root();
        let direction = from_axis / distance;
        // Where the axis turns, its point beside the given one moves by so much.
        let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
        for (k, e) in across(&axis).iter().enumerate() {
            put(&mut rows, first + k, &(e * along));
            put(&mut rows, first + 2 + k, e);
        }
        let covariance = point.covariance_mm2 + self.covariance_of(&rows);
        (distance, non_negative_root(direction.dot(&(covariance * direction))))
    }

    /// Covariance of three linear functions of the unknowns, mm².
    fn covariance_of(&self, rows: &Rows<T>) -> Matrix3<T> {
        self.covariance_by(&self.work.fit.equations, rows)
    }

    /// The same by equations that know more.
    fn covariance_by(&self, equations: &Equations<T>, rows: &Rows<T>) -> Matrix3<T> {
        let mut whitened = *rows;
        whitened.iter_mut().for_each(|row| equations.whiten(row));
        let [x, y, z] = &whitened;
        let axes = [x, y, z];
        Matrix3::from_fn(|i, j| match (axes.get(i), axes.get(j)) {
            (Some(a), Some(b)) => dot(a, b),
            _ => T::zero(),
        }) * (self.work.found.noise_mm * self.work.found.noise_mm)
    }

    /// Adds a pose at an angle, its angle eliminated, to factored equations.
    fn learn(&self, equations: &mut Equations<T>, angle_rad: T) {
        let fit = &self.work.fit;
        let at = PoseAt::new(&fit.hinge, &fit.machine);
        let mut rows = at.rows(&[T::zero(); MAX_CABLES], angle_rad, fit.constants);
        let by_angle = rows.by_angle;
        rows.eliminate(&by_angle, fit.unknowns());
        rows.jacobian.iter().for_each(|row| equations.add_row_to_factor(row));
    }
}

fn dot<T: Real>(a: &[T; MAX_UNKNOWNS], b: &[T; MAX_UNKNOWNS]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + *a * *b)
}

fn put<T: Real>(rows: &mut Rows<T>, unknown: usize, motion: &Vector3<T>) {
    for (row, value) in rows.iter_mut().zip(motion) {
        if let Some(entry) = row.get_mut(unknown) {
            *entry = *value;
        }
    }
}
