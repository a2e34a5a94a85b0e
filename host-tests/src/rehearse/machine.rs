//! The machine of a rehearsal: as the board knows it, and as it is built.

use super::options::Options;
use crate::identify::rig_file::{self, RigFile};
use crate::study::built::best_fit;
use crate::study::scene::normal;
use crate::wearer::{Cables, FittedArm};
use glenoid::parameters::ParameterSet;
use glenoid::procedure::Limits;
use glenoid::restart::Restart;
use glenoid::rig::{CABLES, CableEnds, Correction, Drum, Pulley, Rig, Tolerance};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// An elbow is rehearsed as part of an arm, or tried by hand.
const NO_ELBOW: &str = "an elbow is rehearsed by cargo rehearse --arm, or tried by cargo emulate --wearer --rig";

/// A machine as the board knows it.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownMachine {
    /// In double precision.
    pub double: Rig<f64>,
    /// As the board has it.
    pub single: Rig<f32>,
    /// The parameters that make the board this machine; `None` when it is compiled in.
    pub told: Option<ParameterSet>,
}

impl KnownMachine {
    /// The machine that is compiled in.
    ///
    /// # Errors
    /// Why it is none; a test rules that out.
    pub fn compiled_in() -> Result<Self, String> {
        let single =
            rig_of(&ParameterSet::new()).map_err(|at| format!("the defaults contradict each other at {at}"))?;
        Ok(Self { double: rig_file::default_rig().map_err(|error| error.to_string())?, single, told: None })
    }

    /// A machine that a board has compiled in instead.
    ///
    /// # Errors
    /// What single precision cannot hold.
    pub fn built_in(double: Rig<f64>, single: Rig<f32>) -> Self {
        Self { double, single, told: None }
    }

    /// A machine that the board is told of over CAN.
    ///
    /// # Errors
    /// What its parameters cannot hold.
    pub fn told(double: Rig<f64>) -> Result<Self, String> {
        let single = rig_file::in_precision::<f32>(&double).map_err(|error| error.text().to_string())?;
        let set = ParameterSet::of(&single, &Limits::for_rig(&single));
        // Ends go through the parameters, which turns them into the platform's frame anew.
        let single = rig_of(&set).map_err(|at| format!("as parameters it contradicts itself at {at}"))?;
        Ok(Self { double, single, told: Some(set) })
    }

    /// What the options ask for.
    ///
    /// # Errors
    /// The file that cannot be read, or what a board cannot be told.
    pub fn of(options: &Options) -> Result<Self, String> {
        let compiled_in = Self::compiled_in()?;
        let mut rig = match &options.rig {
            None => compiled_in.double,
            Some(path) => {
                if rig_file::read_hinge(path).map_err(|error| error.to_string())?.is_some() {
                    return Err(format!("{}: {NO_ELBOW}", path.display()));
                }
                let file = RigFile::read(path).map_err(|error| error.to_string())?;
                let of_file = |text: &str| format!("{}: [covariance]: {text}", path.display());
                let rig = file.for_board().map_err(|error| of_file(error.text()))?;
                if file.covariance.is_some() {
                    eprintln!("{}", of_file(&told_instead(rig.tolerance())));
                }
                rig
            }
        };
        if let Some(radius_mm) = options.pulley {
            rig = over_pulleys(&rig, radius_mm)?;
        }
        if let Some(error_mm) = options.rig_error
            && options.rig.is_none()
        {
            let tolerance = Tolerance { base_mm: error_mm, edges_mm: error_mm, ..*rig.tolerance() };
            rig = rig.with_tolerance(tolerance).map_err(|error| error.text().to_string())?;
        }
        if rig == compiled_in.double { Ok(compiled_in) } else { Self::told(rig) }
    }

