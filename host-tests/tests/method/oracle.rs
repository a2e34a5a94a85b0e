//! The oracle itself against what can be known without it: distances, differences, the geometry of Table I.

use crate::common::differences::{central_differences, flattest_mm, relative_difference};
use crate::common::oracle::run;
use crate::common::{Worn, arm, distance, mirrored, one_axis, poses, rng, tilted};
use host_tests::literal::{
    Ending, Failure, Lengths, Machine, Workspace, apex, identify, invert_6x6, pose_model, root_mean_square,
};
use nalgebra::{Matrix6, Rotation3, Vector6};

/// The normal matrix of a pose set at an estimate.
fn normal_matrix(worn: &Worn, poses: &[Lengths<f64>]) -> Matrix6<f64> {
    let mut normal = Matrix6::zeros();
    for (pose, lengths) in poses.iter().enumerate() {
        for row in pose_model(&worn.machine(), &worn.truth(), lengths, pose).expect("truth closes").d {
            let row = Vector6::from(row);
            normal += row * row.transpose();
        }
    }
    normal
}

#[test]
fn the_home_apexes_are_the_home_end_points() {
    for base_radius_mm in [120.0, 150.0, 200.0, 350.0] {
        let worn = Worn::table_one(base_radius_mm);
        let model = pose_model(&worn.machine(), &worn.truth(), &worn.lengths_mm(&Rotation3::identity()), 0).unwrap();
        for (found, expected) in model.end_points_mm.iter().zip(worn.home_mm) {
            assert!((found - expected).norm() < 1e-10, "radius {base_radius_mm}: {found} instead of {expected}");
        }
    }
}

#[test]
fn a_rig_numbered_clockwise_gives_the_same_end_points() {
    let mut rng = rng(1);
    for _ in 0..1000 {
        let worn = Worn::random(&mut rng, 20.0);
        let lengths = worn.lengths_mm(&arm(&mut rng, 25.0));
        let one = pose_model(&worn.machine(), &worn.truth(), &lengths, 0).unwrap();
        let two = pose_model(&worn.mirrored().machine(), &worn.mirrored().truth(), &lengths, 0).unwrap();
        for (p, q) in one.end_points_mm.iter().zip(two.end_points_mm) {
            assert!((mirrored(*p) - q).norm() < 1e-9);
        }
    }
}

#[test]
fn an_apex_has_the_three_distances_and_lies_on_its_side() {
    let mut rng = rng(2);
    for _ in 0..10_000 {
        let worn = Worn::random(&mut rng, 20.0);
        let lengths = worn.lengths_mm(&arm(&mut rng, 30.0));
        let base = [worn.base_mm[0] - worn.centre_mm, worn.base_mm[1] - worn.centre_mm];
        let radius = worn.home_mm[0].norm();
        for (counter_clockwise, sign) in [(true, 1.0), (false, -1.0)] {
            let p = apex(base, radius, [lengths[0], lengths[1]], counter_clockwise).unwrap();
            assert!((p.norm() - radius).abs() < 1e-9); // Eq. 1
            assert!(((p - base[0]).norm() - lengths[0]).abs() < 1e-9); // Eq. 2
            assert!(((p - base[1]).norm() - lengths[1]).abs() < 1e-9); // Eq. 3
            assert!(sign * base[0].cross(&base[1]).dot(&p) >= 0.0);
        }
    }
}

/// The share of end-points that lie beyond their plane O-B_a-B_b, at a tilt in any direction.
fn share_beyond_plane(base_radius_mm: f64, tilt_deg: f64, torsion_deg: f64) -> f64 {
    let mut rng = rng(3);
    let worn = Worn::table_one(base_radius_mm);
    let poses = 20_000;
    let beyond = |arm: &Rotation3<f64>, i: usize| {
        let [a, b] = [i, (i + 1) % 3].map(|base| worn.base_mm[base] - worn.centre_mm);
        a.cross(&b).dot(&(arm * worn.home_mm[i])) < 0.0
    };
    let count = (0..poses).map(|_| {
        let arm = tilted(&mut rng, tilt_deg, torsion_deg);
        (0..3).filter(|&i| beyond(&arm, i)).count()
    });
    count.sum::<usize>() as f64 / f64::from(3 * poses)
}

