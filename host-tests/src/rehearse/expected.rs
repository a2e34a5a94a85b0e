//! How exact an identification can be expected to be, from what is known of the machine and nothing that the board says.
//!
//! This is the Cramér-Rao bound with the tolerances as priors, written here from the geometry alone. With O the joint
//! centre in {B}, C the joint centre seen from the platform, R the arm's rotation and P_k, B_k the ends of a cable,
//!
//! ```text
//! L = |R (P_k - C) + O - B_k|   (or over its pulley),   reading = home + scale (L - home) + offset
//! ```
//!
//! Unknown are O, C, and whatever of the machine has a tolerance: each coordinate of an attachment point, each edge (or
//! each coordinate of an end), each offset, each scale. All derivatives are differences. The rotation is unknown anew in
//! each pose and is eliminated there (Schur complement). O is meant in the frame best fitted to the attachment points.

use crate::wearer::{Cables, FittedArm, rotation};
use glenoid::rig::{ATTACHMENTS, CABLES, POINTS, Rig, Tolerance};
use nalgebra::{DMatrix, Matrix3, Rotation3, Vector3};

/// Step of a difference: mm, and rad times a lever of some 100 mm.
const STEP_MM: f64 = 1e-3;
const STEP_RAD: f64 = 1e-5;
/// Unit of a drum's scale, so that all unknowns change lengths by about as much.
const SCALE_UNIT: f64 = 0.01;

/// Smallest standard deviations that any identification can have, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Of x, y, z, p1, p2, p3.
    pub parameters: [f64; 6],
    /// Of the encoder offsets; 0 when they are known.
    pub offsets: [f64; CABLES],
}

/// Standard deviation of one cable length, mm: uniform noise within ±`noise_mm`, and rounding to whole counts.
pub fn length_sigma_mm(noise_mm: f64, mm_per_count: f64) -> f64 {
    // A uniform distribution of full width w has the standard deviation w / sqrt(12).
    (2.0 * noise_mm).hypot(mm_per_count) / 12f64.sqrt()
}

impl Expected {
    /// From these poses of a machine known with this tolerance, when each length has a standard deviation of
    /// `length_sigma_mm`. None when the poses do not determine the centre.
    pub fn new(
        rig: &Rig<f64>,
        arm: &FittedArm,
        poses: &[Rotation3<f64>],
        length_sigma_mm: f64,
        tolerance: &Tolerance<f64>,
    ) -> Option<Self> {
        let model = Model::new(rig, arm, tolerance);
        let count = model.unknowns.len();
        let mut information = DMatrix::zeros(count, count);
        for pose in poses {
            information += model.information(pose)? / length_sigma_mm.powi(2);
        }
        for (index, sigma) in model.unknowns.iter().map(|unknown| unknown.sigma(tolerance)).enumerate() {
            if let Some(sigma) = sigma {
                information[(index, index)] += 1.0 / (sigma * sigma);
            }
        }
        let covariance = information.cholesky()?.inverse();
        let of_results = model.results();
        let variances = (&of_results * &covariance * of_results.transpose()).diagonal();
        let offsets = model.unknowns.iter().position(|unknown| *unknown == Unknown::Offset(0));
        Some(Self {
            parameters: std::array::from_fn(|k| variances[k].sqrt()),
            offsets: offsets
                .map_or([0.0; CABLES], |first| std::array::from_fn(|k| covariance[(first + k, first + k)].sqrt())),
        })
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Unknown {
    /// O, C: axis.
    Centre(usize),
    InPlatform(usize),
    /// A coordinate of an attachment point (3-3), or of a cable's.
    Base(usize),
    /// An edge (3-3), or a coordinate of a cable's end.
    Ends(usize),
    Offset(usize),
    Scale(usize),
}

impl Unknown {
    fn sigma(&self, tolerance: &Tolerance<f64>) -> Option<f64> {
        match self {
            Self::Centre(_) | Self::InPlatform(_) => None,
            Self::Base(_) => Some(tolerance.base_mm),
            Self::Ends(_) => Some(tolerance.edges_mm),
            Self::Offset(_) => Some(tolerance.offset_mm),
            Self::Scale(_) => Some(tolerance.drum / SCALE_UNIT),
        }
    }
}

struct Model<'a> {
    arm: &'a FittedArm,
    cables: Cables,
    home_mm: [f64; CABLES],
    is_three_three: bool,
    unknowns: Vec<Unknown>,
}

/// What one unknown changes: ends on the base and on the platform, O, C, and the readings of the six cables.
#[derive(Default, Clone, Copy)]
struct Change {
    centre_mm: Vector3<f64>,
    in_platform_mm: Vector3<f64>,
    base_mm: [Vector3<f64>; CABLES],
    ends_mm: [Vector3<f64>; CABLES],
    offset_mm: [f64; CABLES],
    scale: [f64; CABLES],
}

impl<'a> Model<'a> {
    fn new(rig: &Rig<f64>, arm: &'a FittedArm, tolerance: &Tolerance<f64>) -> Self {
        let is_three_three = rig.cables().is_none();
        let coordinates = if is_three_three { 3 * POINTS } else { 3 * CABLES };
        let ends = if is_three_three { POINTS } else { 3 * CABLES };
        let if_unknown = |sigma: f64, count: usize| 0..if sigma > 0.0 { count } else { 0 };
        let unknowns = (0..3)
            .map(Unknown::Centre)
            .chain((0..3).map(Unknown::InPlatform))
            .chain(if_unknown(tolerance.base_mm, coordinates).map(Unknown::Base))
            .chain(if_unknown(tolerance.edges_mm, ends).map(Unknown::Ends))
            .chain(if_unknown(tolerance.offset_mm, CABLES).map(Unknown::Offset))
            .chain(if_unknown(tolerance.drum, CABLES).map(Unknown::Scale));
        Self {
            arm,
            cables: Cables::new(rig),
            home_mm: rig.drum().home_length_mm,
            is_three_three,
            unknowns: unknowns.collect(),
        }
    }

