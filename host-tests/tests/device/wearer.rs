//! The virtual rehabilitator against an inverse kinematics written here from the paper, without the library.

use glenoid::rig::Rig;
use host_tests::wearer::{Mishap, Wearer, WearerSettings};

fn wearer(settings: WearerSettings) -> Wearer {
    Wearer::new(Rig::shoulder(150.0).unwrap(), settings)
}

fn ideal() -> WearerSettings {
    WearerSettings { centre_offset_mm: 0.0, cuff_offset_mm: 0.0, ..Default::default() }
}

type Vector = [f64; 3];

fn on_a_circle(radius: f64, azimuth_deg: f64, z: f64) -> Vector {
    [radius * azimuth_deg.to_radians().cos(), radius * azimuth_deg.to_radians().sin(), z]
}

/// Eq. 2, 3, 5, 6, 8, 9 with Table I: L1 = P1 B1, L2 = P1 B2, L3 = P2 B2, L4 = P2 B3, L5 = P3 B3, L6 = P3 B1.
fn paper_lengths(rotation: [[f64; 3]; 3], centre: Vector, cuff: Vector) -> [f64; 6] {
    let base = [0.0, 120.0, 240.0].map(|azimuth| on_a_circle(150.0, azimuth, 0.0));
    let circumradius = (140.8f64 * 140.8 - 96.0 * 96.0).sqrt();
    let ends = [60.0, 180.0, 300.0].map(|azimuth| {
        let home = on_a_circle(circumradius, azimuth, 96.0);
        let arm: Vector = std::array::from_fn(|k| home[k] + cuff[k]);
        let turned: Vector = std::array::from_fn(|i| (0..3).map(|j| rotation[i][j] * arm[j]).sum());
        std::array::from_fn::<f64, 3, _>(|k| centre[k] + turned[k])
    });
    [(0, 0), (0, 1), (1, 1), (1, 2), (2, 2), (2, 0)]
        .map(|(p, b)| (0..3).map(|k| (ends[p][k] - base[b][k]).powi(2)).sum::<f64>().sqrt())
}

#[test]
fn spans_are_those_of_the_papers_equations() {
    let mut wearer = wearer(WearerSettings { seed: 7, tilt_rad: 1.0, ..Default::default() });
    let centre: Vector = (*wearer.arm().centre_mm()).into();
    let circumradius = (140.8f64 * 140.8 - 96.0 * 96.0).sqrt();
    let nominal = on_a_circle(circumradius, 60.0, 96.0);
    let cuff: Vector = std::array::from_fn(|k| wearer.arm().end_points_mm()[0][k] - nominal[k]);
    assert!(cuff.iter().all(|c| c.abs() <= 10.0) && cuff.iter().any(|c| c.abs() > 0.1), "{cuff:?}");
    for _ in 0..200 {
        let pose = wearer.next_pose();
        let rotation = std::array::from_fn(|i| std::array::from_fn(|j| pose.rotation[(i, j)]));
        for (span, expected) in pose.spans_mm.iter().zip(paper_lengths(rotation, centre, cuff)) {
            assert!((span - expected).abs() < 1e-9, "{span} {expected}");
        }
    }
}

#[test]
fn rotations_are_rotations_within_the_shoulders_range() {
    let settings = WearerSettings { tilt_rad: 0.8, torsion_rad: 0.4, ..Default::default() };
    let mut wearer = wearer(settings);
    let (mut steepest, mut most_turned) = (0f64, 0f64);
    for _ in 0..2000 {
        let rotation = wearer.next_pose().rotation;
        let unity = rotation.matrix() * rotation.matrix().transpose();
        assert!((unity - nalgebra::Matrix3::identity()).norm() < 1e-14 && rotation.matrix().determinant() > 0.0);
        // The long axis of the arm is z at home: its image's angle from z is the tilt.
        let tilt = rotation.matrix()[(2, 2)].acos();
        // What is left when the tilt is undone about its own horizontal axis is the torsion.
        let long_axis = rotation * nalgebra::Vector3::z();
        let untilted = nalgebra::Rotation3::rotation_between(&nalgebra::Vector3::z(), &long_axis).unwrap().inverse();
        let torsion = (untilted * rotation).angle();
        assert!(tilt <= 0.8 + 1e-9 && torsion <= 0.4 + 1e-7, "{tilt} {torsion}");
        (steepest, most_turned) = (steepest.max(tilt), most_turned.max(torsion));
    }
    assert!(steepest > 0.79 && most_turned > 0.395, "the range is used: {steepest} {most_turned}");
}

#[test]
fn an_ideal_wearer_is_table_one_and_rests_at_count_zero() {
    let wearer = wearer(ideal());
    let truth = wearer.truth().to_array();
    for (value, table) in truth.iter().zip([0.0, 0.0, 148.0, 140.8, 140.8, 140.8]) {
        assert!((value - table).abs() < 1e-9, "{truth:?}");
    }
    assert_eq!(wearer.home().counts, [0; 6]);
}

#[test]
fn radii_are_the_distances_of_the_end_points_from_the_true_centre() {
    let wearer = wearer(WearerSettings { seed: 3, ..Default::default() });
    let truth = wearer.truth();
    let offset = truth.centre_mm - nalgebra::Vector3::new(0.0, 0.0, 148.0);
    assert!(offset.iter().all(|x| x.abs() <= 20.0) && offset.norm() > 1.0);
    for (radius, end) in truth.radii_mm.iter().zip(wearer.arm().end_points_mm()) {
        assert!((radius - end.norm()).abs() < 1e-12);
    }
    assert!(truth.radii_mm.iter().any(|r| (r - 140.8).abs() > 0.5), "{:?}", truth.radii_mm);
}

