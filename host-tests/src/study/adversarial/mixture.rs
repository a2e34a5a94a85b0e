//! A random set with random evils.

use crate::study::findings::Problem;
use crate::study::scene::{Reach, Scene, Spread, normal, symmetric, tilted, with_noise};
use crate::study::trials;
use crate::wearer::rotation;
use glenoid::rig::CABLES;
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use rand::seq::index::sample;
use std::fmt::Write as _;

/// One set of poses whose truth is known.
#[derive(Debug, Clone)]
pub struct Case {
    /// Rig and arm.
    pub scene: Scene,
    /// Measured lengths.
    pub poses_mm: Vec<[f64; CABLES]>,
    /// The evil it counts under: one of the kinds, or `several`.
    pub kind: &'static str,
    /// What is wrong with it, in words.
    pub description: String,
}

/// What a set can count under.
pub(super) const KINDS: [&str; 9] = [
    "none",
    "outliers",
    "wander",
    "degenerate",
    "exchanged in some",
    "exchanged in all",
    "glitch",
    "small motion",
    "several",
];

/// Noise of every length, uniform, mm.
const NOISE_MM: f64 = 0.1;

/// The `trial`-th case of a seed.
///
/// # Errors
/// None in practice: when the paper's rig is none.
pub fn case(seed: u64, trial: u64) -> Result<Case, Problem> {
    let mut random = trials::random(seed, super::STUDY.name, trial);
    let mut builder = Builder::new(&mut random)?;
    if random.random_bool(0.2) {
        builder.degenerate(&mut random);
    }
    builder.measure(&mut random);
    if random.random_bool(0.45) {
        builder.outliers(&mut random);
    }
    if random.random_bool(0.1) {
        builder.exchange(&mut random);
    }
    if random.random_bool(0.1) {
        builder.glitch(&mut random);
    }
    Ok(builder.finish())
}

struct Builder {
    scene: Scene,
    rotations: Vec<Rotation3<f64>>,
    poses_mm: Vec<[f64; CABLES]>,
    kinds: Vec<&'static str>,
    description: String,
}

impl Builder {
    /// A rig, a number of poses, and how far the arm moves.
    fn new(random: &mut impl Rng) -> Result<Self, Problem> {
        let poses = if random.random_bool(0.5) { random.random_range(4..=15) } else { random.random_range(4..=100) };
        let extreme = random.random_bool(0.3);
        let (scene, rig) = if random.random_bool(0.5) {
            (Scene::table_1(150.0)?.worn(random, if extreme { 60.0 } else { 20.0 }, 10.0), "150 mm rig")
        } else {
            let spread = if extreme { Spread::EXTREME } else { Spread::ANY_RIG };
            (Scene::random(random, &spread)?, "random rig")
        };
        let small = random.random_bool(0.1);
        let reach = if small {
            Reach { tilt_deg: random.random_range(2.0..15.0), torsion_deg: random.random_range(0.0..10.0) }
        } else if extreme {
            Reach::EXTREME
        } else {
            Reach::USUAL
        };
        let Reach { tilt_deg, torsion_deg } = reach;
        Ok(Self {
            scene,
            rotations: (0..poses).map(|_| reach.rotation(random)).collect(),
            poses_mm: Vec::new(),
            kinds: if small { vec!["small motion"] } else { Vec::new() },
            description: format!("{rig}, {poses} poses, tilt {tilt_deg:.1}°, torsion {torsion_deg:.1}°"),
        })
    }

    fn add(&mut self, kind: &'static str, detail: &str) {
        self.kinds.push(kind);
        let _ = write!(self.description, "; {kind}: {detail}");
    }

