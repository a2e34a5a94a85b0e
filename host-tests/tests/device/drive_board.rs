//! The arithmetic behind the real drive board. Expected values are written out from the reference manual (RM0440), or
//! counted in another way than the code does.

use glenoid::can::{BaseId, Frame};
use glenoid::drive_board::bit_timing::{BitTiming, TimingError};
use glenoid::drive_board::clock::{CAN_BIT_HZ, CORE_HZ, PERIODS_A_SAMPLE};
use glenoid::drive_board::counts::{MAX_COUNTS_A_SAMPLE, extended, fastest_counts_a_second, is_slow_enough};
use glenoid::drive_board::flash_layout::{FLASH_ORIGIN, ecc_verdict, record_offset};
use glenoid::drive_board::{CanFilter, EccVerdict, LayoutError, can_memory, reset};
use glenoid::restart::ResetCause;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Drum, Rig};
use proptest::prelude::*;

#[test]
fn the_boards_bit_timing() {
    let timing = BitTiming::new(CORE_HZ, CAN_BIT_HZ, 850).unwrap();
    let [prescaler, before, behind, jump] = [
        u32::from(timing.prescaler.get()),
        u32::from(timing.segment_1.get()),
        u32::from(timing.segment_2.get()),
        u32::from(timing.jump.get()),
    ];
    // the bit in clock periods, counted out: synchronisation, first segment, second segment
    assert_eq!(prescaler * (1 + before + behind) * 500_000, 170_000_000);
    let sample_point = f64::from(1 + before) / f64::from(1 + before + behind);
    assert!((0.80..=0.875).contains(&sample_point), "{sample_point}");
    assert_eq!((prescaler, before, behind, jump), (17, 16, 3, 3));
    assert_eq!(PERIODS_A_SAMPLE, 170_000);
}

#[test]
fn a_bit_that_no_quanta_make_is_refused() {
    assert_eq!(BitTiming::new(170_000_000, 499_999, 850), Err(TimingError::NotDivisible));
    assert_eq!(BitTiming::new(1_000_000, 500_000, 850), Err(TimingError::NotDivisible));
    for sample_permille in [0, 1_000, u32::MAX] {
        assert_eq!(BitTiming::new(170_000_000, 500_000, sample_permille), Err(TimingError::SamplePoint));
    }
}

proptest! {
    /// Against all that a search through the registers' ranges finds.
    #[test]
    fn a_timing_is_exact_and_the_nearest_there_is(
        clock_mhz in 8_u32..=170,
        bit_hz in prop::sample::select(vec![125_000_u32, 250_000, 500_000, 800_000, 1_000_000]),
        permille in 700_u32..=900,
    ) {
        let clock_hz = clock_mhz * 1_000_000;
        let distance = |before: u32, quanta: u32| (before * 1_000 / quanta).abs_diff(permille);
        let nearest = (8..=25_u32)
            .filter(|quanta| (1..=512).any(|prescaler: u32| {
                u64::from(prescaler) * u64::from(*quanta) * u64::from(bit_hz) == u64::from(clock_hz)
            }))
            .flat_map(|quanta| (2..quanta).map(move |before| distance(before, quanta)))
            .min();
        match BitTiming::new(clock_hz, bit_hz, permille) {
            Err(error) => prop_assert_eq!((error, nearest), (TimingError::NotDivisible, None)),
            Ok(timing) => {
                let before = 1 + u32::from(timing.segment_1.get());
                let quanta = before + u32::from(timing.segment_2.get());
                prop_assert_eq!(u32::from(timing.prescaler.get()) * quanta * bit_hz, clock_hz);
                prop_assert!(timing.jump <= timing.segment_1 && timing.jump <= timing.segment_2);
                // sample points of one division lie at least 40 thousandths apart, and are rounded to whole ones
                prop_assert!(distance(before, quanta) <= nearest.unwrap() + 1);
            }
        }
    }

    /// An encoder that wanders anywhere, past the ends of 16 bits and of 32.
    #[test]
    fn a_count_is_followed_past_every_wrap(
        start in any::<i32>(),
        steps in prop::collection::vec(-i64::from(MAX_COUNTS_A_SAMPLE)..i64::from(MAX_COUNTS_A_SAMPLE), 1..300),
        one_way in any::<bool>(),
    ) {
        let mut truth = i64::from(start);
        let mut count = start;
        for step in steps {
            truth += if one_way { step.abs().min(32_767) } else { step };
            let timer = truth.rem_euclid(65_536) as u16;
            count = extended(count, timer);
            let wrapped = (truth + (1 << 31)).rem_euclid(1 << 32) - (1 << 31);
            prop_assert_eq!(i64::from(count), wrapped);
        }
    }

    #[test]
    fn a_frame_survives_the_controllers_memory(id in 0_u16..0x800, data in prop::collection::vec(any::<u8>(), 0..=8)) {
        let frame = Frame::new(id, &data).unwrap();
        prop_assert_eq!(can_memory::frame_of(&can_memory::words_of(&frame)), Some(frame));
    }
}

