//! For every refusal: what was seen, and what to do about it, in words that need no knowledge of the method.

use super::lengths_file::LengthsFile;
use super::refusal::RefusalDetail;
use super::report::{Method, Report};
use super::wording::{self, counted, direction};
use glenoid::identification::JointChoice;
use glenoid::identification::joint::MIN_MOVING_POSES;

/// What was seen, with its figures.
pub fn seen(refusal: &RefusalDetail, log: &LengthsFile) -> String {
    let pose = |pose: usize| wording::pose(pose, log);
    match *refusal {
        RefusalDetail::TooFewPoses { poses } => format!("{} in {}", counted(poses as usize, "pose"), log.file()),
        RefusalDetail::BadLength { pose: at, cable, problem } => format!("{}, cable {cable}: {problem}", pose(at)),
        RefusalDetail::NotClosing { pose: at, end_point, iteration } => {
            let steps = counted(iteration.into(), "iteration");
            format!("{}, end-point P{end_point}, after {steps}", pose(at))
        }
        RefusalDetail::Singular | RefusalDetail::IterationCap | RefusalDetail::MachineNotAsStated => {
            format!("in {}", log.file())
        }
        RefusalDetail::PlatformDoesNotClose { pose: at } => format!("{} is the first of them", pose(at)),
        RefusalDetail::OneAxis { axis, sway_deg } => {
            format!("the axis is {}; the poses move it by {sway_deg:.1} degrees", direction(&axis))
        }
        RefusalDetail::TooAlike { spread_deg } => format!("they differ by {spread_deg:.1} degrees"),
        RefusalDetail::Weak { direction: along, sigma_mm } => {
            format!("1 sigma of {sigma_mm:.2} mm along {}; at most 1 mm is accepted", direction(&along))
        }
        RefusalDetail::TooManyOutliers { rejected, poses } => format!("{rejected} of {poses}"),
        RefusalDetail::CentreNotFixed { migration_mm } => {
            format!("by {migration_mm:.1} mm along each axis, root mean square")
        }
        RefusalDetail::HangsOnOnePose { pose: at } => pose(at),
        RefusalDetail::TooFewForMovingCentre { poses } => {
            format!("{} in {}", counted(poses as usize, "pose"), log.file())
        }
        RefusalDetail::MissingMotion { spread_deg, missing: 2, direction: along } => {
            format!("{spread_deg:.1} degrees (1 sigma) of tilt along {}", direction(&along))
        }
        RefusalDetail::MissingMotion { spread_deg, .. } => format!("{spread_deg:.1} degrees (1 sigma) of it"),
        RefusalDetail::SlippedMidway { pose: at, size_mm, .. } => format!("by {size_mm:.1} mm before {}", pose(at)),
        RefusalDetail::NotExplained { residual_mm } => {
            format!("{residual_mm:.1} mm are left in the worst direction, root mean square")
        }
        RefusalDetail::NotHeld { scatter_mm } => format!("the centre scatters by {scatter_mm:.1} mm along each axis"),
        RefusalDetail::HeldOfAnotherWearing { distance_mm } => {
            format!("the joint centres in the platform are {distance_mm:.1} mm apart")
        }
        RefusalDetail::ZeroNotDetermined { cable, sigma_mm } => {
            format!("the zero of cable {cable} is known to {sigma_mm:.1} mm (1 sigma)")
        }
    }
}

