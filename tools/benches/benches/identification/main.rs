//! `cargo bench --package benches`: one identification, and many at once on all cores, beside the `levenberg-marquardt` crate on the same
//! problem (100 noise-free poses, start 25 mm off; `host-tests/data/speed-problem.*`).
//!
//! The crate is given the library's own closed-form model, so that only the solvers differ, and the library's stop:
//! δE < 1e-3 mm ends it.

// criterion's macro makes a public function without a word on it
#![allow(missing_docs)]

mod levenberg_marquardt_form;

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glenoid::identification::{Estimator, EstimatorSettings, Machine, Pose};
use glenoid::kinematics::CableLengths;
use glenoid::paper::{PaperIteration, PaperSettings};
use glenoid::rig::{Parameters, Rig};
use glenoid::scalar::Real;
use host_tests::identify::lengths_file::LengthsFile;
use host_tests::identify::rig_file::{RigFile, in_precision};
use rayon::prelude::*;

use levenberg_marquardt_form::Form;

const LENGTHS: &[u8] = include_bytes!("../../../../host-tests/data/speed-problem.csv");
const RIG: &[u8] = include_bytes!("../../../../host-tests/data/speed-problem.toml");
/// Centre and radii that all must find, mm, and how near.
const TRUTH_MM: [f64; 6] = [0.0, 0.0, 148.0, 140.8, 140.8, 140.8];
const NEAR_MM: f64 = 1e-2;
/// Identifications of one batch in parallel, each from a start of its own.
const MANY: usize = 2_000;

/// What all solvers are given.
pub struct Problem<T> {
    pub rig: Rig<T>,
    pub start: Parameters<T>,
    pub poses: Vec<CableLengths<T>>,
}

impl<T: Real> Problem<T> {
    fn read() -> Self {
        let file = RigFile::parse("speed-problem.toml", RIG).expect("the rig of the problem");
        let log = LengthsFile::parse("speed-problem.csv", LENGTHS).expect("the lengths of the problem");
        let start = file.start_mm.expect("the start of the problem").map(T::of);
        Self {
            rig: in_precision(&file.rig).expect("the rig in this precision"),
            start: Parameters::from_array(start),
            poses: log.rows().iter().map(|row| log.cables(row).expect("sound lengths")).collect(),
        }
    }

    /// The `index`-th start: on the way from the problem's own to the truth, half of it at most. All of them converge.
    fn start(&self, index: usize) -> Parameters<T> {
        let (start, truth) = (self.start.to_array(), TRUTH_MM.map(T::of));
        let share = T::of((index % 201) as f64 / 400.0);
        Parameters::from_array(std::array::from_fn(|k| start[k] + (truth[k] - start[k]) * share))
    }

    fn paper(&self, start: Parameters<T>) -> Parameters<T> {
        let iteration = PaperIteration::new(&self.rig, start, PaperSettings::default());
        checked(iteration.run(&self.poses).expect("the paper's iteration converges").parameters)
    }

    fn start_free(&self) -> Parameters<T> {
        let machine = Machine::new(&self.rig);
        let mut poses: Vec<_> = self.poses.iter().copied().map(Pose::new).collect();
        let mut estimator = Estimator::new(&machine, self.rig.nominal(), EstimatorSettings::for_rig(&self.rig));
        checked(estimator.run(&machine, &mut poses).expect("the estimator accepts the set").parameters)
    }
}

/// A figure for a wrong centre would be worth nothing.
fn checked<T: Real>(parameters: Parameters<T>) -> Parameters<T> {
    let found = parameters.centre_mm.map(|x| x.to_f64());
    let miss = (0..3).fold(0.0, |sum: f64, k| sum + (found[k] - TRUTH_MM[k]).powi(2)).sqrt();
    assert!(miss < NEAR_MM, "{miss} mm off");
    parameters
}

fn one(criterion: &mut Criterion) {
    let (double, single) = (Problem::<f64>::read(), Problem::<f32>::read());
    let mut group = criterion.benchmark_group("one identification, 100 poses");
    group.bench_function("paper, f32", |b| b.iter(|| single.paper(black_box(single.start))));
    group.bench_function("paper, f64", |b| b.iter(|| double.paper(black_box(double.start))));
    group.bench_function("start-free, f32", |b| b.iter(|| black_box(&single).start_free()));
    group.bench_function("start-free, f64", |b| b.iter(|| black_box(&double).start_free()));
    group.bench_function("levenberg-marquardt, f64", |b| {
        b.iter_batched(|| Form::new(&double, double.start), |form| checked(form.minimise()), BatchSize::SmallInput);
    });
    group.finish();
}

fn many(criterion: &mut Criterion) {
    let (double, single) = (Problem::<f64>::read(), Problem::<f32>::read());
    let mut group = criterion.benchmark_group("identifications on all cores");
    group.throughput(Throughput::Elements(MANY as u64)).sample_size(10);
    group.bench_function("paper, f32", |b| {
        b.iter(|| (0..MANY).into_par_iter().map(|k| single.paper(single.start(k)).radii_mm[0]).sum::<f32>());
    });
    group.bench_function("paper, f64", |b| {
        b.iter(|| (0..MANY).into_par_iter().map(|k| double.paper(double.start(k)).radii_mm[0]).sum::<f64>());
    });
    group.bench_function("levenberg-marquardt, f64", |b| {
        let run = |k: usize| checked(Form::new(&double, double.start(k)).minimise()).radii_mm[0];
        b.iter(|| (0..MANY).into_par_iter().map(run).sum::<f64>());
    });
    group.finish();
}

criterion_group!(benches, one, many);
criterion_main!(benches);
