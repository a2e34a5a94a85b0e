//! What the device sends by itself: the protected sets, and the lengths of every captured pose.

use super::bench::Bench;
use glenoid::can::live_set::{LIVE_SET_ID, LIVE_SET_LEN};
use glenoid::can::set::{Piece, Received, Receiver};
use glenoid::can::telemetry::{TELEMETRY_ID, TELEMETRY_LEN};
use glenoid::can::{LiveSet, Message, Standing, Telemetry};
use glenoid::procedure::{PoseSet, StateName};
use nalgebra::{Rotation3, Vector3};

/// All sets in the messages whose check passes, and how many frames of them there were.
fn received<const LEN: usize>(id: u32, pieces: impl Iterator<Item = Piece>) -> (Vec<[u8; LEN]>, usize) {
    let mut receiver = Receiver::<LEN>::new(id);
    let (mut sets, mut frames) = (Vec::new(), 0);
    for piece in pieces {
        frames += 1;
        match receiver.take(piece) {
            Received::Nothing => {}
            Received::Set { data, ahead } => {
                assert!(sets.is_empty() || ahead == Some(1), "{ahead:?}");
                sets.push(data);
            }
            wrong => panic!("{wrong:?}"),
        }
    }
    (sets, frames)
}

fn live_sets(messages: &[Message]) -> Vec<LiveSet> {
    let pieces = messages.iter().filter_map(|m| if let Message::LiveSet(piece) = m { Some(*piece) } else { None });
    let (sets, _) = received::<LIVE_SET_LEN>(LIVE_SET_ID, pieces);
    sets.iter().map(|data| LiveSet::unpack(data).unwrap()).collect()
}

fn telemetry(messages: &[Message]) -> (Vec<Telemetry>, usize) {
    let pieces = messages.iter().filter_map(|m| if let Message::Telemetry(piece) = m { Some(*piece) } else { None });
    let (sets, frames) = received::<TELEMETRY_LEN>(TELEMETRY_ID, pieces);
    (sets.iter().map(|data| Telemetry::unpack(data).unwrap()).collect(), frames)
}

#[test]
fn what_a_controller_acts_on_comes_ten_times_a_second_also_without_a_centre() {
    let mut bench = Bench::new(70);
    bench.take_messages();
    bench.pass(2_000);
    let sets = live_sets(&bench.take_messages());
    assert!((19..=20).contains(&sets.len()), "{}", sets.len());
    assert!(sets.iter().all(|set| set.standing == Standing::NoCentre));
    bench.lead_to(StateName::Review);
    bench.accept();
    bench.take_messages();
    bench.pass(500);
    let live = bench.procedure().live().unwrap().clone();
    let sets = live_sets(&bench.take_messages());
    let set = sets.last().unwrap();
    assert_eq!((set.standing, set.run_id), (Standing::Confirmed, live.run_id));
    // to the last digit
    assert_eq!(set.parameters.map(|p| p.value_mm), live.identified.parameters.to_array());
    assert_eq!(set.offsets.map(|offset| (offset.value_mm, offset.sigma_mm)), [(0.0, 0.0); 6]);
}

#[test]
fn telemetry_shows_lengths_and_rotation_as_they_are() {
    let mut bench = Bench::new(71);
    bench.take_messages();
    bench.pass(1_000);
    let (sets, frames) = telemetry(&bench.take_messages());
    assert!((49..=50).contains(&sets.len()), "{}", sets.len());
    assert!(frames <= 8 * 50, "{frames}");
    bench.lead_to(StateName::Review);
    bench.accept();
    let home = bench.wearer.home();
    bench.glide_to(home.counts);
    bench.at = home;
    let shown_in = |bench: &mut Bench| {
        bench.pass(600);
        bench.take_messages();
        bench.pass(200);
        telemetry(&bench.take_messages()).0.pop().unwrap()
    };
    let at_home = shown_in(&mut bench);
    bench.next_pose();
    let last = shown_in(&mut bench);
    assert!(last.still && last.encoders && last.slack == 0);
    // from home the arm has turned as the wearer has turned it
    let rotation = |shown: &Telemetry| Rotation3::new(Vector3::from(shown.rotation_rad.unwrap()).map(f64::from));
    let turned = rotation(&last) * rotation(&at_home).inverse();
    assert!(turned.angle_to(&bench.at.rotation) < 0.01, "{}", turned.angle_to(&bench.at.rotation));
    let (centre, sigma) = last.centre.unwrap();
    let live = bench.procedure().live().unwrap();
    for (shown, live) in centre.into_iter().zip(live.identified.parameters.centre_mm.iter()) {
        assert!((shown - live).abs() <= 2f32.powi(-17));
    }
    assert!(sigma > 0.0 && sigma < 1.0);
}

