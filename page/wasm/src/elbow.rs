//! An elbow's machine for the picture: where the forearm stands at the lengths of its cables, by the hinge that is known best.

use super::json;
use super::mathematics::{placed_json, points_json};
use glenoid::identification::hinge::{Hinge, HingeAngles, HingeEstimator, HingeSettings, MAX_CABLES, MAX_CONSTANTS};
use glenoid::procedure::elbow::{ElbowRig, SHOWN_NUMBERS};
use nalgebra::Vector3;

/// The angles to begin from are laid out a few calls long; from one of them, so many calls settle.
const CALLS: usize = 256;
const SETTLING: usize = 8;
/// How far from either body the axis is drawn when nothing says where it is, mm.
const UNKNOWN_AXIS_MM: f32 = 160.0;

/// An elbow.
pub struct Elbow {
    rig: ElbowRig,
    /// The drawn hinge, until the board has shown another one.
    hinge: Option<Hinge<f32>>,
    /// Begins from all angles, whatever the lengths were before.
    angles: Option<HingeAngles<f32>>,
}

impl Elbow {
    /// The elbow of a rig, its hinge as drawn.
    pub fn new(rig: &ElbowRig) -> Self {
        let drawn = rig.hinge().drawing().map(|drawing| drawing.hinge);
        let mut elbow = Self { rig: rig.clone(), hinge: None, angles: None };
        elbow.set(drawn);
        elbow
    }

    fn set(&mut self, hinge: Option<Hinge<f32>>) {
        let estimator = HingeEstimator::new(self.rig.hinge(), HingeSettings::for_rig(self.rig.hinge()));
        let lengths_mm = self.home_mm();
        self.angles = hinge.as_ref().map(|hinge| {
            let mut angles = estimator.angles_of(hinge, &[0.0; MAX_CONSTANTS]);
            for _ in 0..CALLS {
                let before = angles.clone();
                if angles.follow(&lengths_mm).is_some() {
                    return before;
                }
            }
            angles
        });
        self.hinge = hinge;
    }

    fn home_mm(&self) -> [f32; MAX_CABLES] {
        let [l1, l2, l3, l4, ..] = self.rig.drum().home_length_mm;
        [l1, l2, l3, l4]
    }

    /// Takes the thirteen numbers of a hinge as the board shows them, singles, little-endian: axis and foot point in the base,
    /// in the platform, and the offset along the axis. Anything else: the drawn one again.
    pub fn take_hinge(&mut self, bytes: &[u8]) {
        let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let shown =
            <[f32; SHOWN_NUMBERS]>::try_from(numbers).ok().map(|[a, b, c, d, e, f, g, h, i, j, k, l, along]| {
                let axis = Vector3::new(a, b, c);
                let point_mm = Vector3::new(d, e, f) + axis * along;
                Hinge::through(&axis, &point_mm, &Vector3::new(g, h, i), &Vector3::new(j, k, l))
            });
        let drawn = || self.rig.hinge().drawing().map(|drawing| drawing.hinge);
        let hinge = shown.filter(Hinge::is_sound).or_else(drawn);
        self.set(hinge);
    }

    /// Where each cable begins and ends, where the axis is, and the forearm at count zero.
    pub fn machine(&self) -> String {
        let cables = self.rig.hinge().cables();
        let base: Vec<_> = cables.iter().map(|cable| cable.base_mm).collect();
        let ends: Vec<_> = cables.iter().map(|cable| cable.end_mm).collect();
        let (z, hinge) = (Vector3::z(), self.hinge.as_ref());
        let point = |vector: Vector3<f32>| json::list(vector.iter());
        let axis = hinge.map_or(Vector3::x(), |hinge| *hinge.axis());
        let at = hinge.map_or(z * UNKNOWN_AXIS_MM, Hinge::platform_foot_mm);
        let pivot = hinge.map_or(-z * UNKNOWN_AXIS_MM, |hinge| *hinge.foot_in_platform_mm());
        format!(
            "{{\"joint\":\"hinge\",\"base\":{},\"ends\":{ends},\"platform\":{ends},\"nominal\":{},\"axis\":{},\"pivot\":{},\"home\":{}}}",
            points_json(&base),
            point(at),
            point(axis),
            point(pivot),
            self.placed(&self.home_mm()),
            ends = points_json(&ends),
        )
    }

    /// Where the forearm stands at these lengths, singles, little-endian, and its angle: null where nothing says about what it
    /// turns.
    pub fn place(&self, bytes: &[u8]) -> String {
        let mut lengths_mm = [0.0; MAX_CABLES];
        for (length, bytes) in lengths_mm.iter_mut().zip(bytes.as_chunks::<4>().0) {
            *length = f32::from_le_bytes(*bytes);
        }
        self.placed(&lengths_mm)
    }

    fn placed(&self, lengths_mm: &[f32; MAX_CABLES]) -> String {
        let (Some(hinge), Some(mut angles)) = (&self.hinge, self.angles.clone()) else { return "null".to_owned() };
        let followed = (0..SETTLING).filter_map(|_| angles.follow(lengths_mm)).last();
        followed.map_or("null".to_owned(), |followed| {
            let rotation = hinge.rotation(followed.angle_rad);
            let origin_mm = hinge.platform_foot_mm() - rotation * hinge.foot_in_platform_mm();
            let shown = placed_json(&rotation, &origin_mm);
            let angle = json::number(followed.angle_rad.into());
            format!("{},\"angle\":{angle}}}", shown.trim_end_matches('}'))
        })
    }
}