    fn change(&self, unknown: Unknown, by: f64) -> Change {
        let mut change = Change::default();
        let along = |axis: usize| Vector3::ith(axis, by);
        match unknown {
            Unknown::Centre(axis) => change.centre_mm = along(axis),
            Unknown::InPlatform(axis) => change.in_platform_mm = along(axis),
            Unknown::Base(index) => {
                let is_meant = |cable: usize| match self.is_three_three {
                    true => ATTACHMENTS[cable / 2][cable % 2] == index / 3,
                    false => cable == index / 3,
                };
                (0..CABLES).filter(|cable| is_meant(*cable)).for_each(|k| change.base_mm[k] = along(index % 3));
            }
            Unknown::Ends(edge) if self.is_three_three => change.ends_mm = self.with_edge(edge, by),
            Unknown::Ends(index) => change.ends_mm[index / 3] = along(index % 3),
            Unknown::Offset(cable) => change.offset_mm[cable] = by,
            Unknown::Scale(cable) => change.scale[cable] = by * SCALE_UNIT,
        }
        change
    }

    /// How the ends move when one edge of the triangle grows: P1 stays, P2 stays on its line, P3 in its plane.
    fn with_edge(&self, edge: usize, by: f64) -> [Vector3<f64>; CABLES] {
        let [p1, p2, p3] = self.arm.end_points_mm();
        let x = (p2 - p1).normalize();
        let y = ((p3 - p1) - x * (p3 - p1).dot(&x)).normalize();
        let mut edges = [(p2 - p1).norm(), (p3 - p2).norm(), (p1 - p3).norm()];
        edges[edge] += by;
        let [p12, p23, p31] = edges;
        let along = (p12 * p12 + p31 * p31 - p23 * p23) / (2.0 * p12);
        let moved = [*p1, p1 + x * p12, p1 + x * along + y * (p31 * p31 - along * along).sqrt()];
        std::array::from_fn(|cable| moved[cable / 2] - self.arm.end_points_mm()[cable / 2])
    }

    fn readings(&self, pose: &Rotation3<f64>, change: &Change) -> [f64; CABLES] {
        let centre = self.arm.centre_mm() + change.centre_mm;
        let ends = std::array::from_fn(|k| {
            centre + pose * (self.arm.ends_mm()[k] + change.ends_mm[k] - change.in_platform_mm)
        });
        let lengths = self.cables.moved(&change.base_mm).lengths_mm(&ends);
        std::array::from_fn(|k| lengths[k] + change.scale[k] * (lengths[k] - self.home_mm[k]) + change.offset_mm[k])
    }

