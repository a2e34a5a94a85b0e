//! The firmware's mathematics on the poses that the page has heard of, in the firmware's precision.

use super::json;
use glenoid::identification::joint::Joint;
use glenoid::identification::machine::MachineEstimate;
use glenoid::identification::marginal_information::MarginalInformation;
use glenoid::identification::{Estimator, EstimatorSettings, Identified, Machine, Pose, PredictedAccuracy, Refusal};
use glenoid::kinematics::rotation::rotation_of;
use glenoid::kinematics::{CableLengths, JointCentre, LengthJacobian};
use glenoid::rig::{CABLES, Rig};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Bytes of a pose: six singles.
const POSE_BYTES: usize = 4 * CABLES;

/// Where the arm may be sent next: tilted by so much, in so many directions, turned about its own length by these, rad.
const NEXT_TILT_RAD: f32 = 0.7;
const NEXT_DIRECTIONS: u8 = 12;
const NEXT_TORSIONS_RAD: [f32; 3] = [-0.4, 0.0, 0.4];

/// Where each cable begins and ends, its end-points' middles, where the centre is expected, and the platform at home.
pub fn machine(rig: &Rig<f32>) -> String {
    let machine = Machine::new(rig);
    let geometry = machine.geometry();
    let home = CableLengths::new(rig.drum().home_length_mm).ok().and_then(|home| machine.platform().solve(&home).ok());
    format!(
        "{{\"joint\":\"ball\",\"base\":{},\"ends\":{},\"platform\":{},\"nominal\":{},\"home\":{}}}",
        points_json(&geometry.base_mm),
        points_json(&geometry.end_mm),
        points_json(&geometry.end_points_mm()),
        json::list(rig.nominal().centre_mm.iter()),
        home.map_or("null".to_owned(), |pose| placed_json(&pose.rotation, &pose.origin_mm))
    )
}

/// Points as a list.
pub(super) fn points_json(points: &[Vector3<f32>]) -> String {
    json::join(points.iter().map(|point| json::list(point.iter())))
}

/// Where the platform stands at six lengths: null when they do not close.
pub fn place(rig: &Rig<f32>, bytes: &[u8]) -> String {
    let placed = poses_in(bytes).first().and_then(|lengths| Machine::new(rig).platform().solve(lengths).ok());
    placed.map_or("null".to_owned(), |pose| placed_json(&pose.rotation, &pose.origin_mm))
}

/// The identification of these poses. `centre` is null when it is refused, and `refusal` says why.
pub fn identify(rig: &Rig<f32>, bytes: &[u8]) -> String {
    let machine = Machine::new(rig);
    let mut poses: Vec<Pose<f32>> = poses_in(bytes).into_iter().map(Pose::new).collect();
    for pose in &mut poses {
        pose.place(machine.platform());
    }
    let mut accuracy = PredictedAccuracy::new(&machine, rig.nominal());
    let mut sigmas = Vec::new();
    for pose in &poses {
        if pose.is_placed() {
            accuracy.add(&machine, pose);
        }
        sigmas.push(accuracy.predicted(&machine).map_or(f32::NAN, |predicted| predicted.sigma_mm));
    }
    let placed = poses.clone();
    // As in the board: the noise is known.
    let mut estimator = Estimator::new(&machine, rig.nominal(), EstimatorSettings::for_rig(rig));
    let outcome = estimator.run(&machine, &mut poses);
    let found = outcome.is_ok().then(|| Found {
        centre: *estimator.centre(),
        joint: estimator.joint(),
        machine: estimator.machine_estimate(),
    });
    let poses_json = placed.iter().map(|pose| pose_json(&machine, found.as_ref(), pose));
    format!(
        "{{\"sigma_after\":{},\"next\":{},\"poses\":{},\"moving\":{},{}}}",
        json::list(&sigmas),
        next(rig, &machine, &accuracy, outcome.as_ref().ok()),
        json::join(poses_json),
        found.is_some_and(|found| matches!(found.joint, Joint::Moving(_))),
        outcome_json(&outcome)
    )
}

/// What was found, in the terms that poses are held against.
struct Found<'a> {
    centre: JointCentre<f32>,
    joint: &'a Joint<f32>,
    /// Within its tolerances the machine is estimated as well: what is left is what that one leaves.
    machine: &'a MachineEstimate<f32>,
}

fn outcome_json(outcome: &Result<Identified<f32>, Refusal>) -> String {
    match outcome {
        Ok(found) => {
            let rejected = found.rejected.iter().map(|left| format!("[{},{}]", left.pose, left.cables));
            format!(
                "\"refusal\":null,\"centre\":{},\"sigma\":{},\"radii\":{},\"covariance\":{},\"noise\":{},\"rejected\":{}",
                json::list(found.parameters.centre_mm.iter()),
                json::list(&found.sigma_mm()[..3]),
                json::list(&found.parameters.radii_mm),
                // xx, yx, yy, zx, zy, zz
                json::list(&found.covariance_mm2[..6]),
                json::number(found.noise_mm.into()),
                json::join(rejected)
            )
        }
        Err(refusal) => format!("\"refusal\":{},\"centre\":null", json::text(refusal.text())),
    }
}

