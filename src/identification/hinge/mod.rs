//! The elbow: a hinge between two bodies, identified from the lengths of two to four cables.
//!
//! Four cables determine it without a start; two or three do with a drawing. Each pose has one unknown of its own, its
//! angle, which is eliminated, so that k cables give k − 1 equations a pose.
//!
//! 1. **Start**: hinges that cross the limb beyond the base's ring, spread evenly (`starts`), the poses' angles
//!    searched over the circle; or the drawing.
//! 2. **Fit**: Levenberg-Marquardt from the cheapest of them, then with the machine's constants and their priors.
//! 3. **Judge**: χ²; poses that contradict the others are weighted down (graduated non-convexity) and left out; a second
//!    axis; flexion; two hinges that fit; standard deviations.
//!
//! ```
//! use glenoid::identification::hinge::{Hinge, HingeEstimator, HingePose, HingeRig, HingeSettings};
//! use glenoid::rig::{CableEnds, Pulley};
//! use nalgebra::Vector3;
//!
//! // rings of 60 mm on the upper arm and of 45 mm on the forearm, ends turned by +25° and −25° alternately
//! let point = |radius_mm: f64, degrees: f64| {
//!     let (sin, cos) = degrees.to_radians().sin_cos();
//!     Vector3::new(radius_mm * cos, radius_mm * sin, 0.0)
//! };
//! let cables = [(45.0, 70.0), (135.0, 110.0), (225.0, 250.0), (315.0, 290.0)].map(|(base, end)| CableEnds {
//!     base_mm: point(60.0, base),
//!     end_mm: point(45.0, end),
//!     pulley: Pulley::none(),
//! });
//! let rig = HingeRig::new(&cables, 0.058).unwrap();
//! // the axis, 160 mm beyond the one ring and 70 mm before the other, and lengths at ten angles
//! let (x, z) = (Vector3::x(), Vector3::z());
//! let truth = Hinge::through(&Vector3::new(1.0, 0.1, -0.05), &(z * 160.0), &x, &(z * -70.0));
//! let mut poses: [HingePose<f64>; 10] = core::array::from_fn(|k| {
//!     let (angle, foot) = (-0.2 - 0.19 * k as f64, truth.foot_in_platform_mm());
//!     let end = |p: &Vector3<f64>| truth.platform_foot_mm() + truth.rotation(angle) * (p - foot);
//!     HingePose::new(cables.each_ref().map(|cable| (end(&cable.end_mm) - cable.base_mm).norm()))
//! });
//! let found = HingeEstimator::new(&rig, HingeSettings::for_rig(&rig)).run(&mut poses).unwrap();
//! let error = found.hinge.difference(&truth);
//! assert!(error.iter().all(|error| error.abs() < 1e-4), "{error:?}");
//! ```

mod angle;
mod carry;
mod estimator;
mod fit;
mod joint;
mod judge;
mod machine;
mod pose;
mod refusal;
mod result;
mod rig;
mod sample;
mod second_axis;
mod settings;
mod starts;
mod verify;

pub use angle::{FollowedAngle, HingeAngles};
pub use estimator::{HingeEstimator, HingeProgress, StageName};
pub use joint::{HINGE_UNKNOWNS, Hinge, across, is_direction};
pub use judge::MIN_POSES;
pub use machine::{Constant, HingeMachine, MAX_CONSTANTS};
pub use pose::{HingePose, MAX_UNKNOWNS};
pub use refusal::{HingePart, HingeRefusal};
pub use result::IdentifiedHinge;
pub use rig::{Drawing, HingeRig, MAX_CABLES};
pub use sample::HingeSample;
pub use settings::HingeSettings;
pub use verify::VerifiedAngle;
