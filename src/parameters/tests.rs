//! The table against the rigs, and what a set refuses.

use super::config::Config;
use super::*;
use crate::can::BaseId;
use crate::identification::hinge::Drawing;
use crate::procedure::elbow::ElbowRig;
use crate::procedure::{Limits, ModuleRig, Reason, Settings};
use crate::restart::Restart;
use crate::rig::{Rig, Tolerance};

fn config(set: &ParameterSet) -> Result<Config, Contradiction> {
    set.config(Restart::default(), 0)
}

#[test]
fn the_defaults_are_the_shoulder_built_by_hand() {
    let rig = Rig::<f32>::shoulder(150.0).unwrap().with_tolerance(Tolerance::hand_built()).unwrap();
    let config = config(&ParameterSet::new()).unwrap();
    assert_eq!(config.rig.ball(), Some(&rig));
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
        assert_eq!((config.rig, config.limits), (rig.into(), limits));
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
    let first_rig = *first.rig.ball().unwrap();
    let cables = first_rig.cables().unwrap();
    assert!(cables.iter().all(|cable| cable.pulley.radius_mm == 5.0));
    assert_eq!(cables[0].base_mm.y, 3.0);
    assert_eq!(first_rig.tolerance().base_mm, 0.25);
    assert_eq!(first_rig.correction().unwrap().offset_mm[2], 0.25);
    // the ends are kept in the platform's own frame: from there on nothing changes any more
    let second = config(&ParameterSet::of(&first_rig, &first.limits)).unwrap();
    for (one, other) in cables.iter().zip(second.rig.ball().unwrap().cables().unwrap()) {
        assert!((one.end_mm - other.end_mm).norm() < 1e-3, "{one:?} {other:?}");
    }
    // the default ends are those of the two triangles
    let mut plain = ParameterSet::new();
    plain.set_bits(1, 1).unwrap();
    let (plain, shoulder) = (*config(&plain).unwrap().rig.ball().unwrap(), Rig::<f32>::shoulder(150.0).unwrap());
    for (one, other) in plain.edges_mm().iter().zip(shoulder.edges_mm()) {
        assert!((one - other).abs() < 1e-3);
    }
    // a pulley whose axis is no direction
    set.set_bits(39, 0f32.to_bits()).unwrap();
    assert_eq!(config(&set), Err(Contradiction { index: 36 }));
}

/// An elbow is data as well, with and without a drawing that is a prior; what only a ball has is named.
#[test]
fn an_elbow_comes_back_from_its_parameters() {
    let four = ElbowRig::four_cables().unwrap();
    let drawing = *four.hinge().drawing().unwrap();
    let sigma = Some([0.05, 0.05, 3.0, 3.0, 0.04, 0.04, 2.0, 2.0, 5.0]);
    let tolerance = Tolerance { base_mm: 0.5, edges_mm: 0.25, offset_mm: 0.3, drum: 0.001 };
    let cables = &four.hinge().cables()[..2];
    let two = ElbowRig::new(cables, *four.drum(), 0.1, tolerance, Some(Drawing { sigma, ..drawing })).unwrap();
    for rig in [four, two] {
        let module = ModuleRig::from(rig.clone());
        let mut set = ParameterSet::of_module(&module, &Limits::of(&module));
        let found = config(&set).unwrap();
        let found = found.rig.hinge().unwrap();
        assert_eq!((found.cables(), found.drum()), (rig.cables(), rig.drum()));
        assert_eq!(found.hinge().cables(), rig.hinge().cables());
        assert_eq!(found.hinge().tolerance(), rig.hinge().tolerance());
        let (one, other) = (found.hinge().drawing().unwrap(), rig.hinge().drawing().unwrap());
        assert_eq!((one.sigma, one.range_rad), (other.sigma, other.range_rad));
        assert!(one.hinge.difference(&other.hinge).iter().all(|number| number.abs() < 1e-4));
        // Offsets of commissioning, a stated prior of the offsets, capture in motion: an elbow has none of them.
        for (index, bits) in [(125, 1f32.to_bits()), (170, 1f32.to_bits()), (179, 1)] {
            let before = set;
            set.set_bits(index, bits).unwrap();
            assert_eq!(config(&set), Err(Contradiction { index }));
            set = before;
        }
        // Without its drawing an elbow of two cables is not determined.
        set.set_bits(211, 0).unwrap();
        let without = config(&set);
        assert_eq!(without.is_ok(), rig.cables() == 4, "{without:?}");
        if rig.cables() < 4 {
            assert_eq!(without, Err(Contradiction { index: 211 }));
        }
    }
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
