//! A pose's three equations on their way into the normal equations, a few columns and a few rows a call: with all constants
//! of a machine and a moving joint, one pose would keep a Cortex-M4F from everything else for 150 µs.
//!
//! A gain moves the centre as O does, a feature times as far. So its column is that of O, times the feature, and what it
//! shares with another gain is S = ŪᵀŪ times both features: one product for an entry of the normal matrix instead of three.

use super::marginal_information::MarginalInformation;
use super::parameters::{
    CENTRE_UNKNOWNS, CentreFeatures, CentreSums, Columns, Equations, MAX_UNKNOWNS, ParameterBlock, PoseAt, Rows,
    change_of_equations,
};
use crate::kinematics::length_jacobian::LengthRow;
use crate::kinematics::{CableLengths, LengthJacobian};
use crate::linear_algebra::column;
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Columns a call.
const COLUMNS_A_CALL: usize = 8;
/// Products with features a call, 5 instructions each: about 7 000 cycles of a Cortex-M4F (`cargo cycles`).
const PRODUCTS_A_CALL: usize = 640;
/// An entry with a constant takes the time of so many of them, and a row beside its entries.
const CONSTANT_IN_PRODUCTS: usize = 2;
const ROW_IN_PRODUCTS: usize = 8;

/// The pose that is being added, with all that its columns need.
#[derive(Clone, Debug)]
pub struct PoseInWork<T> {
    rotation: Matrix3<T>,
    lengths: CableLengths<T>,
    jacobian: LengthJacobian<T>,
    /// How the three equations change with each length, and with δ.
    projector: [Vector3<T>; CABLES],
    translation: Matrix3<T>,
    residuals_mm: Vector3<T>,
    gradient_mm: Vector3<T>,
    weight: T,
    /// Of the constants, as far as they are known.
    columns: Columns<T>,
    /// Of its rotation; none where the centre stays.
    features: CentreFeatures<T>,
    /// Columns of O and of C; and their products with those of O, a row each of theirs.
    of_centre: [Matrix3<T>; 2],
    shared: [Matrix3<T>; 2],
    next: Next,
}

