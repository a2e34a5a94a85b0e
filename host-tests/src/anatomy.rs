//! Shoulders whose joint centre moves: the scapulohumeral rhythm that de Groot and Brand measured (Clinical Biomechanics 16,
//! 2001, 735-743), with bones of usual lengths.
//!
//! Their regressions give the angles of clavicle and shoulder blade from the arm's plane of elevation and elevation and from
//! the person's posture at rest, in degrees, in a frame of the thorax with x to the right, y up, z backwards. The centre is
//! that of the glenoid, at the end of clavicle and shoulder blade; the head also slides on it.

use crate::wearer::rotation;
use glenoid::kinematics::rotation::rotation_vector;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Constant, slope with the plane of elevation, slope with elevation, slope with the angle at rest.
type Regression = [f64; 4];

/// Clavicle about y and z, shoulder blade about y, z and x.
const RHYTHM: [Regression; 5] = [
    [-4.983, 0.120, -0.242, 0.851],
    [3.917, -0.046, 0.123, 0.493],
    [-1.203, 0.140, -0.049, 0.901],
    [3.095, -0.079, 0.396, 0.414],
    [0.659, -0.028, 0.184, 0.886],
];
/// The same angles at rest, of the Delft model, degrees.
const REST_DEG: [f64; 5] = [-28.573, 11.680, 32.047, 10.669, -10.320];
/// People differ from these (assumed): posture, degrees; slopes, relative; bones, mm.
const POSTURE_SD_DEG: f64 = 4.0;
const SLOPE_SD: f64 = 0.15;
const CLAVICLE_MM: (f64, f64) = (150.0, 8.0);
/// Centre of the glenoid from the acromion, in the shoulder blade, and its spread, mm.
const GLENOID_MM: ([f64; 3], f64) = ([-10.0, -40.0, -10.0], 4.0);
/// The head slides on the glenoid by so much per radian of the arm's direction in the shoulder blade, mm.
const SLIDE_MM: f64 = 1.0;
/// The same per radian of torsion, 1σ along each axis, mm.
const SLIDE_BY_TORSION_MM: f64 = 0.3;
/// The arm at home: plane of elevation (0 sideways, 90 forwards) and elevation, degrees.
const HOME_DEG: (f64, f64) = (35.0, 70.0);
/// Steps of the iteration for the base that follows the shoulder blade: each leaves less than half of the error.
const STEPS: usize = 40;

/// One person's shoulder, and how the machine's base is worn on it.
#[derive(Debug, Clone)]
pub struct Shoulder {
    rhythm: [Regression; 5],
    rest_deg: [f64; 5],
    clavicle_mm: f64,
    glenoid_mm: Vector3<f64>,
    slide_mm: Matrix3<f64>,
    slide_by_torsion_mm: Vector3<f64>,
    /// 0: the base rests on the thorax, 1: it goes with the shoulder blade.
    follow: f64,
    /// Axes of {B} at home, in the thorax.
    base: Matrix3<f64>,
    home: (Matrix3<f64>, Vector3<f64>),
}

impl Shoulder {
    /// The person with this number. `follow`: the share of the shoulder blade's motion that the base makes, 0 (worn on
    /// the thorax) to 1.
    pub fn new(person: u64, follow: f64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(0x5348_0000 + person);
        let mut normal = || normal(&mut random);
        let rest_deg = REST_DEG.map(|rest| rest + POSTURE_SD_DEG * normal());
        let rhythm = RHYTHM.map(|[constant, by_plane, by_elevation, by_rest]| {
            [constant, by_plane * (1.0 + SLOPE_SD * normal()), by_elevation * (1.0 + SLOPE_SD * normal()), by_rest]
        });
        let clavicle_mm = CLAVICLE_MM.0 + CLAVICLE_MM.1 * normal();
        let glenoid_mm = Vector3::from(GLENOID_MM.0.map(|mean| mean + GLENOID_MM.1 * normal()));
        let slide = Matrix3::from_fn(|_, _| normal());
        let slide_by_torsion_mm = Vector3::from_fn(|_, _| SLIDE_BY_TORSION_MM * normal());
        let arm = about(1, HOME_DEG.0) * about(2, HOME_DEG.1);
        // The arm hangs along -y of its bone; z of {B} is along the arm.
        let (z, x) = (-arm.column(1), arm.column(0).into_owned());
        let mut shoulder = Self {
            rhythm,
            rest_deg,
            clavicle_mm,
            glenoid_mm,
            slide_mm: slide * (SLIDE_MM / slide.norm()),
            slide_by_torsion_mm,
            follow,
            base: Matrix3::from_columns(&[x, z.cross(&x), z]),
            home: (Matrix3::identity(), Vector3::zeros()),
        };
        shoulder.home = shoulder.bones(&z);
        shoulder
    }

    /// Rotation of the shoulder blade and centre of the glenoid, mm, in the thorax, for a direction of the arm.
    fn bones(&self, arm: &Vector3<f64>) -> (Matrix3<f64>, Vector3<f64>) {
        let (plane, elevation) = plane_and_elevation_deg(arm);
        let angle = |index: usize| {
            let [constant, by_plane, by_elevation, by_rest] = self.rhythm[index];
            constant + by_plane * plane + by_elevation * elevation + by_rest * self.rest_deg[index]
        };
        let clavicle = about(1, angle(0)) * about(2, angle(1));
        let blade = about(1, angle(2)) * about(2, angle(3)) * about(0, angle(4));
        (blade, clavicle.column(0) * self.clavicle_mm + blade * self.glenoid_mm)
    }

