//! Families of motion that leave the centre free.

use crate::study::scene::{Reach, normal, symmetric, tilted};
use crate::wearer::rotation;
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use std::f64::consts::TAU;

/// Smallest angle between two distinct rotations, degrees.
const DISTINCT_DEG: f64 = 10.0;
/// A motion that leaves the centre free along an axis, or altogether.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Family {
    /// Turns by up to 30 degrees to either side about any axis, from any pose within 20 degrees of home.
    OneAxis,
    /// Two rotations of the usual reach, each again and again.
    TwoRotations,
    /// Turns by up to 2 degrees about any axes, from any pose.
    Alike,
    /// The arm turns about its own length alone, by up to 60 degrees.
    Torsion,
    /// The arm swings in one vertical plane, by up to 45 degrees.
    Plane,
}

/// All of them, with their names.
pub(super) const FAMILIES: [(&str, Family); 5] = [
    ("one axis", Family::OneAxis),
    ("two rotations", Family::TwoRotations),
    ("within 2°", Family::Alike),
    ("pure torsion", Family::Torsion),
    ("single plane", Family::Plane),
];

impl Family {
    /// The rotations of a set, and the common axis in {B}, if there is one.
    pub(super) fn rotations(self, random: &mut impl Rng, poses: usize) -> (Vec<Rotation3<f64>>, Option<Vector3<f64>>) {
        match self {
            Self::OneAxis => {
                let middle = Reach { tilt_deg: 20.0, torsion_deg: 20.0 }.rotation(random);
                let axis = direction(random);
                let turn = |_| rotation(axis, symmetric(random, 30.0).to_radians()) * middle;
                ((0..poses).map(turn).collect(), Some(axis))
            }
            Self::TwoRotations => {
                let first = Reach::USUAL.rotation(random);
                let (second, axis) = loop {
                    let second = Reach::USUAL.rotation(random);
                    let axis = twice_axis(&(second * first.inverse()));
                    if axis.norm() > 2.0 * libm::sin(DISTINCT_DEG.to_radians()) {
                        break (second, axis.normalize());
                    }
                };
                // Both occur at least once.
                let pick = |pose| match pose {
                    0 => first,
                    1 => second,
                    _ if random.random_bool(0.5) => first,
                    _ => second,
                };
                ((0..poses).map(pick).collect(), Some(axis))
            }
            Self::Alike => {
                let middle = Reach::USUAL.rotation(random);
                let turn = |_| rotation(direction(random), symmetric(random, 2.0).to_radians()) * middle;
                ((0..poses).map(turn).collect(), None)
            }
            Self::Torsion => {
                let turn = |_| rotation(Vector3::z(), symmetric(random, 60.0).to_radians());
                ((0..poses).map(turn).collect(), Some(Vector3::z()))
            }
            Self::Plane => {
                let azimuth = random.random_range(0.0..TAU);
                let turn = |_| tilted(azimuth, symmetric(random, 45.0));
                ((0..poses).map(turn).collect(), Some(Vector3::new(libm::cos(azimuth), libm::sin(azimuth), 0.0)))
            }
        }
    }
}

/// A direction in space, all alike.
fn direction(random: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(random)).normalize()
}

/// Axis of a rotation, times twice the sine of its angle.
fn twice_axis(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)])
}