/// Where a pose stands, and with a centre what each cable leaves, mm, and the centre in it.
fn pose_json(machine: &Machine<f32>, found: Option<&Found<'_>>, pose: &Pose<f32>) -> String {
    if !pose.is_placed() {
        return "null".to_owned();
    }
    let placed = pose.platform();
    let Some(found) = found else { return placed_json(&placed.rotation, &placed.origin_mm) };
    let Found { centre, joint, machine: estimate } = found;
    let lengths = estimate.corrected(machine, pose.lengths());
    let track = joint.track(estimate.geometry(), centre, *pose.attitude(), &lengths);
    let rotation = track.map_or(placed.rotation, |attitude| rotation_of(&attitude));
    // Where the joint's model has the centre in this pose, and where this pose alone, with its six lengths, has it.
    let path = joint.centre_at(centre, &rotation);
    let jacobian = LengthJacobian::new(estimate.geometry(), &path, &rotation, &lengths);
    let left = jacobian.rows.map(|row| row.residual_mm);
    let alone = path.in_base_mm + own_centre(&jacobian).unwrap_or_default();
    let origin = path.in_base_mm - rotation * path.in_platform_mm;
    let shown = placed_json(&rotation, &origin);
    let [left, alone, path] = [json::list(&left), json::list(alone.iter()), json::list(path.in_base_mm.iter())];
    let shown = shown.trim_end_matches('}');
    format!("{shown},\"residuals\":{left},\"centre\":{alone},\"path\":{path}}}")
}

/// Where this pose alone has the centre, beside the one of the model, mm.
fn own_centre(jacobian: &LengthJacobian<f32>) -> Option<Vector3<f32>> {
    let alone = MarginalInformation::new(jacobian).ok()?;
    Some(alone.translation.try_inverse()? * alone.residuals_mm)
}

/// Rotation row by row, and the platform's origin.
pub(super) fn placed_json(rotation: &Matrix3<f32>, origin_mm: &Vector3<f32>) -> String {
    let rows = rotation.transpose();
    format!("{{\"rotation\":{},\"origin\":{}}}", json::list(rows.iter()), json::list(origin_mm.iter()))
}

/// The direction of the arm (its long axis, in {B}) whose pose would make the centre's worst σ smallest, and that σ.
fn next(
    rig: &Rig<f32>,
    machine: &Machine<f32>,
    accuracy: &PredictedAccuracy<f32>,
    identified: Option<&Identified<f32>>,
) -> String {
    let parameters = identified.map_or(*rig.nominal(), |found| found.parameters);
    let centre = JointCentre::from_parameters(&parameters, machine.geometry());
    let mut best: Option<(f32, Vector3<f32>, f32)> = None;
    for direction in 0..NEXT_DIRECTIONS {
        let azimuth = f32::from(direction) / f32::from(NEXT_DIRECTIONS) * core::f32::consts::TAU;
        let tilt = Rotation3::new(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0) * NEXT_TILT_RAD);
        for torsion in NEXT_TORSIONS_RAD {
            let rotation = tilt * Rotation3::new(Vector3::z() * torsion) * home(rig, machine);
            let sigma = CableLengths::new(lengths_at(machine, &centre, &rotation))
                .ok()
                .and_then(|lengths| Pose::placed(machine.platform(), lengths).ok())
                .and_then(|pose| {
                    let mut with_it = accuracy.clone();
                    with_it.add(machine, &pose);
                    with_it.predicted(machine)
                })
                .map(|predicted| predicted.sigma_mm);
            if let Some(sigma) = sigma
                && best.is_none_or(|(smallest, ..)| sigma < smallest)
            {
                best = Some((sigma, tilt * Vector3::z(), torsion));
            }
        }
    }
    best.map_or("null".to_owned(), |(sigma, axis, torsion)| {
        let [axis, sigma] = [json::list(axis.iter()), json::number(sigma.into())];
        format!("{{\"axis\":{axis},\"torsion\":{},\"sigma\":{sigma}}}", json::number(torsion.into()))
    })
}

/// Lengths of the six cables with the arm turned so about this centre, mm.
fn lengths_at(machine: &Machine<f32>, centre: &JointCentre<f32>, rotation: &Rotation3<f32>) -> [f32; CABLES] {
    let geometry = machine.geometry();
    core::array::from_fn(|cable| {
        let end_mm = centre.in_base_mm + rotation * (geometry.end_mm[cable] - centre.in_platform_mm);
        geometry.span(cable, &end_mm).length_mm
    })
}

/// Rotation from {P} to {B} with the arm at home.
fn home(rig: &Rig<f32>, machine: &Machine<f32>) -> Rotation3<f32> {
    let lengths = CableLengths::new(rig.drum().home_length_mm).ok();
    let home = lengths.and_then(|lengths| machine.platform().solve(&lengths).ok());
    home.map_or(Rotation3::identity(), |pose| Rotation3::from_matrix_unchecked(pose.rotation))
}

fn poses_in(bytes: &[u8]) -> Vec<CableLengths<f32>> {
    let pose = |bytes: &[u8]| {
        let mut lengths = [0.0; CABLES];
        for (length, bytes) in lengths.iter_mut().zip(bytes.as_chunks::<4>().0) {
            *length = f32::from_le_bytes(*bytes);
        }
        CableLengths::new(lengths).ok()
    };
    bytes.chunks_exact(POSE_BYTES).filter_map(pose).collect()
}
