//! A virtual elbow: a built machine, the hinge of the arm in it, and what the encoders read.

use crate::study::built::best_fit;
use crate::study::scene::{normal, symmetric};
use crate::wearer::length_mm;
use glenoid::identification::hinge::{Hinge, HingeRig, MAX_CABLES};
use glenoid::rig::{CableEnds, Pulley, RigError, Tolerance};
use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};
use rand::Rng;

/// Noise of every length, uniform within this to either side, mm.
pub const NOISE_MM: f64 = 0.1;
/// Its standard deviation, mm: 0.1 / √3.
pub const NOISE_SIGMA_MM: f64 = 0.057_735_026_918_962_58;

/// Rings on the upper arm and the forearm, mm, and by how much an end is turned against its base point, to either side
/// alternately, degrees.
const BASE_RADIUS_MM: f64 = 60.0;
const END_RADIUS_MM: f64 = 45.0;
const ALTERNATING_DEG: f64 = 25.0;
/// The axis beyond the one ring and before the other, mm.
const AXIS_BEYOND_MM: f64 = 160.0;
const AXIS_BEFORE_MM: f64 = 70.0;
/// Lengths at count zero, mm.
pub const HOME_MM: [f64; MAX_CABLES] = [230.0; MAX_CABLES];

/// The default rig's cables: four on either ring.
pub fn cables() -> [CableEnds<f64>; MAX_CABLES] {
    std::array::from_fn(|k| {
        let azimuth = (45.0 + 90.0 * k as f64).to_radians();
        let turned = azimuth + ALTERNATING_DEG.to_radians() * if k % 2 == 0 { 1.0 } else { -1.0 };
        CableEnds {
            base_mm: Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth) * (Vector3::x() * BASE_RADIUS_MM),
            end_mm: Rotation3::from_axis_angle(&Vector3::z_axis(), turned) * (Vector3::x() * END_RADIUS_MM),
            pulley: Pulley::none(),
        }
    })
}

/// The hinge that the default rig is drawn for.
pub fn drawn() -> Hinge<f64> {
    let (x, z) = (Vector3::x(), Vector3::z());
    Hinge::through(&x, &(z * AXIS_BEYOND_MM), &x, &(z * -AXIS_BEFORE_MM))
}

/// An elbow with its machine. The model is written out here, sharing nothing with the library's.
#[derive(Debug, Clone)]
pub struct Elbow {
    /// As stated.
    pub stated: Vec<CableEnds<f64>>,
    /// As built, mm.
    base_mm: Vec<Vector3<f64>>,
    end_mm: Vec<Vector3<f64>>,
    offset_mm: Vec<f64>,
    scale: Vec<f64>,
    axis: Vector3<f64>,
    axis_in_platform: Vector3<f64>,
    /// A point of the axis in either body, which coincide, mm.
    point_mm: Vector3<f64>,
    point_in_platform_mm: Vector3<f64>,
}

impl Elbow {
    /// Somebody's elbow in the default rig with so many cables: axes off by some 9 degrees, places by some 12 and 8 mm, the
    /// forearm's frame anywhere; the machine off by normal errors of `truth`'s sizes.
    pub fn random(random: &mut impl Rng, cables: usize, truth: &Tolerance<f64>) -> Self {
        let vector = |random: &mut _, size: f64| Vector3::from_fn(|_, _| normal(random) * size);
        let axis = (Vector3::x() + vector(random, 0.15)).normalize();
        let axis_in_platform = (Vector3::x() + vector(random, 0.15)).normalize();
        let point = Vector3::z() * AXIS_BEYOND_MM + vector(random, 12.0) + axis * (normal(random) * 5.0);
        let point_in_platform = -Vector3::z() * AXIS_BEFORE_MM + vector(random, 8.0);
        let frame = UnitQuaternion::from_scaled_axis(vector(random, 1.0)).to_rotation_matrix();
        let origin = vector(random, 20.0);
        let mut stated = self::cables()[..cables].to_vec();
        stated.iter_mut().for_each(|cable| cable.end_mm = frame * cable.end_mm + origin);
        Self {
            axis,
            axis_in_platform: frame * axis_in_platform,
            point_mm: point,
            point_in_platform_mm: frame * point_in_platform + origin,
            ..Self::built(random, stated, truth)
        }
    }

    /// The elbow of the drawing moved by a step of the hinge's unknowns, in the drawn frames.
    pub fn of_hinge(random: &mut impl Rng, cables: usize, hinge: &Hinge<f64>, truth: &Tolerance<f64>) -> Self {
        Self::of_rig(random, self::cables()[..cables].to_vec(), hinge, truth)
    }

    /// This hinge in a machine with these cables.
    pub fn of_rig(
        random: &mut impl Rng,
        stated: Vec<CableEnds<f64>>,
        hinge: &Hinge<f64>,
        truth: &Tolerance<f64>,
    ) -> Self {
        Self {
            axis: *hinge.axis(),
            axis_in_platform: hinge.axis_in_platform(),
            point_mm: hinge.platform_foot_mm(),
            point_in_platform_mm: *hinge.foot_in_platform_mm(),
            ..Self::built(random, stated, truth)
        }
    }

    fn built(random: &mut impl Rng, stated: Vec<CableEnds<f64>>, truth: &Tolerance<f64>) -> Self {
        let mut error = |size: f64| normal(random) * size;
        let base_mm =
            stated.iter().map(|cable| cable.base_mm + Vector3::from_fn(|_, _| error(truth.base_mm))).collect();
        let end_mm = stated.iter().map(|cable| cable.end_mm + Vector3::from_fn(|_, _| error(truth.edges_mm))).collect();
        let offset_mm = stated.iter().map(|_| error(truth.offset_mm)).collect();
        let scale = stated.iter().map(|_| 1.0 + error(truth.drum)).collect();
        let zero = Vector3::zeros();
        Self {
            stated,
            base_mm,
            end_mm,
            offset_mm,
            scale,
            axis: zero,
            axis_in_platform: zero,
            point_mm: zero,
            point_in_platform_mm: zero,
        }
    }

