//! In which of its two directions a hinge's axis is named.

use super::hinge::{RANGE_RAD, noise_free, poses, run};
use glenoid::identification::hinge::{Drawing, HingeRig};
use glenoid::rig::Tolerance;

/// Run for run an axis has the same direction, and the angle the same sign: the drawing's, whichever way it was drawn.
#[test]
fn an_axis_is_named_in_one_direction() {
    let mut found_by_name = 0;
    for seed in 0..12 {
        let (elbow, _, readings) = noise_free(seed, 12, 4);
        let rig = elbow.rig(Tolerance::exact()).unwrap();
        let direction = |rig: &HingeRig<f64>| run(rig, &mut poses(&readings)).ok().map(|found| *found.hinge.axis());
        for drawn in [elbow.hinge(), elbow.hinge().reversed()] {
            let drawing = Drawing { hinge: drawn, sigma: None, range_rad: RANGE_RAD };
            if let Some(axis) = direction(&rig.clone().with_drawing(drawing)) {
                assert!(axis.dot(drawn.axis()) > 0.99, "seed {seed}: {axis} of {}", drawn.axis());
                found_by_name += 1;
            }
        }
        if let Some(axis) = direction(&rig) {
            assert!(axis[axis.iamax()] > 0.0, "seed {seed}: {axis}");
            found_by_name += 1;
        }
    }
    assert!(found_by_name >= 24, "{found_by_name} of 36");
}
