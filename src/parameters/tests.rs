//! The table against the rigs, and what a set refuses.

use super::config::Config;
use super::*;
use crate::can::BaseId;
use crate::procedure::{Limits, Reason, Settings};
use crate::restart::Restart;
use crate::rig::{Rig, Tolerance};

fn config(set: &ParameterSet) -> Result<Config, Contradiction> {
    set.config(Restart::default(), 0)
}

/// The rig of a ball.
fn ball(config: &Config) -> &Rig<f32> {
    config.rig.ball().unwrap()
}

#[test]
fn the_defaults_are_the_shoulder_built_by_hand() {
    let rig = Rig::<f32>::shoulder(150.0).unwrap().with_tolerance(Tolerance::hand_built()).unwrap();
    let config = config(&ParameterSet::new()).unwrap();
    assert_eq!(ball(&config), &rig);
    assert_eq!(config.limits, Limits::for_rig(&rig));
    assert_eq!(config.base, BaseId::DEFAULT);
    assert_eq!(ParameterSet::of(&rig, &Limits::for_rig(&rig)), ParameterSet::new());
}

#[test]
fn every_machine_comes_back_from_its_parameters() {
    for rig in [Rig::<f32>::wrist().unwrap(), Rig::shoulder(350.0).unwrap(), Rig::shoulder(123.4).unwrap()] {
        let limits = Limits::new(&rig, Settings { hold_ms: 321, max_attempts: 3, ..Settings::for_rig(&rig) }).unwrap();
        let set = ParameterSet::of(&rig, &limits);
        let config = config(&set).unwrap();
        assert_eq!((ball(&config), &config.limits), (&rig, &limits));
    }
}

/// Ends of their own, pulleys, tolerances and what commissioning found: all of it is data.
#[test]
fn a_machine_with_pulleys_and_commissioned_offsets_comes_back() {
    let mut set = ParameterSet::new();
    set.set_bits(1, 1).unwrap();
    for cable in 0..6 {
        set.set_bits(36 + 10 * cable, 5f32.to_bits()).unwrap();
    }
    set.set_bits(31, 3f32.to_bits()).unwrap();
    set.set_bits(120, 0.25f32.to_bits()).unwrap();
    set.set_bits(126, 0.25f32.to_bits()).unwrap();
    let first = config(&set).unwrap();
    let cables = ball(&first).cables().unwrap();
    assert!(cables.iter().all(|cable| cable.pulley.radius_mm == 5.0));
    assert_eq!(cables[0].base_mm.y, 3.0);
    assert_eq!(ball(&first).tolerance().base_mm, 0.25);
    assert_eq!(ball(&first).correction().unwrap().offset_mm[2], 0.25);
    // the ends are kept in the platform's own frame: from there on nothing changes any more
    let second = config(&ParameterSet::of(ball(&first), &first.limits)).unwrap();
    for (one, other) in cables.iter().zip(ball(&second).cables().unwrap()) {
        assert!((one.end_mm - other.end_mm).norm() < 1e-3, "{one:?} {other:?}");
    }
    // the default ends are those of the two triangles
    let mut plain = ParameterSet::new();
    plain.set_bits(1, 1).unwrap();
    let (plain, shoulder) = (config(&plain).unwrap(), Rig::<f32>::shoulder(150.0).unwrap());
    for (one, other) in ball(&plain).edges_mm().iter().zip(shoulder.edges_mm()) {
        assert!((one - other).abs() < 1e-3);
    }
    // a pulley whose axis is no direction
    set.set_bits(39, 0f32.to_bits()).unwrap();
    assert_eq!(config(&set), Err(Contradiction { index: 36 }));
}

#[test]
fn indices_are_in_order_and_every_default_lies_in_its_range() {
    assert!(TABLE.windows(2).all(|pair| pair[0].index < pair[1].index));
    let mut set = ParameterSet::new();
    for (place, entry) in TABLE.iter().enumerate() {
        assert_eq!(
            find(entry.index).map(|(place, entry)| (place, entry.description().name)),
            Some((place, entry.description().name))
        );
        assert!(
            entry.index != 0 && entry.index < 1 << 12 && !entry.description().text.is_empty(),
            "{}",
            entry.description().name
        );
        for bits in [entry.default, entry.minimum, entry.maximum] {
            assert_eq!(set.set_bits(entry.index, bits), Ok(()), "{}", entry.description().name);
        }
    }
}

#[test]
fn what_is_out_of_range_or_no_number_is_refused_and_changes_nothing() {
    let mut set = ParameterSet::new();
    for entry in TABLE {
        let wrong: &[u32] = match entry.kind {
            Kind::Single => &[f32::NAN.to_bits(), f32::INFINITY.to_bits(), f32::MIN.to_bits(), 1e30f32.to_bits()],
            Kind::Integer if entry.maximum == u32::MAX => &[],
            Kind::Integer => &[entry.maximum + 1, u32::MAX],
        };
        for bits in wrong {
            assert_eq!(
                set.set_bits(entry.index, *bits),
                Err(Reason::ParameterOutOfRange),
                "{}",
                entry.description().name
            );
        }
    }
    assert_eq!(set.set_bits(0, 0), Err(Reason::UnknownParameter));
    assert_eq!(set.set_bits(4_095, 0), Err(Reason::UnknownParameter));
    assert_eq!(set, ParameterSet::new());
}

#[test]
fn values_that_contradict_each_other_are_named() {
    let mut set = ParameterSet::new();
    // an edge that is longer than the other two together
    set.set_bits(19, 500.0f32.to_bits()).unwrap();
    assert_eq!(config(&set), Err(Contradiction { index: 19 }));
    let mut set = ParameterSet::new();
    set.set_bits(192, 0x681).unwrap();
    assert_eq!(config(&set), Err(Contradiction { index: 192 }));
    let mut set = ParameterSet::new();
    set.set_bits(141, 500.0f32.to_bits()).unwrap();
    assert_eq!(config(&set), Err(Contradiction { index: 141 }));
}

#[test]
fn a_reset_keeps_the_key_of_the_lock() {
    let mut set = ParameterSet::new();
    set.set_bits(200, 77).unwrap();
    set.set_bits(161, 999).unwrap();
    let reset = set.reset();
    assert_eq!((reset.bits(200), reset.bits(161)), (Some(77), Some(400)));
}