#[test]
fn counts_are_within_half_a_count_of_the_length() {
    // 15 mm drum, 4096 counts a turn.
    let mm_per_count = 2.0 * std::f64::consts::PI * 15.0 / 4096.0;
    let rig = Rig::<f64>::shoulder(150.0).unwrap();
    let home = rig.drum().home_length_mm;
    let mut wearer = wearer(ideal());
    let (mut most, mut differ) = (0f64, false);
    for _ in 0..500 {
        let pose = wearer.next_pose();
        for k in 0..6 {
            let error = home[k] + f64::from(pose.counts[k]) * mm_per_count - pose.spans_mm[k];
            most = most.max(error.abs());
            differ |= error != 0.0;
        }
    }
    assert!(differ && most <= mm_per_count / 2.0 + 1e-9, "{most}");
    assert!(most > mm_per_count * 0.49, "rounding uses the whole half count: {most}");
}

#[test]
fn noise_and_zero_errors_stay_within_their_limits_and_reach_the_counts() {
    let settings = WearerSettings { noise_mm: 0.1, zero_error_mm: 2.0, seed: 9, ..Default::default() };
    let mut wearer = wearer(settings);
    let zero = *wearer.encoder().zero_errors_mm();
    assert!(zero.iter().all(|z| z.abs() <= 2.0) && zero.iter().any(|z| z.abs() > 0.2), "{zero:?}");
    let (mm_per_count, home) = (wearer.encoder().mm_per_count(), Rig::<f64>::shoulder(150.0).unwrap());
    let (mut sum_of_squares, mut count) = (0.0, 0.0);
    for _ in 0..500 {
        let pose = wearer.next_pose();
        for k in 0..6 {
            assert!(pose.errors_mm[k].abs() <= 0.1);
            let believed = home.drum().home_length_mm[k] + f64::from(pose.counts[k]) * mm_per_count;
            let expected = pose.spans_mm[k] + pose.errors_mm[k] - zero[k];
            assert!((believed - expected).abs() <= mm_per_count / 2.0 + 1e-9);
            sum_of_squares += pose.errors_mm[k].powi(2);
            count += 1.0;
        }
    }
    // Uniform within ±0.1: standard deviation 0.1 / sqrt 3.
    let sigma = f64::sqrt(sum_of_squares / count);
    assert!((sigma - 0.1 / 3f64.sqrt()).abs() < 0.002, "{sigma}");
}

#[test]
fn one_seed_gives_one_wearer() {
    let run = |seed, noise_mm| {
        let mut wearer = wearer(WearerSettings { seed, noise_mm, ..Default::default() });
        (0..20).map(|_| wearer.next_pose()).collect::<Vec<_>>()
    };
    assert_eq!(run(5, 0.1), run(5, 0.1));
    assert_ne!(run(5, 0.1), run(6, 0.1));
    // Noise changes the lengths, not the poses.
    let rotations = |poses: Vec<host_tests::wearer::Pose>| poses.into_iter().map(|p| p.rotation).collect::<Vec<_>>();
    assert_eq!(rotations(run(5, 0.0)), rotations(run(5, 0.1)));
}

#[test]
fn the_random_numbers_are_the_same_on_every_machine() {
    // Written down once; a change of generator, order of drawing or arithmetic would show here.
    let mut wearer = wearer(WearerSettings { seed: 1, noise_mm: 0.1, ..Default::default() });
    let counts: Vec<_> = (0..2).map(|_| wearer.next_pose().counts).collect();
    assert_eq!(counts, [[-2210, 673, 886, 1874, -289, 846], [121, 299, 755, 44, 26, 809]]);
}

#[test]
fn a_motion_is_smooth_and_ends_in_the_pose() {
    let mut wearer = wearer(WearerSettings { noise_mm: 0.1, ..Default::default() });
    let (from, to) = (wearer.next_pose(), wearer.next_pose());
    let way = wearer.motion(&from, &to, 500, 10);
    assert_eq!(way.len(), 50);
    assert_eq!(way[49], to.counts);
    // The rig's drive moves 1500 mm/s at most; a shoulder pose change in half a second stays below that.
    let most = (1500.0 * 0.010 / wearer.encoder().mm_per_count()) as i32;
    let mut before = from.counts;
    for counts in way {
        for k in 0..6 {
            assert!((counts[k] - before[k]).abs() <= most);
        }
        before = counts;
    }
    assert_eq!(wearer.motion(&from, &from, 30, 10), [from.counts; 3]);
}

#[test]
fn slack_affects_one_pose_and_a_slip_all_later_ones() {
    let mut clean = wearer(ideal());
    let mut suffering = wearer(ideal());
    suffering.suffer(Mishap::Slack { pose: 1, cable: 2, excess_mm: 5.0 });
    suffering.suffer(Mishap::Slip { pose: 2, cable: 4, by_mm: -3.0 });
    let mm_per_count = clean.encoder().mm_per_count();
    let expected =
        [[0.0; 6], [0.0, 0.0, 5.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, -3.0, 0.0], [0.0, 0.0, 0.0, 0.0, -3.0, 0.0]];
    for change_mm in expected {
        let (a, b) = (clean.next_pose(), suffering.next_pose());
        for k in 0..6 {
            let change = f64::from(b.counts[k] - a.counts[k]) * mm_per_count;
            assert!((change - change_mm[k]).abs() <= mm_per_count, "{change} {change_mm:?}");
        }
    }
}