/// What to do.
pub fn remedy(report: &Report, refusal: &RefusalDetail) -> String {
    let other_method = match report.setting.method {
        Method::Paper => " --method full needs no start and leaves out bad poses.",
        Method::Full => "",
    };
    let noise = match report.setting.given_noise_mm {
        Some(_) => "If the cables are noisier than --noise says, give the true figure.".to_owned(),
        None => format!(
            "If the noise of your cables is above {:.2} mm, say so with --noise.",
            report.setting.noise_limit_mm
        ),
    };
    match refusal {
        RefusalDetail::TooFewPoses { .. } => {
            "Record at least five poses that turn the arm about different axes; ten or more give a useful standard deviation."
                .to_owned()
        }
        RefusalDetail::BadLength { .. } => format!("Correct or delete that line, and check the cable.{other_method}"),
        RefusalDetail::NotClosing { .. } => {
            format!("Give a --start nearer to the truth, or check the lengths of that pose.{other_method}")
        }
        RefusalDetail::Singular => {
            "Add poses: tilt the arm in several directions, and turn it about its own length as well.".to_owned()
        }
        RefusalDetail::IterationCap => {
            format!("Check the rig file (base and edges) and the order of the cables.{other_method}")
        }
        RefusalDetail::PlatformDoesNotClose { .. } => {
            "Check the rig file (base and edges, all in mm), and that the columns l1..l6 are in the order of the \
             cables: P1B1, P1B2, P2B2, P2B3, P3B3, P3B1."
                .to_owned()
        }
        RefusalDetail::OneAxis { .. } => {
            "The centre can slide along that axis without any length changing. Add two or more poses that turn the \
             arm about another axis, square to it, by 20 degrees or more."
                .to_owned()
        }
        RefusalDetail::TooAlike { .. } => {
            "Spread the poses: tilt the arm by 20 to 45 degrees in at least three directions.".to_owned()
        }
        RefusalDetail::Weak { .. } => {
            "Add poses, and turn the arm further about the axes that are square to that direction.".to_owned()
        }
        RefusalDetail::HangsOnOnePose { .. } => {
            "Add poses: from five well-spread ones on, each is checked by the others.".to_owned()
        }
        RefusalDetail::ZeroNotDetermined { .. } => {
            "Add poses (thirty or more), with more tilt and more turning of the arm about its own length; or home the \
             cables and leave out --zeros."
                .to_owned()
        }
        RefusalDetail::TooManyOutliers { .. } => {
            format!(
                "Look for slack cables, slipping drums and exchanged connectors, check the rig file, and record \
                     again. {noise}"
            )
        }
        RefusalDetail::CentreNotFixed { .. } if report.setting.zero_prior_mm.is_some() => {
            "Home the encoders, or commission the machine (cargo commission), and leave out --zeros: a centre that moves \
             is not told from offsets that are unknown. Or something is loose: tighten the straps."
                .to_owned()
        }
        RefusalDetail::CentreNotFixed { .. } if report.setting.joint == JointChoice::Ball => {
            format!("Leave out --joint ball: from 18 poses on a centre that moves with the arm is found. Or something is loose: tighten the straps. {noise}")
        }
        RefusalDetail::CentreNotFixed { .. } if report.setting.has_no_room_for_motion => {
            "A centre that moves was not tried: the rig's [tolerance] leaves more than 18 constants of the machine unknown, as \
             base and edges of a [[cable]] each do. State those as known (0, or leave them out), and better home the encoders. \
             Or something is loose: tighten the straps."
                .to_owned()
        }
        RefusalDetail::CentreNotFixed { .. } if report.setting.rows_used.count >= MIN_MOVING_POSES => {
            format!(
                "A centre that moves with the arm does not explain the poses either. Look for slack cables, misread \
                     lengths and loose straps, move slowly, hold each pose, and record again. {noise}"
            )
        }
        RefusalDetail::CentreNotFixed { .. } => {
            format!(
                "The centre of a living shoulder moves with the arm. Record at least 18 poses, better 60, with the arm \
                     tilted in all directions and turned about its own length: then its motion is identified as well. \
                     Or something is loose: tighten the straps. {noise}"
            )
        }
        RefusalDetail::TooFewForMovingCentre { .. } => {
            "Record at least 18 poses, better 60, with the arm tilted in all directions and turned about its own length."
                .to_owned()
        }
        RefusalDetail::MissingMotion { missing: 1, .. } => {
            "Tilt the arm further: 20 to 45 degrees from its middle in every direction.".to_owned()
        }
        RefusalDetail::MissingMotion { missing: 2, .. } => {
            "Tilt the arm along that direction as well, by 20 degrees or more to both sides.".to_owned()
        }
        RefusalDetail::MissingMotion { .. } => {
            "Turn the arm about its own length in some of the poses, by 30 degrees to both sides.".to_owned()
        }
        RefusalDetail::SlippedMidway { cuff, .. } => {
            let what = if *cuff { "cuff" } else { "strap of the base" };
            format!("Tighten the {what}, then record again; or use only the poses on one side of the slip.")
        }
        RefusalDetail::NotExplained { .. } => {
            "Look for a loose strap, cuff or cable; move slowly, hold each pose, and record again.".to_owned()
        }
        RefusalDetail::NotHeld { .. } => {
            "Let somebody hold the shoulder blade, keep the arm within 30 degrees of its middle, and repeat the held \
             poses; or leave out --still."
                .to_owned()
        }
        RefusalDetail::HeldOfAnotherWearing { .. } => {
            "Record both phases without taking the cuff off between them; or leave out --still.".to_owned()
        }
        RefusalDetail::MachineNotAsStated => {
            "Commission the machine (cargo commission), or state its tolerances in the rig file ([tolerance]); home the \
             encoders before."
                .to_owned()
        }
    }
}