    /// The machine's base has slipped on the upper arm: the axis stands elsewhere in it, by this, mm.
    #[must_use]
    pub fn with_axis_moved(self, by_mm: &Vector3<f64>) -> Self {
        Self { point_mm: self.point_mm + by_mm, ..self }
    }

    /// The cuff has slipped on the forearm: the axis stands elsewhere in it, by this, mm.
    #[must_use]
    pub fn with_cuff_moved(self, by_mm: &Vector3<f64>) -> Self {
        Self { point_in_platform_mm: self.point_in_platform_mm + by_mm, ..self }
    }

    /// The rig as stated, with these tolerances.
    ///
    /// # Errors
    /// None in practice.
    pub fn rig(&self, tolerance: Tolerance<f64>) -> Result<HingeRig<f64>, RigError> {
        HingeRig::new(&self.stated, NOISE_SIGMA_MM)?.with_tolerance(tolerance, HOME_MM)
    }

    /// The hinge in the frames best fitted to the points as they are.
    pub fn hinge(&self) -> Hinge<f64> {
        let ([turn, turn_platform], [shift, shift_platform]) = self.frames();
        Hinge::through(
            &(turn * self.axis),
            &(turn * self.point_mm + shift),
            &(turn_platform * self.axis_in_platform),
            &(turn_platform * self.point_in_platform_mm + shift_platform),
        )
    }

    /// Where a point fixed in {P} stands in {B} at this flexion, both frames best fitted to the points as they are, mm.
    pub fn carried_mm(&self, point_mm: &Vector3<f64>, flexion_rad: f64) -> Vector3<f64> {
        let ([turn, turn_platform], [shift, shift_platform]) = self.frames();
        let in_body = turn_platform.transpose() * (point_mm - shift_platform);
        turn * self.at_mm(&in_body, flexion_rad, None) + shift
    }

    /// From the bodies as built to {B} and {P}.
    fn frames(&self) -> ([Matrix3<f64>; 2], [Vector3<f64>; 2]) {
        let of = |points: fn(&CableEnds<f64>) -> Vector3<f64>| -> Vec<Vector3<f64>> {
            self.stated.iter().map(points).collect()
        };
        let (turn, shift) = best_fit(&self.base_mm, &of(|cable| cable.base_mm));
        let (turn_platform, shift_platform) = best_fit(&self.end_mm, &of(|cable| cable.end_mm));
        ([turn, turn_platform], [shift, shift_platform])
    }

    /// A point of the platform in the base at this flexion, and turned about another axis through the elbow before that.
    pub fn at_mm(
        &self,
        point_mm: &Vector3<f64>,
        flexion_rad: f64,
        second: Option<(Vector3<f64>, f64)>,
    ) -> Vector3<f64> {
        let mut arm = point_mm - self.point_in_platform_mm;
        if let Some((axis, angle)) = second {
            arm = Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle) * arm;
        }
        self.point_mm + self.rotation(flexion_rad) * arm
    }

    /// Rotation of the platform at this flexion.
    pub fn rotation(&self, flexion_rad: f64) -> Rotation3<f64> {
        let align = Rotation3::rotation_between(&self.axis_in_platform, &self.axis).unwrap_or_else(|| {
            Rotation3::from_axis_angle(&Unit::new_normalize(across(&self.axis)[0]), std::f64::consts::PI)
        });
        Rotation3::from_axis_angle(&Unit::new_normalize(self.axis), flexion_rad) * align
    }

    /// Direction of the axis in the platform as built.
    pub fn axis_in_platform(&self) -> &Vector3<f64> {
        &self.axis_in_platform
    }

    /// What the encoders read without noise, mm; 0 for cables that the rig has not.
    pub fn reading_mm(&self, flexion_rad: f64, second: Option<(Vector3<f64>, f64)>) -> [f64; MAX_CABLES] {
        std::array::from_fn(|k| {
            let Some(end) = self.end_mm.get(k) else { return 0.0 };
            let length = length_mm(&(self.at_mm(end, flexion_rad, second) - self.base_mm[k]), &self.stated[k].pulley);
            HOME_MM[k] + self.scale[k] * (length - HOME_MM[k]) + self.offset_mm[k]
        })
    }

    /// A set of readings over a range of flexion, degrees, with noise, mm.
    pub fn readings_mm(&self, random: &mut impl Rng, flexions_rad: &[f64]) -> Vec<[f64; MAX_CABLES]> {
        let cables = self.stated.len();
        let mut reading = |flexion: &f64| {
            let mut reading = self.reading_mm(*flexion, None);
            reading.iter_mut().take(cables).for_each(|length| *length += symmetric(random, NOISE_MM));
            reading
        };
        flexions_rad.iter().map(&mut reading).collect()
    }
}

/// Two directions across an axis: those of the library, whose choice is part of what its covariance means.
pub fn across(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let other = if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    let first = (other - axis * axis.dot(&other)).normalize();
    [first, axis.cross(&first)]
}

/// Flexions, uniform from 0 to `most_deg`; an elbow bends to one side.
pub fn flexions_rad(random: &mut impl Rng, poses: usize, most_deg: f64) -> Vec<f64> {
    (0..poses).map(|_| -random.random_range(0.0..=most_deg).to_radians()).collect()
}
