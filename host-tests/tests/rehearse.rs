//! The rehearsal against the device in this process: the same script that plays against the emulated board.

use glenoid::identification::{Solver, SolverSettings};
use glenoid::kinematics::CableLengths;
use glenoid::rig::Rig;
use host_tests::rehearse::{length_sigma_mm, sigma_mm};
use host_tests::wearer::{Wearer, WearerSettings};

fn rig() -> Rig<f64> {
    Rig::shoulder(150.0).unwrap()
}

/// The bound is derived from the geometry alone; the solver knows nothing of it. Over many draws of the noise the
/// spread of the solver's results must come out as the bound says.
#[test]
fn the_expected_error_is_the_spread_of_many_identifications() {
    let (rig, runs, noise_mm) = (rig(), 400, 0.1);
    let settings = |seed| WearerSettings { seed, noise_mm, ..Default::default() };
    let mut wearer = Wearer::new(rig, settings(4));
    let poses: Vec<_> = (0..30).map(|_| wearer.next_pose()).collect();
    let rotations: Vec<_> = poses.iter().map(|pose| pose.rotation).collect();
    let expected = sigma_mm(&rig, wearer.arm(), &rotations, length_sigma_mm(noise_mm, 0.0)).unwrap();

    let truth = wearer.truth().to_array();
    let mut squares = [0.0; 6];
    for run in 0..runs {
        // Another wearer's noise on this wearer's poses.
        let mut noise = Wearer::new(rig, settings(1000 + run));
        let lengths: Vec<_> = poses
            .iter()
            .map(|pose| {
                let errors = noise.next_pose().errors_mm;
                CableLengths::new(std::array::from_fn(|k| pose.spans_mm[k] + errors[k])).unwrap()
            })
            .collect();
        let found = Solver::<f64>::new(&rig, SolverSettings::for_rig(&rig)).run(&lengths).unwrap();
        for (square, (value, truth)) in squares.iter_mut().zip(found.parameters.to_array().into_iter().zip(truth)) {
            *square += (value - truth).powi(2);
        }
    }
    for (square, expected) in squares.into_iter().zip(expected) {
        let ratio = (square / runs as f64).sqrt() / expected;
        // The spread of 400 draws is itself known to 1 / sqrt(800) = 3.5 %: four of those.
        assert!((0.86..1.14).contains(&ratio), "{ratio}");
    }
}

#[test]
fn poses_that_determine_nothing_have_no_expected_error() {
    let wearer = Wearer::new(rig(), WearerSettings::default());
    assert_eq!(sigma_mm(&rig(), wearer.arm(), &[], 0.1), None);
}

#[test]
fn noise_and_rounding_add_up_in_squares() {
    // A uniform distribution within ±w has the standard deviation w / sqrt 3.
    assert!((length_sigma_mm(0.1, 0.0) - 0.1 / 3f64.sqrt()).abs() < 1e-15);
    assert!((length_sigma_mm(0.0, 0.2) - 0.1 / 3f64.sqrt()).abs() < 1e-15);
    assert!((length_sigma_mm(0.3, 0.8) - (0.3f64 * 0.3 + 0.4 * 0.4).sqrt() / 3f64.sqrt()).abs() < 1e-15);
}