#[test]
fn every_captured_pose_sends_its_six_lengths_by_itself() {
    let mut bench = Bench::new(72);
    bench.lead_to(StateName::Collecting);
    bench.take_messages();
    bench.capture(4);
    bench.pass(20);
    let messages = bench.take_messages();
    for (index, pose) in bench.procedure().poses(PoseSet::Identification).iter().enumerate() {
        let mut sent: Vec<(u8, f32)> = messages
            .iter()
            .filter_map(|m| match m {
                Message::RawLength(raw) if usize::from(raw.index) == index => Some((raw.cable, raw.length_mm)),
                _ => None,
            })
            .collect();
        sent.sort_by_key(|(cable, _)| *cable);
        let expected: Vec<(u8, f32)> = (1..).zip(*pose.lengths().as_mm()).collect();
        assert_eq!(sent, expected, "pose {index}");
    }
}

/// A consumer on a bad line: frames are lost, repeated, delayed, and bits flip. It never takes a set that was not sent,
/// nor an older one than it has.
#[test]
fn no_stale_or_mixed_set_is_taken_on_a_bad_line() {
    use rand::{Rng, SeedableRng};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    let mut receiver = Receiver::<LIVE_SET_LEN>::new(LIVE_SET_ID);
    let (mut taken, mut last) = (0u32, None::<u16>);
    let mut delayed: Vec<Piece> = Vec::new();
    let sets = 70_000u32;
    for number in 0..sets {
        let counter = number as u16;
        // what is sent says its own number
        let sent = LiveSet { serial: number, ..LiveSet::default() };
        let data = sent.pack(counter).unwrap();
        for index in 0.. {
            let Some(mut piece) = glenoid::can::set::piece(&data, index, counter) else { break };
            match random.random_range(0..100) {
                0 => continue,
                1 => delayed.push(piece),
                2 => piece[random.random_range(0..8)] ^= 1 << random.random_range(0..8),
                _ => {}
            }
            let mut arriving = vec![piece];
            if random.random_ratio(1, 50) {
                arriving.push(piece);
            }
            if let Some(old) = delayed.pop().filter(|_| random.random_ratio(1, 2)) {
                arriving.insert(0, old);
            }
            for piece in arriving {
                if let Received::Set { data, .. } = receiver.take(piece) {
                    let set = LiveSet::unpack(&data).unwrap();
                    assert_eq!(set, LiveSet { serial: set.serial, ..LiveSet::default() }, "mixed");
                    assert!(set.serial == number || set.serial + 1 == number, "stale: {} at {number}", set.serial);
                    assert!(last.is_none_or(|last| last != set.serial as u16), "twice");
                    last = Some(set.serial as u16);
                    taken += 1;
                }
            }
        }
    }
    assert!(taken > sets / 3, "{taken} of {sets}");
}

#[test]
fn telemetry_is_off_at_zero_and_the_rate_acts_at_once() {
    use glenoid::can::{Operation, ParameterRequest};
    let mut bench = Bench::new(73);
    for (rate, expected) in [(0u32, 0..=0), (10, 9..=10), (100, 98..=101)] {
        let request = ParameterRequest { operation: Operation::Write as u8, index: 190, nonce: 0, value: rate };
        bench.parameter(request);
        bench.pass(20);
        bench.take_messages();
        bench.pass(1_000);
        let (sets, _) = telemetry(&bench.take_messages());
        assert!(expected.contains(&sets.len()), "{rate} Hz: {}", sets.len());
    }
}