#[test]
fn the_side_rule_holds_near_home_and_not_far_from_it() {
    for (base_radius_mm, tilt_deg, torsion_deg) in [(120.0, 50.0, 60.0), (120.0, 60.0, 30.0), (350.0, 60.0, 60.0)] {
        assert_eq!(share_beyond_plane(base_radius_mm, tilt_deg, torsion_deg), 0.0);
    }
    let beyond = share_beyond_plane(120.0, 60.0, 60.0);
    assert!((0.02..0.05).contains(&beyond), "{beyond}");
}

#[test]
fn a_tetrahedron_that_does_not_close_is_named() {
    let worn = Worn::table_one(150.0);
    let mut rng = rng(4);
    for pose in 0..5 {
        for end_point in 0..3 {
            let mut lengths = poses(&worn, &mut rng, 5, 20.0);
            lengths[pose][2 * end_point] = 1000.0; // no point 140.8 mm from O is that far from a base point
            let (outcome, deviations) = run(&worn.machine(), &lengths, worn.truth(), 1e-3, 5);
            assert_eq!(outcome.ending, Ending::Failed(Failure::DoesNotClose { pose, end_point }));
            assert!(deviations.is_empty());
        }
    }
}

#[test]
fn d_is_the_derivative_of_the_computed_edges() {
    let mut rng = rng(5);
    let (mut worst, mut compared, mut flat) = (0.0_f64, 0, 0);
    while compared < 10_000 {
        let worn = Worn::random(&mut rng, 20.0);
        let (machine, start) = (worn.machine(), worn.start(&mut rng, 30.0));
        let lengths = worn.lengths_mm(&arm(&mut rng, 30.0));
        let Ok(model) = pose_model(&machine, &start, &lengths, 0) else {
            continue;
        };
        if flattest_mm(&machine, &start, &model) < 1.0 {
            flat += 1;
            continue;
        }
        let expected = central_differences(&machine, &start, &lengths).expect("closes all around");
        worst = worst.max(relative_difference(&model.d, &expected));
        compared += 1;
    }
    assert!(worst < 1e-8, "D is off by {worst}");
    assert!(flat < compared / 100, "{flat} poses too flat to compare");
}

#[test]
fn at_the_truth_of_table_one_nothing_is_left_over() {
    let mut rng = rng(6);
    for base_radius_mm in [120.0, 150.0, 200.0, 350.0] {
        let worn = Worn::table_one(base_radius_mm);
        for lengths in poses(&worn, &mut rng, 100, 25.0) {
            let model = pose_model(&worn.machine(), &worn.truth(), &lengths, 0).unwrap();
            assert!(model.y_mm.iter().all(|y| y.abs() < 1e-9), "{:?}", model.y_mm);
        }
    }
}

#[test]
fn the_printed_edge_of_table_one_leaves_more_than_epsilon() {
    let worn = Worn::table_one(150.0);
    let machine = Machine { edges_mm: [178.4; 3], ..worn.machine() };
    let model = pose_model(&machine, &worn.truth(), &worn.lengths_mm(&Rotation3::identity()), 0).unwrap();
    // sqrt(3 (140.8² - 96²)) = 178.398206...
    assert!((root_mean_square(&model.y_mm) - 1.794e-3).abs() < 1e-6);
}

#[test]
fn two_poses_leave_the_centre_free_along_the_axis_of_their_relative_rotation() {
    let mut rng = rng(7);
    for _ in 0..1000 {
        let worn = Worn::random(&mut rng, 20.0);
        let [one, two] = [arm(&mut rng, 25.0), arm(&mut rng, 25.0)];
        let Some(axis) = (two * one.inverse()).axis() else {
            continue;
        };
        let normal = normal_matrix(&worn, &[worn.lengths_mm(&one), worn.lengths_mm(&two)]);
        let eigen = normal.symmetric_eigen();
        let mut order: Vec<usize> = (0..6).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let (smallest, next) = (eigen.eigenvalues[order[0]], eigen.eigenvalues[order[1]]);
        assert!(smallest.abs() < 1e-13 && next > 1e-7, "rank is not five: {}", eigen.eigenvalues);

        // A centre that moves by the axis n changes p_i by -n·OP_i / p_i, the same in both poses.
        let radii = worn.home_mm.map(|p| -axis.dot(&(one * p)) / p.norm());
        let expected = Vector6::new(axis.x, axis.y, axis.z, radii[0], radii[1], radii[2]).normalize();
        let null = eigen.eigenvectors.column(order[0]);
        assert!(null.dot(&expected).abs() > 1.0 - 1e-9, "{null} instead of {expected}");
    }
}

