//! Constants that are no machine are refused, each with its own reason.

use crate::common::{Worn, library};
use glenoid::rig::{Drum, Parameters, Rig, RigError};
use nalgebra::Vector3;

/// What a rig is made of.
struct Constants {
    base_mm: [Vector3<f64>; 3],
    edges_mm: [f64; 3],
    drum: Drum<f64>,
    noise_mm: f64,
    nominal: Parameters<f64>,
}

/// What becomes of a good rig after a change.
fn refusal(change: fn(&mut Constants)) -> Option<RigError> {
    let good = library::rig::<f64>(&Worn::table_one(150.0));
    let mut constants = Constants {
        base_mm: *good.base_mm(),
        edges_mm: *good.edges_mm(),
        drum: *good.drum(),
        noise_mm: good.length_noise_mm(),
        nominal: *good.nominal(),
    };
    change(&mut constants);
    let Constants { base_mm, edges_mm, drum, noise_mm, nominal } = constants;
    Rig::new(base_mm, edges_mm, drum, noise_mm, nominal).err()
}

#[test]
fn an_unchanged_machine_is_accepted() {
    assert_eq!(refusal(|_| ()), None);
    // Neither a level base nor a certain order of the points is asked for.
    assert_eq!(refusal(|c| c.base_mm.swap(0, 1)), None);
    assert_eq!(refusal(|c| c.base_mm[2].z = 40.0), None);
}

#[test]
fn a_constant_that_is_not_a_number() {
    for change in [
        |c: &mut Constants| c.base_mm[1].y = f64::NAN,
        |c: &mut Constants| c.edges_mm[2] = f64::INFINITY,
        |c: &mut Constants| c.drum.radius_mm = f64::NAN,
        |c: &mut Constants| c.drum.counts_per_turn = f64::INFINITY,
        |c: &mut Constants| c.drum.home_length_mm[3] = f64::NAN,
        |c: &mut Constants| c.drum.fastest_mm_per_s = f64::NEG_INFINITY,
        |c: &mut Constants| c.noise_mm = f64::NAN,
        |c: &mut Constants| c.nominal.centre_mm.z = f64::NAN,
        |c: &mut Constants| c.nominal.radii_mm[0] = f64::INFINITY,
    ] {
        assert_eq!(refusal(change), Some(RigError::NotFinite));
    }
}

#[test]
fn a_base_that_spans_no_plane() {
    assert_eq!(refusal(|c| c.base_mm[1] = c.base_mm[0]), Some(RigError::BaseCollapsed));
    assert_eq!(refusal(|c| c.base_mm = [c.base_mm[0]; 3]), Some(RigError::BaseCollapsed));
    let on_the_line = |c: &mut Constants| c.base_mm[2] = c.base_mm[0] * 3.0 - c.base_mm[1] * 2.0;
    assert_eq!(refusal(on_the_line), Some(RigError::BaseCollapsed));
}

#[test]
fn a_base_that_stands_on_its_edge() {
    let upright = |c: &mut Constants| c.base_mm = c.base_mm.map(|b| Vector3::new(b.x, 0.0, b.y));
    assert_eq!(refusal(upright), Some(RigError::BaseOnEdge));
}

#[test]
fn a_platform_whose_edges_make_no_triangle() {
    for edges_mm in [[200.0, 100.0, 100.0], [100.0, 201.0, 100.0], [0.0, 100.0, 100.0], [100.0, 100.0, -100.0]] {
        let good = library::rig::<f64>(&Worn::table_one(150.0));
        let rig = Rig::new(*good.base_mm(), edges_mm, *good.drum(), good.length_noise_mm(), *good.nominal());
        assert_eq!(rig.err(), Some(RigError::PlatformCollapsed), "{edges_mm:?}");
    }
}

#[test]
fn a_drive_a_noise_or_a_radius_that_is_not_positive() {
    for change in [
        |c: &mut Constants| c.drum.home_length_mm[5] = 0.0,
        |c: &mut Constants| c.drum.counts_per_turn = -4096.0,
        |c: &mut Constants| c.drum.radius_mm = 0.0,
        |c: &mut Constants| c.drum.fastest_mm_per_s = 0.0,
    ] {
        assert_eq!(refusal(change), Some(RigError::DrumNotPositive));
    }
    assert_eq!(refusal(|c| c.noise_mm = 0.0), Some(RigError::NoiseNotPositive));
    assert_eq!(refusal(|c| c.nominal.radii_mm[1] = 0.0), Some(RigError::RadiusNotPositive));
}
