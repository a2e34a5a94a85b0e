//! The hinge against oracles of its own: central differences, the whole information matrix, the Cramér-Rao bound.

use glenoid::identification::hinge::{HINGE_UNKNOWNS, HingeEstimator, HingePose, HingeSettings};
use glenoid::rig::Tolerance;
use host_tests::study::elbow::bound;
use host_tests::study::elbow::scene::{Elbow, flexions_rad};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

#[test]
fn try_it() {
    let (mut zs, mut n) = ([0.0; HINGE_UNKNOWNS], 0);
    let begin = std::time::Instant::now();
    for t in 0..40 {
        let mut random = ChaCha8Rng::seed_from_u64(t);
        let elbow = Elbow::random(&mut random, 4, &Tolerance::exact());
        let flexions = flexions_rad(&mut random, 30, 120.0);
        let rig = elbow.rig(Tolerance::exact()).unwrap();
        let mut poses: Vec<_> = elbow.readings_mm(&mut random, &flexions).into_iter().map(HingePose::new).collect();
        match HingeEstimator::new(&rig, HingeSettings::for_rig(&rig)).run(&mut poses) {
            Ok(found) => {
                let e = found.hinge.difference(&elbow.hinge());
                let s = found.sigmas();
                let b = bound::bound(&elbow.hinge(), &elbow.stated, &flexions, None).unwrap();
                println!(
                    "{t} {:?} ratio sigma/bound {:?}",
                    e.iter().zip(&s).map(|(e, s)| (e / s * 10.0).round() / 10.0).collect::<Vec<_>>(),
                    (0..9).map(|k| (s[k] / b[(k, k)].sqrt() * 1000.0).round() / 1000.0).collect::<Vec<_>>()
                );
                for k in 0..9 {
                    zs[k] += (e[k] / s[k]).powi(2);
                }
                n += 1;
            }
            Err(refusal) => println!("{t} {refusal:?}"),
        }
    }
    println!("{n} r {:?} {:?}", zs.map(|z| (z / n as f64).sqrt()), begin.elapsed());
    panic!();
}
