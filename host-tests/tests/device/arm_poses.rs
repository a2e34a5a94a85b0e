//! The further poses that `cargo arm` proposes, the long way: somebody goes there, and all is identified anew.

use super::arm::{Ball, Scene, csv, turned};
use super::identify::command::numbers;
use nalgebra::{Matrix3, Rotation3, Vector3, Vector6};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

const MODULES: [&str; 3] = ["shoulder", "elbow", "wrist"];

/// The rotation at which a ball's cables are nearest to these lengths (Gauss-Newton, derivatives by differences).
fn rotation_at(ball: &Ball, lengths_mm: &[f64]) -> Rotation3<f64> {
    let read = |rotation: &Rotation3<f64>| Vector6::from_vec(ball.exact_mm(rotation));
    let (wanted, step) = (Vector6::from_column_slice(lengths_mm), 1e-5);
    let mut rotation = Rotation3::identity();
    for _ in 0..30 {
        let now = read(&rotation);
        let columns = [Vector3::x(), Vector3::y(), Vector3::z()]
            .map(|axis| (read(&(Rotation3::from_scaled_axis(axis * step) * rotation)) - now) / step);
        let normal = Matrix3::from_fn(|i, j| columns[i].dot(&columns[j]));
        let gradient = Vector3::from_fn(|i, _| columns[i].dot(&(wanted - now)));
        let turn = normal.try_inverse().unwrap() * gradient;
        rotation = Rotation3::from_scaled_axis(turn * (0.3 / turn.norm()).min(1.0)) * rotation;
    }
    rotation
}

impl Scene {
    /// What a module's encoders read where its cables are nearest to these lengths, with noise, mm.
    fn gone_to(&self, random: &mut ChaCha8Rng, module: usize, lengths_mm: &[f64]) -> Vec<f64> {
        let ball = match module {
            0 => &self.shoulder,
            2 => &self.wrist,
            _ => {
                let squares = |flexion: f64| {
                    let reading = self.elbow.reading_mm(flexion, None);
                    reading.iter().zip(lengths_mm).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
                };
                let flexions = (-2_500..=500).map(|milli| f64::from(milli) * 1e-3);
                let nearest = flexions.min_by(|one, other| squares(*one).total_cmp(&squares(*other))).unwrap();
                return self.elbow.readings_mm(random, &[nearest])[0].to_vec();
            }
        };
        let rotation = rotation_at(ball, lengths_mm);
        let worst = ball.exact_mm(&rotation).iter().zip(lengths_mm).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 0.5, "the proposed lengths are none of the module's: {worst} mm off");
        ball.lengths_mm(random, &rotation)
    }

    /// What a module's encoders read in a pose like those of its log, mm.
    fn gone_anywhere(&self, random: &mut ChaCha8Rng, module: usize) -> Vec<f64> {
        match module {
            0 => {
                let rotation = turned(random, 35.0);
                self.shoulder.lengths_mm(random, &rotation)
            }
            1 => {
                let flexion = -random.random_range(0.0..120.0_f64).to_radians();
                self.elbow.readings_mm(random, &[flexion])[0].to_vec()
            }
            _ => {
                let rotation = turned(random, 25.0);
                self.wrist.lengths_mm(random, &rotation)
            }
        }
    }

    /// What the command finds with these rows after those of a module's log.
    fn found_with(&self, module: usize, rows: &[Vec<f64>]) -> Value {
        let name = MODULES[module];
        self.desk.put(&format!("{name}.csv"), csv(&[&self.logs[module][..], rows].concat()));
        let ran = self.run(&self.arm, "--json");
        self.desk.put(&format!("{name}.csv"), csv(&self.logs[module]));
        assert_eq!(ran.code, Some(0), "{name}: {ran:?}");
        ran.json()
    }
}

/// The hand's σ, root of the summed variances, mm.
fn hand_sigma_mm(found: &Value) -> f64 {
    numbers(&found["hand"], "sigma_mm").iter().map(|sigma| sigma * sigma).sum::<f64>().sqrt()
}

#[test]
fn proposed_poses_bring_what_they_promise_and_more_than_others() {
    for seed in [1, 2] {
        let scene = Scene::new(&format!("arm_poses_{seed}"), seed, 120.0);
        let random = &mut ChaCha8Rng::seed_from_u64(seed ^ 0x905E);
        let before = scene.found_with(0, &[]);
        let lists = before["further_poses"].as_array().unwrap();
        let last = |list: &Value| numbers(list, "hand_sigma_mm")[1];
        assert!(lists.windows(2).all(|pair| last(&pair[0]) <= last(&pair[1])), "the most useful first: {lists:?}");
        for (module, name) in MODULES.iter().enumerate() {
            let proposed = lists.iter().find(|list| list["module"] == *name).unwrap();
            let poses = proposed["poses"].as_array().unwrap();
            let [now_mm, then_mm] = numbers(proposed, "hand_sigma_mm")[..] else { panic!("{proposed}") };
            assert!((now_mm / hand_sigma_mm(&before) - 1.0).abs() < 1e-9);
            assert_eq!((poses.len(), poses[4]["hand_sigma_mm"].as_f64()), (5, Some(then_mm)));
            // What the module alone adds to the hand's variance, before, and as it is predicted.
            let part = |found: &Value| numbers(found, "hand_sigma_by_module_mm")[module];
            let predicted = (part(&before).powi(2) - now_mm * now_mm + then_mm * then_mm).sqrt();

            let rows: Vec<_> =
                poses.iter().map(|pose| scene.gone_to(random, module, &numbers(pose, "lengths_mm"))).collect();
            let after = scene.found_with(module, &rows);
            let ratios = [part(&after) / predicted, hand_sigma_mm(&after) / then_mm];
            assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.05), "{seed}, {name}: {ratios:?}");

            let mut others: Vec<_> = (0..5)
                .map(|_| {
                    let rows: Vec<_> = (0..5).map(|_| scene.gone_anywhere(random, module)).collect();
                    part(&scene.found_with(module, &rows))
                })
                .collect();
            others.sort_by(f64::total_cmp);
            assert!(part(&after) < others[2], "{seed}, {name}: {} is not below the median of {others:?}", part(&after));
        }
    }
}

#[test]
fn proposed_poses_are_told_in_words() {
    let scene = Scene::new("arm_poses_words", 3, 120.0);
    let words = scene.run(&scene.arm, "").words();
    assert!(words.contains("5 more poses of the elbow: hand's sigma "), "{words}");
    assert!(words.contains(" %), elbow "), "{words}");
}