#[test]
fn poses_about_one_axis_are_singular_and_others_are_not() {
    let mut rng = rng(8);
    let singular = Ending::Failed(Failure::SingularNormalMatrix);
    for count in [2, 3, 10, 100] {
        for _ in 0..300 {
            let worn = Worn::random(&mut rng, 20.0);
            // ε = 0 is never reached, so that a step is tried even at the truth.
            let lengths = one_axis(&worn, &mut rng, count, 20.0);
            let (outcome, _) = run(&worn.machine(), &lengths, worn.truth(), 0.0, 1);
            assert_eq!(outcome.ending, singular, "{count} poses about one axis");
            let lengths = poses(&worn, &mut rng, count.max(3), 20.0);
            let (outcome, _) = run(&worn.machine(), &lengths, worn.truth(), 0.0, 1);
            assert_ne!(outcome.ending, singular, "{count} free poses");
        }
    }
}

#[test]
fn the_inverse_of_a_normal_matrix_is_its_inverse() {
    let mut rng = rng(9);
    for _ in 0..1000 {
        let worn = Worn::random(&mut rng, 20.0);
        let normal = normal_matrix(&worn, &poses(&worn, &mut rng, 10, 20.0));
        let inverse = invert_6x6(&normal.transpose().data.0).unwrap();
        let product = normal * Matrix6::from_fn(|row, column| inverse[row][column]);
        assert!((product - Matrix6::identity()).amax() < 1e-10);
    }
}

#[test]
fn starts_within_ten_millimetres_converge() {
    let mut rng = rng(10);
    for (base_radius_mm, least_of_1000) in [(150.0, 970), (350.0, 1000)] {
        let worn = Worn::table_one(base_radius_mm);
        let (machine, truth) = (worn.machine(), worn.truth());
        let mut converged = 0;
        for _ in 0..1000 {
            let lengths = poses(&worn, &mut rng, 6, 30.0);
            let (outcome, deviations) = run(&machine, &lengths, worn.start(&mut rng, 10.0), 1e-3, 20);
            if let Ending::Failed(Failure::DoesNotClose { .. }) = outcome.ending {
                continue; // the paper's own weakness, with a small base and large tilts
            }
            assert_eq!(outcome.ending, Ending::Converged);
            converged += 1;
            assert!(outcome.iterations <= 5, "{outcome:?}");
            assert_eq!(deviations.len(), outcome.iterations + 1);
            assert!(deviations[..outcome.iterations].iter().all(|&deviation| deviation >= 1e-3));
            assert!(deviations[outcome.iterations] < 1e-3);
            // The paper's Table II: errors of 1e-6 mm and less after the last step.
            let (one_more, _) = run(&machine, &lengths, outcome.estimate, 0.0, 1);
            assert!(distance(&one_more.estimate, &truth) < 1e-6, "{one_more:?}");
        }
        assert!(converged >= least_of_1000, "radius {base_radius_mm}: {converged} of 1000 converged");
    }
}

#[test]
fn too_little_memory_is_said_and_not_written_past() {
    let worn = Worn::table_one(150.0);
    let lengths = poses(&worn, &mut rng(11), 3, 20.0);
    for (rows, residues, deviations) in [(8, 9, 3), (9, 8, 3), (9, 9, 2)] {
        let (mut d, mut y, mut e) = (vec![[0.0; 6]; rows], vec![0.0; residues], vec![0.0; deviations]);
        let mut workspace = Workspace { d: &mut d, y_mm: &mut y, deviations_mm: &mut e };
        let outcome = identify(&worn.machine(), &lengths, worn.truth(), 1e-3, 2, &mut workspace);
        assert_eq!(outcome.ending, Ending::Failed(Failure::TooLittleRoom));
    }
}
