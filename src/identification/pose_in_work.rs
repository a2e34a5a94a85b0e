//! A pose's three equations on their way into the normal equations, a few columns and a few rows a call: with all constants
//! of a machine and a moving joint, one pose would keep a Cortex-M4F from everything else for 150 µs.

use super::joint::{Features, Joint};
use super::marginal_information::MarginalInformation;
use super::parameters::{
    CENTRE_UNKNOWNS, CentreSums, Columns, Equations, MAX_UNKNOWNS, ParameterBlock, PoseAt, Rows, change_of_equations,
    columns_of_centre,
};
use crate::kinematics::length_jacobian::LengthRow;
use crate::kinematics::{CableLengths, LengthJacobian};
use crate::linear_algebra::packed_index;
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Columns a call.
const COLUMNS_A_CALL: usize = 8;
/// Entries of the normal matrix a call.
const ENTRIES_A_CALL: usize = 224;

/// The pose that is being added, with all that its columns need.
#[derive(Clone, Debug)]
pub struct PoseInWork<T> {
    rotation: Matrix3<T>,
    lengths: CableLengths<T>,
    jacobian: LengthJacobian<T>,
    features: Option<Features<T>>,
    /// How the three equations change with each length, and with δ.
    projector: [Vector3<T>; CABLES],
    translation: Matrix3<T>,
    residuals_mm: Vector3<T>,
    weight: T,
    /// Of the parameters, as far as they are known.
    columns: Columns<T>,
    of_centre: [Vector3<T>; CENTRE_UNKNOWNS],
    next: Next,
}

/// What is next of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    /// What it says: where it is is known.
    Begin,
    /// More columns.
    Columns,
    /// This row of the normal matrix, all columns being known.
    Row(usize),
    /// Nothing: it is in.
    Nothing,
}

impl<T: Real> PoseInWork<T> {
    /// Begins with a pose.
    pub fn new(at: &PoseAt<'_, T>, pose: &MarginalInformation<T>, weight: T) -> Self {
        let mut in_work = Self::not_begun(at.lengths);
        in_work.begin(at, pose, weight);
        in_work
    }

    /// Room for a pose, which has lengths; nothing else of it is known yet.
    pub fn not_begun(lengths: &CableLengths<T>) -> Self {
        let zero = Vector3::zeros();
        let row = LengthRow { translation: zero, rotation_mm: zero, residual_mm: T::zero() };
        Self {
            rotation: Matrix3::zeros(),
            lengths: *lengths,
            jacobian: LengthJacobian { rows: [row; CABLES] },
            features: None,
            projector: [Vector3::zeros(); CABLES],
            translation: Matrix3::zeros(),
            residuals_mm: Vector3::zeros(),
            weight: T::zero(),
            columns: Columns::new(),
            of_centre: [Vector3::zeros(); CENTRE_UNKNOWNS],
            next: Next::Nothing,
        }
    }

    /// Begins with a pose, in place of the one before.
    pub fn begin(&mut self, at: &PoseAt<'_, T>, pose: &MarginalInformation<T>, weight: T) {
        self.prepare(at.rotation, at.lengths, *at.jacobian);
        self.begin_prepared(pose, weight);
    }

    /// The first half of that: where the pose is.
    pub fn prepare(&mut self, rotation: &Matrix3<T>, lengths: &CableLengths<T>, jacobian: LengthJacobian<T>) {
        self.rotation = *rotation;
        self.lengths = *lengths;
        self.jacobian = jacobian;
        self.next = Next::Begin;
    }

    /// The second: what it says.
    pub fn begin_prepared(&mut self, pose: &MarginalInformation<T>, weight: T) {
        self.features = None;
        self.projector = pose.projector();
        self.translation = pose.translation;
        self.residuals_mm = pose.residuals_mm;
        self.weight = weight;
        self.columns.clear();
        let at = PoseAt { rotation: &self.rotation, lengths: &self.lengths, jacobian: &self.jacobian };
        self.of_centre = columns_of_centre(&at, pose);
        self.next = Next::Columns;
    }

    /// If it has not begun, it is not to.
    pub fn forget_prepared(&mut self) {
        if self.next == Next::Begin {
            self.next = Next::Nothing;
        }
    }