/// What is next of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    /// What it says: where it is is known.
    Begin,
    /// Its features, then more columns.
    Columns,
    /// The rows of the normal matrix from this one on, all columns being known.
    Rows(usize),
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
            projector: [Vector3::zeros(); CABLES],
            translation: Matrix3::zeros(),
            residuals_mm: Vector3::zeros(),
            gradient_mm: Vector3::zeros(),
            weight: T::zero(),
            columns: Columns::new(),
            features: CentreFeatures::new(),
            of_centre: [Matrix3::zeros(); 2],
            shared: [Matrix3::zeros(); 2],
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
        self.projector = pose.projector();
        self.translation = pose.translation;
        self.residuals_mm = pose.residuals_mm;
        self.gradient_mm = pose.gradient_mm();
        self.weight = weight;
        self.columns.clear();
        // Ū J with J = [I, -R].
        self.of_centre = [pose.translation, -(pose.translation * self.rotation)];
        let information = pose.information();
        self.shared = [information, -self.rotation.tr_mul(&information)];
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
        matches!(self.next, Next::Columns | Next::Rows(_))
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
                    self.next = Next::Rows(0);
                }
                false
            }
            Next::Rows(first) => {
                self.next = self.add_rows(first, equations);
                self.next == Next::Nothing
            }
            Next::Begin | Next::Nothing => true,
        }
    }

    /// The features, then the columns of the next few constants; true when all are known.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn add_columns(&mut self, block: &impl ParameterBlock<T>) -> bool {
        let at = PoseAt { rotation: &self.rotation, lengths: &self.lengths, jacobian: &self.jacobian };
        let (first, constants) = (self.columns.len(), block.constants());
        if first == 0 {
            self.features = block.features(&self.rotation);
        }
        for index in first..constants.min(first + COLUMNS_A_CALL) {
            let column = change_of_equations(&block.column(index, &at), &self.projector);
            // Never full: no machine has more constants.
            let _ = self.columns.push(column);
        }
        self.columns.len() >= constants
    }

    /// Adds the next few rows to the normal equations, those of the centre three by three: what is next then.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    fn add_rows(&self, first: usize, equations: &mut Equations<T>) -> Next {
        let (constants, unknowns) = (self.columns.len(), self.unknowns());
        let (mut next, mut left) = (first, PRODUCTS_A_CALL);
        while next < unknowns {
            let (rows, products) = match next.checked_sub(constants) {
                None => (1, CONSTANT_IN_PRODUCTS * next + ROW_IN_PRODUCTS),
                Some(gains) => (3, 3 * (CONSTANT_IN_PRODUCTS * constants + gains + ROW_IN_PRODUCTS)),
            };
            if next > first && products > left {
                return Next::Rows(next);
            }
            match self.columns.get(next) {
                Some(column) => self.add_row_of_constant(next, column, equations),
                None => self.add_rows_of_centre(next, equations),
            }
            left = left.saturating_sub(products);
            next += rows;
        }
        Next::Nothing
    }

    /// The row of a constant, which has this column.
    fn add_row_of_constant(&self, unknown: usize, column: &Vector3<T>, equations: &mut Equations<T>) {
        let column = column * self.weight;
        let [row] = equations.rows_mut(unknown);
        for (entry, other) in row.iter_mut().zip(&self.columns) {
            *entry += column.dot(other);
        }
        equations.add_to_gradient(unknown, column.dot(&self.residuals_mm));
    }

    /// The rows of the three gains of a feature, of O or of C; but not what O and C share among themselves, which [`CentreSums`]
    /// adds.
    fn add_rows_of_centre(&self, first: usize, equations: &mut Equations<T>) {
        let constants = self.columns.len();
        let block = (first - constants) / 3;
        let feature = self.features.get(block);
        let times = feature.map_or(self.weight, |feature| *feature * self.weight);
        let centre = usize::from(block > self.features.len());
        let (Some(columns), Some(shared)) = (self.of_centre.get(centre), self.shared.get(centre)) else { return };
        let rows = equations.rows_mut(first).map(|row| row.split_at_mut_checked(constants).unwrap_or_default());
        let [(x, of_x), (y, of_y), (z, of_z)] = rows;
        add_products([x, y, z], columns, &self.columns, times);
        add_multiples([of_x, of_y, of_z], shared, &self.features, times);
        if feature.is_some() {
            for (axis, gradient) in self.gradient_mm.iter().enumerate() {
                equations.add_to_gradient(first + axis, *gradient * times);
            }
        }
    }

    /// Constants, gains, O and C.
    fn unknowns(&self) -> usize {
        self.columns.len() + 3 * self.features.len() + CENTRE_UNKNOWNS
    }

    /// Derivative of S δ̂ with the unknowns, once all columns are known: three rows, one column for each unknown.
    pub fn sensitivity(&self) -> Rows<T> {
        self.rows(&self.translation.transpose(), &self.of_centre)
    }

    /// The same of the constants and C alone: the gains and O change S δ̂ as S times the centre's path changes.
    pub fn sensitivity_beside_path(&self) -> Rows<T> {
        let [_, platform] = self.of_centre;
        self.rows(&self.translation.transpose(), &[Matrix3::zeros(), platform])
    }

    /// S: the pose's information on δ, scatter eliminated.
    pub fn information(&self) -> &Matrix3<T> {
        let [base, _] = &self.shared;
        base
    }

    /// The three equations themselves, once all columns are known: three rows, one column for each unknown.
    pub fn equations(&self) -> Rows<T> {
        self.rows(&Matrix3::identity(), &self.of_centre)
    }

    /// Three rows of `times` the columns of the constants, of the gains, and of O and C as given.
    fn rows(&self, times: &Matrix3<T>, of_centre: &[Matrix3<T>; 2]) -> Rows<T> {
        let mut rows = [[T::zero(); MAX_UNKNOWNS]; 3];
        let mut put = |unknown: usize, value: &Vector3<T>| {
            for (row, value) in rows.iter_mut().zip(value) {
                if let Some(entry) = row.get_mut(unknown) {
                    *entry = *value;
                }
            }
        };
        self.columns.iter().enumerate().for_each(|(unknown, constant)| put(unknown, &(times * constant)));
        let constants = self.columns.len();
        let [base, platform] = of_centre.map(|columns| times * columns);
        let gains = self.features.iter().map(|feature| base * *feature);
        for (block, centre) in gains.chain([base, platform]).enumerate() {
            (0..3).for_each(|axis| put(constants + 3 * block + axis, &column(&centre, axis)));
        }
        rows
    }
}

/// Adds to three rows the products of three columns with the others, `times` times, as far as all three have entries.
#[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
fn add_products<T: Real>([x, y, z]: [&mut [T]; 3], columns: &Matrix3<T>, others: &[Vector3<T>], times: T) {
    let [a, b, c] = [column(columns, 0), column(columns, 1), column(columns, 2)];
    for (((x, y), z), other) in x.iter_mut().zip(y).zip(z).zip(others) {
        let other = other * times;
        *x += a.dot(&other);
        *y += b.dot(&other);
        *z += c.dot(&other);
    }
}

/// Adds `a` times each feature, `times` times, to three rows, three entries of each a feature. On the diagonal, where rows end, a
/// triangle.
#[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
fn add_multiples<T: Real>([x, y, z]: [&mut [T]; 3], a: &Matrix3<T>, features: &[T], times: T) {
    let [(x, last_of_x), (y, last_of_y), (z, _)] = [x, y, z].map(|row| row.as_chunks_mut::<3>());
    let triangle = (features.get(x.len()), last_of_x, last_of_y, z.get_mut(x.len()));
    if let (Some(feature), [xx], [yx, yy], Some([zx, zy, zz])) = triangle {
        let feature = *feature * times;
        *xx += a.m11 * feature;
        *yx += a.m21 * feature;
        *yy += a.m22 * feature;
        *zx += a.m31 * feature;
        *zy += a.m32 * feature;
        *zz += a.m33 * feature;
    }
    for (((x, y), z), feature) in x.iter_mut().zip(y).zip(z).zip(features) {
        let feature = *feature * times;
        x[0] += a.m11 * feature;
        x[1] += a.m12 * feature;
        x[2] += a.m13 * feature;
        y[0] += a.m21 * feature;
        y[1] += a.m22 * feature;
        y[2] += a.m23 * feature;
        z[0] += a.m31 * feature;
        z[1] += a.m32 * feature;
        z[2] += a.m33 * feature;
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
    if block.constants() > 0 || !block.features(at.rotation).is_empty() {
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