    /// What the six readings of one pose tell when the pose's own rotation is unknown, for a noise of 1 mm. None for a
    /// pose whose turn the lengths do not show.
    fn information(&self, pose: &Rotation3<f64>) -> Option<DMatrix<f64>> {
        let column = |plus: [f64; CABLES], minus: [f64; CABLES], step: f64| {
            std::array::from_fn::<f64, CABLES, _>(|k| (plus[k] - minus[k]) / (2.0 * step))
        };
        let by_unknown = |unknown: &Unknown| {
            let at = |by: f64| self.readings(pose, &self.change(*unknown, by));
            column(at(STEP_MM), at(-STEP_MM), STEP_MM)
        };
        let by_turn = |axis: usize| {
            let at = |by: f64| self.readings(&(rotation(Vector3::ith(axis, 1.0), by) * pose), &Change::default());
            column(at(STEP_RAD), at(-STEP_RAD), STEP_RAD)
        };
        let columns: Vec<_> = self.unknowns.iter().flat_map(by_unknown).collect();
        let jacobian = DMatrix::from_vec(CABLES, self.unknowns.len(), columns);
        let turns = DMatrix::from_vec(CABLES, 3, (0..3).flat_map(by_turn).collect());
        let mixed = jacobian.tr_mul(&turns);
        let of_turn = turns.tr_mul(&turns).cholesky()?.inverse();
        Some(jacobian.tr_mul(&jacobian) - &mixed * of_turn * mixed.transpose())
    }

    /// Derivative of x, y, z, p1, p2, p3 with the unknowns.
    fn results(&self) -> DMatrix<f64> {
        let mut rows = DMatrix::zeros(6, self.unknowns.len());
        let frame = Frame::new(self.points());
        for (index, unknown) in self.unknowns.iter().enumerate() {
            let change = self.change(*unknown, STEP_MM);
            let moved = change.centre_mm - frame.motion_of(&self.moved_points(&change), self.arm.centre_mm());
            for axis in 0..3 {
                rows[(axis, index)] = moved[axis] / STEP_MM;
            }
            for point in 0..POINTS {
                let moved = (change.ends_mm[2 * point] + change.ends_mm[2 * point + 1]) / 2.0 - change.in_platform_mm;
                let end = self.arm.end_points_mm()[point];
                rows[(3 + point, index)] = ((end + moved).norm() - end.norm()) / STEP_MM;
            }
        }
        rows
    }

    /// The attachment points; of the 3-3 machine each once.
    fn points(&self) -> Vec<Vector3<f64>> {
        self.of_points(self.cables.base_mm())
    }

    fn moved_points(&self, change: &Change) -> Vec<Vector3<f64>> {
        self.of_points(&change.base_mm)
    }

    fn of_points(&self, of_cables: &[Vector3<f64>; CABLES]) -> Vec<Vector3<f64>> {
        // B1, B2, B3 are where cables 1, 2 and 4 begin.
        if self.is_three_three { [0, 1, 3].map(|cable| of_cables[cable]).to_vec() } else { of_cables.to_vec() }
    }
}

/// The frame best fitted to points: how it moves when they do, to first order.
struct Frame {
    points: Vec<Vector3<f64>>,
    middle: Vector3<f64>,
    inverse_inertia: Matrix3<f64>,
}

impl Frame {
    fn new(points: Vec<Vector3<f64>>) -> Self {
        let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let inertia: Matrix3<f64> = points
            .iter()
            .map(|p| p - middle)
            .map(|r| Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose())
            .sum();
        Self { inverse_inertia: inertia.try_inverse().unwrap_or_else(Matrix3::zeros), points, middle }
    }

    /// How far a place fixed to the frame moves when the points move by `moved`.
    fn motion_of(&self, moved: &[Vector3<f64>], place: &Vector3<f64>) -> Vector3<f64> {
        let shift = moved.iter().sum::<Vector3<f64>>() / moved.len() as f64;
        let momentum: Vector3<f64> = self.points.iter().zip(moved).map(|(p, by)| (p - self.middle).cross(by)).sum();
        shift + (self.inverse_inertia * momentum).cross(&(place - self.middle))
    }
}