    /// The machine as it is built. As stated; with `rig_error_mm`, each coordinate of an attachment point and each edge
    /// (each coordinate of an end) is off by that much, 1σ, and each encoder and drum by its stated tolerance. Its {B} is
    /// the frame best fitted to the attachment points as they are.
    ///
    /// # Errors
    /// When errors of that size leave no machine.
    pub fn as_built(&self, rig_error_mm: Option<f64>, seed: u64) -> Result<Rig<f64>, String> {
        let stated = &self.double;
        let Some(error_mm) = rig_error_mm else { return Ok(*stated) };
        // Another seed than the wearer's: the same wearer sits in every machine.
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x4D41_4348);
        let mut off = |sigma: f64| normal(&mut random) * sigma;
        let drum = *stated.drum();
        let noise_mm = stated.length_noise_mm();
        let built = match stated.cables() {
            None => {
                let base = stated.base_mm().map(|point| point + Vector3::from_fn(|_, _| off(error_mm)));
                let edges = stated.edges_mm().map(|edge| edge + off(error_mm));
                Rig::new(fitted(&base, stated.base_mm()), edges, drum, noise_mm, *stated.nominal())
            }
            Some(cables) => {
                let base = cables.map(|cable| cable.base_mm + Vector3::from_fn(|_, _| off(error_mm)));
                let base = fitted(&base, &cables.map(|cable| cable.base_mm));
                let built = std::array::from_fn(|k| CableEnds {
                    base_mm: base[k],
                    end_mm: cables[k].end_mm + Vector3::from_fn(|_, _| off(error_mm)),
                    pulley: cables[k].pulley,
                });
                Rig::with_cables(built, drum, noise_mm, *stated.nominal())
            }
        };
        let known = stated.correction().copied();
        let known = known.unwrap_or(Correction { offset_mm: [0.0; CABLES], scale: [1.0; CABLES] });
        let tolerance = *stated.tolerance();
        let truth = Correction {
            offset_mm: known.offset_mm.map(|offset| offset + off(tolerance.offset_mm)),
            scale: known.scale.map(|scale| scale * (1.0 + off(tolerance.drum))),
        };
        built.and_then(|rig| rig.with_correction(truth)).map_err(|error| error.text().to_string())
    }
}

/// The rig that parameters make, about a ball.
fn rig_of(set: &ParameterSet) -> Result<Rig<f32>, String> {
    let config = set.config(Restart::default(), 0).map_err(|at| format!("index {}", at.index))?;
    config.rig.ball().copied().ok_or("index 1: an elbow".to_string())
}

/// What a board is told instead of a covariance.
pub fn told_instead(tolerance: &Tolerance<f64>) -> String {
    let Tolerance { base_mm, edges_mm, offset_mm, drum } = tolerance;
    format!(
        "a board knows no correlations; it is told of the tolerances that cover them, and its bar is wider: base {base_mm:.3}, \
         edges {edges_mm:.3}, zero {offset_mm:.3} mm, drum {:.3} %",
        drum * 100.0
    )
}

/// Points moved as a whole to where they fit `stated` best.
fn fitted<const N: usize>(points: &[Vector3<f64>; N], stated: &[Vector3<f64>; N]) -> [Vector3<f64>; N] {
    let (turn, shift) = best_fit(points, stated);
    points.map(|point| turn * point + shift)
}

/// The same machine with its cables over swivelling guide pulleys of this radius, which they enter along +z where they
/// were attached before. At home the cables are as long as such a machine's are.
fn over_pulleys(rig: &Rig<f64>, radius_mm: f64) -> Result<Rig<f64>, String> {
    let cables = match rig.cables() {
        Some(cables) => *cables,
        None => {
            let (base, ends) = (*Cables::new(rig).base_mm(), rig.platform_mm());
            std::array::from_fn(|k| CableEnds { base_mm: base[k], end_mm: ends[k / 2], pulley: Pulley::none() })
        }
    };
    let pulley = Pulley { radius_mm, axis: Vector3::z() };
    let with = |drum: Drum<f64>| {
        Rig::with_cables(cables.map(|cable| CableEnds { pulley, ..cable }), drum, rig.length_noise_mm(), *rig.nominal())
            .and_then(|guided| guided.with_noise(rig.length_noise_mm(), rig.sample_noise_mm()))
            .and_then(|guided| guided.with_tolerance(*rig.tolerance()))
            .map_err(|error| error.text().to_string())
    };
    let guided = with(*rig.drum())?;
    let arm = FittedArm::new(&guided, Vector3::zeros(), Vector3::zeros());
    let home_length_mm = Cables::new(&guided).lengths_mm(&arm.ends_mm().map(|end| arm.centre_mm() + end));
    if !home_length_mm.iter().all(|length| length.is_finite()) {
        return Err(format!("a pulley of {radius_mm} mm cannot be reached by its cable"));
    }
    let guided = with(Drum { home_length_mm, ..*rig.drum() })?;
    match rig.correction() {
        Some(known) => guided.with_correction(*known).map_err(|error| error.text().to_string()),
        None => Ok(guided),
    }
}
