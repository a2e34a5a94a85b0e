//! Where the arm really is in the machine.

use glenoid::rig::{CABLES, POINTS, Parameters, Rig};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// The arm in the machine: its joint centre, and the platform's end-points about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedArm {
    centre_mm: Vector3<f64>,
    /// From {P} to the axes of {B} at home.
    turn: Matrix3<f64>,
    /// Where O is in {P} but for the cuff, and how far that is moved on the arm, axes of {B} at home.
    drawn_in_platform_mm: Vector3<f64>,
    cuff_offset_mm: Vector3<f64>,
    end_points_mm: [Vector3<f64>; POINTS],
    ends_mm: [Vector3<f64>; CABLES],
}

impl FittedArm {
    /// The arm of a rig's nominal parameters, then moved: the joint centre by `centre_offset_mm` in {B}, the platform
    /// by `cuff_offset_mm` on the arm (axes of {B} at home), both mm.
    ///
    /// At home the platform is parallel to the xy plane of {B}, and P1 lies on the side of the middle between B1 and
    /// B2, as in the paper's Fig. 2, so that a symmetric rig has six equal cables there.
    pub fn new(rig: &Rig<f64>, centre_offset_mm: Vector3<f64>, cuff_offset_mm: Vector3<f64>) -> Self {
        let nominal = rig.nominal();
        let [p1, p2, p3] = rig.platform_mm();
        let centre_in_platform = centre_below(&[p1, p2, p3], &nominal.radii_mm);
        let turn = home_orientation(rig, p1 - (p1 + p2 + p3) / 3.0);
        let at_home = |p: Vector3<f64>| turn * (p - centre_in_platform) + cuff_offset_mm;
        let end_points_mm = [p1, p2, p3].map(at_home);
        let ends_mm = match rig.cables() {
            Some(cables) => cables.each_ref().map(|cable| at_home(cable.end_mm)),
            None => std::array::from_fn(|cable| end_points_mm[cable / 2]),
        };
        Self {
            centre_mm: nominal.centre_mm + centre_offset_mm,
            turn,
            drawn_in_platform_mm: centre_in_platform,
            cuff_offset_mm,
            end_points_mm,
            ends_mm,
        }
    }

    /// Where a point fixed in {P} stands in {B} with the arm at a rotation from home, mm.
    pub fn carried_mm(&self, rotation: &Rotation3<f64>, point_mm: &Vector3<f64>) -> Vector3<f64> {
        self.centre_mm + rotation * (self.turn * (point_mm - self.drawn_in_platform_mm) + self.cuff_offset_mm)
    }

    /// The joint centre in {P}, mm.
    pub fn centre_in_platform_mm(&self) -> Vector3<f64> {
        self.drawn_in_platform_mm - self.turn.transpose() * self.cuff_offset_mm
    }

    /// Joint centre O in {B}, mm.
    pub fn centre_mm(&self) -> &Vector3<f64> {
        &self.centre_mm
    }

    /// OP_1..OP_3 at home, axes of {B}, mm.
    pub fn end_points_mm(&self) -> &[Vector3<f64>; POINTS] {
        &self.end_points_mm
    }

    /// Where the six cables end, from O at home, axes of {B}, mm. Where each two end at one point, that is OP_1..OP_3.
    pub fn ends_mm(&self) -> &[Vector3<f64>; CABLES] {
        &self.ends_mm
    }

    /// What an identification should find, mm.
    pub fn truth(&self) -> Parameters<f64> {
        let radii_mm = self.end_points_mm.map(|p| libm::sqrt(p.norm_squared()));
        Parameters { centre_mm: self.centre_mm, radii_mm }
    }
}

/// The point below the platform (on its base side, z < 0 in {P}) that has the given distances from its three
/// end-points, mm, by trilateration: subtracting two spheres leaves a plane.
fn centre_below(&[p1, p2, p3]: &[Vector3<f64>; POINTS], &[r1, r2, r3]: &[f64; POINTS]) -> Vector3<f64> {
    let (u, v) = (p2 - p1, p3 - p1);
    let x = (r1 * r1 - r2 * r2 + u.norm_squared()) / (2.0 * u.x);
    let y = (r1 * r1 - r3 * r3 + v.norm_squared() - 2.0 * v.x * x) / (2.0 * v.y);
    p1 + Vector3::new(x, y, -libm::sqrt(r1 * r1 - x * x - y * y))
}

/// The turn about z that brings P1, which lies at `p1` from the middle of the platform, over the middle of B1 B2.
fn home_orientation(rig: &Rig<f64>, p1: Vector3<f64>) -> Matrix3<f64> {
    let [b1, b2, b3] = rig.base_mm();
    let target = (b1 + b2) / 2.0 - (b1 + b2 + b3) / 3.0;
    let (cosine, sine) = (p1.x * target.x + p1.y * target.y, p1.x * target.y - p1.y * target.x);
    let length = libm::hypot(cosine, sine);
    let (c, s) = (cosine / length, sine / length);
    // {P} has its z axis away from the base, {B} towards the platform: the same way.
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}