/// The elements as the reference manual draws them.
#[test]
fn words_of_the_controllers_memory() {
    let frame = Frame::new(0x321, &[0x11, 0x22, 0x33, 0x44, 0x55, 0x66]).unwrap();
    let words = [0x0C84_0000, 0x0006_0000, 0x4433_2211, 0x0000_6655];
    assert_eq!(can_memory::words_of(&frame), words);
    // received: time stamp, index of the filter, and bytes behind the end that are not of this frame
    assert_eq!(can_memory::frame_of(&[0x0C84_0000, 0x0106_BEEF, 0x4433_2211, 0xFFFF_6655]), Some(frame));
    // the error-passive mark of the sender
    assert_eq!(can_memory::frame_of(&[0x8C84_0000, 0x0006_0000, 0x4433_2211, 0x0000_6655]), Some(frame));
    for (kind, first, second) in [("extended", 1 << 30, 0), ("remote", 1 << 29, 0), ("CAN FD", 0, 1 << 21)] {
        let [a, b, c, d] = words;
        assert_eq!(can_memory::frame_of(&[a | first, b | second, c, d]), None, "{kind}");
    }
    let long = can_memory::frame_of(&[0, 0x000F_0000, 0, 0]).unwrap();
    assert_eq!(long.data().len(), 8, "a classic frame with a length code of 15 has eight bytes");
}

#[test]
fn the_filter_lets_the_devices_block_through_and_nothing_else() {
    for base in (0..=0x7FF).filter_map(BaseId::new) {
        let filter = CanFilter::of_block(base);
        for raw_id in 0..=0x7FF {
            assert_eq!(filter.accepts(raw_id), base.owns(raw_id), "{raw_id:#x} with {base:?}");
        }
        assert!(filter.accepts(base.command().as_raw()));
    }
}

/// The inputs of the timers are filtered: what a rig at full speed asks of them.
#[test]
fn the_rigs_are_slow_enough_for_the_timers() {
    let shoulder = *Rig::<f32>::shoulder(ASSUMED_BASE_RADIUS_MM as f32).unwrap().drum();
    let wrist = *Rig::<f32>::wrist().unwrap().drum();
    // 1500 mm/s on a drum of 15 mm: 15.9 turns a second of 4096 counts
    assert!((fastest_counts_a_second(&shoulder) - 65_190.0).abs() < 10.0);
    assert!(is_slow_enough(&shoulder) && is_slow_enough(&wrist));
    // a level of 3 us, two filter lengths, is two counts: 664 kHz; a rig ten times as fast is past it
    for (times, fits) in [(10.0, true), (10.3, false)] {
        let faster = Drum { fastest_mm_per_s: 1_500.0 * times, ..shoulder };
        assert_eq!(is_slow_enough(&faster), fits, "{times} times as fast");
    }
}

#[test]
fn the_flash_is_checked_before_it_is_written() {
    /// As the chips leave the factory (RM0440, 3.7.8).
    const FACTORY: u32 = 0xFFEF_F8AA;
    let record = (0x0807_D000, 0x0808_0000);
    assert_eq!(record_offset(FACTORY, 512, record), Ok(500 * 1024));
    assert_eq!(record_offset(FACTORY & !(1 << 22), 512, record), Err(LayoutError::SingleBank));
    assert_eq!(record_offset(FACTORY | 1 << 20, 512, record), Err(LayoutError::BanksSwapped));
    for size_kib in [128, 256, 1_024, 0xFFFF] {
        assert_eq!(record_offset(FACTORY, size_kib, record), Err(LayoutError::OtherSize));
    }
    for (from, end) in [
        (0x0803_D000, 0x0804_0000), // in the first bank
        (0x0807_C400, 0x0807_F400), // not at a page
        (0x0807_D000, 0x0807_F800), // five pages
        (0x0807_C000, 0x0808_0000), // eight pages
        (0x0808_0000, 0x0808_3000), // behind the flash
        (0x0000_0000, 0x0000_3000), // not in the flash at all
    ] {
        assert_eq!(record_offset(FACTORY, 512, (from, end)), Err(LayoutError::RecordMisplaced), "{from:#x}");
    }
    let first_possible = FLASH_ORIGIN + 256 * 1024;
    assert_eq!(record_offset(FACTORY, 512, (first_possible, first_possible + 12_288)), Ok(256 * 1024));
}

#[test]
fn a_torn_word_is_told_from_a_broken_program() {
    let (detected, corrected, bank_2, system) = (1 << 31, 1 << 30, 1 << 21, 1 << 22);
    assert_eq!(ecc_verdict(detected | bank_2 | 0x1_2340), EccVerdict::RecordWord);
    assert_eq!(ecc_verdict(detected | 0x1_2340), EccVerdict::ProgramWord);
    assert_eq!(ecc_verdict(detected | bank_2 | system), EccVerdict::ProgramWord);
    assert_eq!(ecc_verdict(corrected | bank_2), EccVerdict::NotFlash);
    assert_eq!(ecc_verdict(0), EccVerdict::NotFlash);
}

#[test]
fn the_reset_flags_name_the_cause() {
    let pin = 1 << 26;
    for (flags, cause) in [
        (1 << 27 | pin, ResetCause::PowerOn),
        (1 << 29 | pin, ResetCause::Watchdog),
        (1 << 28 | pin, ResetCause::Requested),
        (1 << 25 | pin, ResetCause::OptionBytes),
        (pin, ResetCause::Pin),
        (0, ResetCause::Unknown),
        // a power-up clears the others: these came after it, before anybody had read them
        (1 << 27 | 1 << 29 | pin, ResetCause::Watchdog),
        (1 << 27 | 1 << 28 | pin, ResetCause::Requested),
    ] {
        assert_eq!(reset::cause(flags), cause, "{flags:#x}");
    }
}