    /// Replaces the motion by a degenerate one, but for a few poses.
    fn degenerate(&mut self, random: &mut impl Rng) {
        let odd = random.random_range(0..=3usize).min(self.rotations.len() - 1);
        let family = random.random_range(0..4);
        let axis = Vector3::from_fn(|_, _| normal(random));
        let pair = [Reach::USUAL.rotation(random), Reach::USUAL.rotation(random)];
        let azimuth = random.random_range(0.0..std::f64::consts::TAU);
        let middle = Reach::USUAL.rotation(random);
        for rotation_ in self.rotations.iter_mut().skip(odd) {
            *rotation_ = match family {
                0 => rotation(axis, symmetric(random, 45.0).to_radians()) * middle,
                1 => pair[random.random_range(0..2)],
                2 => rotation(Vector3::from_fn(|_, _| normal(random)), symmetric(random, 2.0).to_radians()) * middle,
                _ => tilted(azimuth, symmetric(random, 45.0)),
            };
        }
        let name = ["one axis", "two rotations", "within 2°", "one plane"][family];
        self.add("degenerate", &format!("{name} but for {odd} poses"));
    }

    /// Lengths with noise, about a centre that may migrate.
    fn measure(&mut self, random: &mut impl Rng) {
        let migration_mm = if random.random_bool(0.15) { random.random_range(0.02..3.0) } else { 0.0 };
        for rotation in &self.rotations {
            let centre = self.scene.centre_mm + Vector3::from_fn(|_, _| normal(random)) * migration_mm;
            self.poses_mm.push(with_noise(self.scene.lengths_about(&centre, rotation), random, NOISE_MM));
        }
        if migration_mm > 0.0 {
            self.add("wander", &format!("{migration_mm:.3} mm"));
        }
    }

    /// One wrong cable in up to 40 % of the poses.
    fn outliers(&mut self, random: &mut impl Rng) {
        let poses = self.poses_mm.len();
        let bad = random.random_range(1..=(poses * 2 / 5).max(1));
        let mut detail = String::new();
        for pose in sample(random, poses, bad) {
            let (cable, size) = (random.random_range(0..CABLES), random.random_range(2.0..50.0));
            let size = if random.random_bool(0.5) { size } else { -size };
            self.poses_mm[pose][cable] += size;
            let _ = write!(detail, "({pose}, cable {}, {size:+.2} mm) ", cable + 1);
        }
        self.add("outliers", detail.trim_end());
    }

    /// Two cables exchanged, in a few poses or in all.
    fn exchange(&mut self, random: &mut impl Rng) {
        let pair = sample(random, CABLES, 2);
        let (i, j) = (pair.index(0), pair.index(1));
        let poses = self.poses_mm.len();
        let (kind, which) = if random.random_bool(0.3) {
            ("exchanged in all", (0..poses).collect())
        } else {
            let few = random.random_range(1..=3usize);
            ("exchanged in some", sample(random, poses, few).into_vec())
        };
        for &pose in &which {
            self.poses_mm[pose].swap(i, j);
        }
        let where_ = if which.len() == poses { String::new() } else { format!(" in poses {which:?}") };
        self.add(kind, &format!("cables {} and {}{where_}", i + 1, j + 1));
    }

    /// One length that is far off.
    fn glitch(&mut self, random: &mut impl Rng) {
        let (pose, cable) = (random.random_range(0..self.poses_mm.len()), random.random_range(0..CABLES));
        let length = &mut self.poses_mm[pose][cable];
        let before = *length;
        *length = match random.random_range(0..4) {
            0 => before * 10.0,
            1 => before * 0.01,
            2 => before + random.random_range(50.0..300.0),
            _ => (before - random.random_range(50.0..300.0)).abs() + 0.001,
        };
        let detail = format!("({pose}, cable {}, {:+.1} mm)", cable + 1, *length - before);
        self.add("glitch", &detail);
    }

    fn finish(self) -> Case {
        let kind = match self.kinds[..] {
            [] => "none",
            [one] => one,
            _ => "several",
        };
        Case { scene: self.scene, poses_mm: self.poses_mm, kind, description: self.description }
    }
}