    /// Where the joint centre has moved in {B} from its place at home when the arm is at a rotation from home in {B}, mm.
    pub fn displacement_mm(&self, arm: &Rotation3<f64>) -> Vector3<f64> {
        let (home_blade, home_centre) = &self.home;
        let z = Vector3::z();
        // The base at this pose, in the thorax: it depends on the shoulder blade, that on the arm, that on the base.
        let mut base = self.base;
        let (mut blade, mut centre) = self.home;
        for _ in 0..STEPS {
            (blade, centre) = self.bones(&(base * (arm.matrix() * z)));
            let turned = rotation_vector(home_blade, &blade) * self.follow;
            base = turn(turned) * self.base;
        }
        let moved = base.transpose() * (centre - home_centre) * (1.0 - self.follow);
        // The arm's direction and torsion seen from the shoulder blade.
        let in_thorax = base * arm.matrix() * self.base.transpose();
        let in_blade = (blade * home_blade.transpose()).transpose() * in_thorax;
        let seen = self.base.transpose() * in_blade * self.base;
        let torsion = libm::atan2(seen.m21 - seen.m12, seen.m11 + seen.m22);
        let slid = self.slide_mm * (seen * z - z) + self.slide_by_torsion_mm * torsion;
        moved + slid
    }

    /// Can this arm be there: between the elevations for which the regressions were measured.
    pub fn reaches(&self, arm: &Rotation3<f64>) -> bool {
        let direction = self.base * (arm.matrix() * Vector3::z());
        let (plane, elevation) = plane_and_elevation_deg(&direction);
        (25.0..130.0).contains(&elevation) && (-40.0..130.0).contains(&plane)
    }

    /// Slides of the head that follow nothing, 1σ `sigma_mm` along each axis, mm.
    pub fn scatter_mm(random: &mut impl Rng, sigma_mm: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| normal(random) * sigma_mm)
    }
}

/// Plane of elevation and elevation of an arm's direction in the thorax, degrees.
fn plane_and_elevation_deg(arm: &Vector3<f64>) -> (f64, f64) {
    (libm::atan2(-arm.z, arm.x).to_degrees(), libm::acos((-arm.y).clamp(-1.0, 1.0)).to_degrees())
}

/// A number from the normal distribution (Box and Muller 1958), the same bits on every machine.
pub fn normal(random: &mut impl Rng) -> f64 {
    let (radius, angle): (f64, f64) = (1.0 - random.random::<f64>(), random.random::<f64>() * std::f64::consts::TAU);
    libm::sqrt(-2.0 * libm::log(radius)) * libm::cos(angle)
}

/// The rotation by a vector: axis times angle.
fn turn(vector: Vector3<f64>) -> Matrix3<f64> {
    let angle = vector.norm();
    if angle > 0.0 { rotation(vector, angle).into_inner() } else { Matrix3::identity() }
}

fn about(axis: usize, degrees: f64) -> Matrix3<f64> {
    let mut along = Vector3::zeros();
    along[axis] = 1.0;
    rotation(along, degrees.to_radians()).into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 30 degrees of tilt about an axis across the arm.
    fn tilted(azimuth: f64) -> Rotation3<f64> {
        rotation(Vector3::new(libm::cos(azimuth), libm::sin(azimuth), 0.0), 0.52)
    }

    #[test]
    fn at_home_the_centre_is_where_it_was() {
        for person in 0..4 {
            assert!(Shoulder::new(person, 0.5).displacement_mm(&Rotation3::identity()).norm() < 1e-12);
        }
    }

    /// On the thorax some 6 to 19 mm, on the shoulder blade only the slide of the head, as bone pins show.
    #[test]
    fn the_centre_moves_as_far_as_those_of_people() {
        for person in 0..8 {
            let rms = |follow: f64| {
                let shoulder = Shoulder::new(person, follow);
                let squares = (0..12).map(|k| {
                    shoulder.displacement_mm(&tilted(f64::from(k) * std::f64::consts::FRAC_PI_6)).norm_squared()
                });
                libm::sqrt(squares.sum::<f64>() / 12.0)
            };
            let (thorax, half, blade) = (rms(0.0), rms(0.5), rms(1.0));
            assert!((5.0..20.0).contains(&thorax), "{person}: {thorax}");
            assert!((0.1..1.0).contains(&blade), "{person}: {blade}");
            assert!(half < thorax && half > blade, "{person}: {thorax} {half} {blade}");
        }
    }

    /// The elevation of the clavicle and the upward rotation of the shoulder blade at rest and at 90 degrees of elevation
    /// in the frontal plane, by the paper's equations worked by hand from the mean posture.
    #[test]
    fn the_bones_turn_by_the_regressions() {
        let mut shoulder = Shoulder::new(0, 0.0);
        (shoulder.rhythm, shoulder.rest_deg) = (RHYTHM, REST_DEG);
        (shoulder.clavicle_mm, shoulder.glenoid_mm) = (100.0, Vector3::zeros());
        let (_, tip) = shoulder.bones(&Vector3::x());
        // Clavicle about y: -4.983 - 0.242 · 90 - 0.851 · 28.573 = -51.0786; about z: 3.917 + 0.123 · 90 + 0.493 · 11.680 = 20.7452.
        let (about_y, about_z) = (51.0786f64.to_radians(), 20.7452f64.to_radians());
        let expected =
            Vector3::new(about_y.cos() * about_z.cos(), about_z.sin(), about_y.sin() * about_z.cos()) * 100.0;
        assert!((tip - expected).norm() < 1e-3, "{tip} {expected}");
    }
}