    /// Has it begun, and is it not in the equations yet?
    pub fn is_under_way(&self) -> bool {
        matches!(self.next, Next::Columns | Next::Row(_))
    }

    /// The Jacobian of a pose that is prepared; `None` of any other.
    pub fn prepared(&self) -> Option<&LengthJacobian<T>> {
        (self.next == Next::Begin).then_some(&self.jacobian)
    }

    /// The next few columns, then the next few rows into the equations; true when all are in.
    pub fn advance(&mut self, block: &impl ParameterBlock<T>, equations: &mut Equations<T>) -> bool {
        match self.next {
            Next::Columns => {
                if self.add_columns(block) {
                    self.next = Next::Row(0);
                }
                false
            }
            Next::Row(row) => {
                self.next = self.add_rows(row, equations);
                self.next == Next::Nothing
            }
            Next::Begin | Next::Nothing => true,
        }
    }

    /// Features of its rotation; `None` for a ball. Worked out once.
    pub fn features(&mut self, joint: &Joint<T>) -> Option<Features<T>> {
        if self.features.is_none() {
            self.features = joint.features(&self.rotation);
        }
        self.features
    }

    /// The columns of the next few parameters; true when all are known.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn add_columns(&mut self, block: &impl ParameterBlock<T>) -> bool {
        let at = PoseAt { rotation: &self.rotation, lengths: &self.lengths, jacobian: &self.jacobian };
        let first = self.columns.len();
        for index in first..block.count().min(first + COLUMNS_A_CALL) {
            let column = change_of_equations(&block.column(index, &at), &self.projector, &self.translation);
            // Never full: no block has more parameters.
            let _ = self.columns.push(column);
        }
        self.columns.len() >= block.count()
    }

    /// Adds the next few rows to the normal equations: what is next then.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    fn add_rows(&self, first: usize, equations: &mut Equations<T>) -> Next {
        let unknowns = self.columns.len() + CENTRE_UNKNOWNS;
        let entries = |row: usize| packed_index(row, 0) - packed_index(first, 0);
        let mut last = first + 1;
        while last < unknowns && entries(last + 1) <= ENTRIES_A_CALL {
            last += 1;
        }
        equations.add_equations(&self.columns, &self.of_centre, &self.residuals_mm, self.weight, first..last);
        if last < unknowns { Next::Row(last) } else { Next::Nothing }
    }

    /// Derivative of S δ̂ with the unknowns, once all columns are known: three rows, one column for each unknown.
    pub fn sensitivity(&self) -> Rows<T> {
        self.rows(|column| self.translation.tr_mul(column))
    }

    /// The three equations themselves, once all columns are known: three rows, one column for each unknown.
    pub fn equations(&self) -> Rows<T> {
        self.rows(|column| *column)
    }

    /// Three rows of what is made of each unknown's column.
    fn rows(&self, of: impl Fn(&Vector3<T>) -> Vector3<T>) -> Rows<T> {
        let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
        for (unknown, column) in self.columns.iter().chain(&self.of_centre).enumerate() {
            for (row, value) in rows.iter_mut().zip(&of(column)) {
                if let Some(entry) = row.get_mut(unknown) {
                    *entry = *value;
                }
            }
        }
        rows
    }
}

/// Adds a pose's information on O, C and the block's parameters, `weight` times.
pub fn add_pose<T: Real>(
    equations: &mut Equations<T>,
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &MarginalInformation<T>,
    weight: T,
) {
    let mut sums = CentreSums::default();
    sums.add(at.rotation, pose, weight);
    equations.add_squares(pose.squares_mm2() * weight);
    if block.count() > 0 {
        let mut in_work = PoseInWork::new(at, pose, weight);
        while !in_work.advance(block, equations) {}
    }
    sums.move_to(equations);
}

/// A pose all of whose columns are known.
pub fn with_all_columns<T: Real>(
    block: &impl ParameterBlock<T>,
    at: &PoseAt<'_, T>,
    pose: &MarginalInformation<T>,
) -> PoseInWork<T> {
    let mut in_work = PoseInWork::new(at, pose, T::one());
    while !in_work.add_columns(block) {}
    in_work
}
