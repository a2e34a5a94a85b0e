//! The unknown constants of a machine: modes without rigid motion, columns of the Jacobian against differences of lengths,
//! priors.

use crate::common::dense::derivative;
use crate::common::library::{as_cables, rig};
use crate::common::sets::{machines, shoulder};
use crate::common::{Worn, arm, rng};
use glenoid::identification::Machine;
use glenoid::identification::machine::{MachineEstimate, MachineParameter, SCALE_UNIT};
use glenoid::identification::parameters::{Column, Equations, PoseAt};
use glenoid::kinematics::{CableLengths, Geometry, JointCentre, LengthJacobian};
use glenoid::linear_algebra::packed_index;
use glenoid::rig::{ATTACHMENTS, CABLES, CableEnds, Pulley, Rig, Tolerance};
use nalgebra::{Matrix3, SMatrix, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Everything unknown.
const ALL: Tolerance<f64> = Tolerance { base_mm: 0.5, edges_mm: 0.4, offset_mm: 0.3, drum: 1e-3 };

pub fn toleranced(worn: &Worn, tolerance: Tolerance<f64>) -> Rig<f64> {
    rig::<f64>(worn).with_tolerance(tolerance).expect("a tolerance")
}

/// A rig of which every cable has ends of its own, over pulleys.
fn general(rng: &mut ChaCha8Rng, tolerance: Tolerance<f64>) -> Rig<f64> {
    let worn = shoulder();
    let mut jitter = || Vector3::from_fn(|_, _| rng.random_range(-3.0..3.0));
    let cables = core::array::from_fn(|k| CableEnds {
        base_mm: worn.base_mm[ATTACHMENTS[k / 2][k % 2]] + jitter(),
        end_mm: worn.home_mm[k / 2] + jitter(),
        pulley: Pulley { radius_mm: 4.0, axis: Vector3::z() },
    });
    let plain = rig::<f64>(&worn);
    let rig = Rig::with_cables(cables, *plain.drum(), 0.06, *plain.nominal()).expect("a rig");
    rig.with_tolerance(tolerance).expect("a tolerance")
}

/// The displacements of all cable ends of a parameter, by the machine's own estimate of it.
fn displaced(machine: &Machine<f64>, index: usize, by: f64) -> Geometry<f64> {
    *moved(machine, index, by).geometry()
}

/// The machine's estimate with one parameter moved.
fn moved(machine: &Machine<f64>, index: usize, by: f64) -> MachineEstimate<f64> {
    let mut estimate = MachineEstimate::new(machine);
    let mut step = vec![0.0; machine.parameters()];
    step[index] = by;
    estimate.apply(machine, &step);
    estimate
}

/// Parameters of a kind.
fn of_kind(machine: &Machine<f64>, is: impl Fn(MachineParameter) -> bool) -> Vec<usize> {
    (0..machine.parameters()).filter(|index| is(machine.parameter(*index))).collect()
}

/// Distinct points of a body's cable ends under a mode.
fn shifts(before: &[Vector3<f64>; CABLES], after: &[Vector3<f64>; CABLES]) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let mut points: Vec<(Vector3<f64>, Vector3<f64>)> = Vec::new();
    for (before, after) in before.iter().zip(after) {
        if points.iter().all(|(known, _)| (known - before).norm() > 1e-6) {
            points.push((*before, after - before));
        }
    }
    points
}

#[test]
fn parameters_stand_in_the_order_base_ends_offsets_scales() {
    for (name, worn) in machines() {
        let machine = Machine::new(&toleranced(&worn, ALL));
        assert_eq!(machine.parameters(), 18, "{name}");
        let kinds: Vec<_> = (0..18).map(|index| machine.parameter(index)).collect();
        for k in 0..3 {
            assert_eq!(kinds[k], MachineParameter::Base(k));
            assert_eq!(kinds[3 + k], MachineParameter::Ends(k));
        }
        for k in 0..6 {
            assert_eq!(kinds[6 + k], MachineParameter::Offset(k));
            assert_eq!(kinds[12 + k], MachineParameter::Scale(k));
        }
        assert_eq!((machine.first_offset(), machine.first_scale()), (Some(6), Some(12)));
        let exact = Machine::new(&rig::<f64>(&worn));
        assert_eq!((exact.parameters(), exact.first_offset(), exact.first_scale()), (0, None, None));
        let drums = Machine::new(&toleranced(&worn, Tolerance { drum: 1e-3, ..Tolerance::exact() }));
        assert_eq!((drums.parameters(), drums.first_scale()), (6, Some(0)));
    }
    let six = Machine::new(&general(&mut rng(4201), ALL));
    assert_eq!(six.parameters(), 36);
}

#[test]
fn modes_are_orthonormal_and_hold_no_rigid_motion() {
    let mut rng = rng(4202);
    let mut sets: Vec<(Machine<f64>, bool)> =
        machines().iter().map(|(_, w)| (Machine::new(&toleranced(w, ALL)), false)).collect();
    sets.push((Machine::new(&toleranced(&Worn::random(&mut rng, 20.0), ALL)), false));
    sets.push((Machine::new(&general(&mut rng, ALL)), true));
    for (machine, is_general) in &sets {
        let before = machine.geometry();
        let bodies = [
            (of_kind(machine, |kind| matches!(kind, MachineParameter::Base(_))), true),
            (of_kind(machine, |kind| matches!(kind, MachineParameter::Ends(_))), false),
        ];
        for (indices, is_base) in bodies {
            let points = |index: usize| {
                let after = displaced(machine, index, 1.0);
                if is_base { shifts(&before.base_mm, &after.base_mm) } else { shifts(&before.end_mm, &after.end_mm) }
            };
            let modes: Vec<_> = indices.iter().map(|index| points(*index)).collect();
            assert_eq!(modes.len(), if *is_general { 12 } else { 3 });
            // The platform's modes of the 3-3 machine are its edges: see the next test.
            if !is_base && !is_general {
                continue;
            }
            let middle = modes[0].iter().map(|(point, _)| point).sum::<Vector3<f64>>() / modes[0].len() as f64;
            for (i, one) in modes.iter().enumerate() {
                for (j, other) in modes.iter().enumerate() {
                    let product: f64 = one.iter().zip(other).map(|((_, a), (_, b))| a.dot(b)).sum();
                    assert!((product - f64::from(u8::from(i == j))).abs() < 1e-9, "modes {i} and {j}: {product}");
                }
                let translation: Vector3<f64> = one.iter().map(|(_, shift)| shift).sum();
                let rotation: Vector3<f64> = one.iter().map(|(point, shift)| (point - middle).cross(shift)).sum();
                assert!(translation.norm() < 1e-9 && rotation.norm() < 1e-6, "mode {i} moves the body");
            }
        }
    }
}

#[test]
fn a_platform_mode_changes_one_edge_by_as_much() {
    let mut rng = rng(4203);
    for _ in 0..50 {
        let machine = Machine::new(&toleranced(&Worn::random(&mut rng, 20.0), ALL));
        let edges = |geometry: &Geometry<f64>| {
            let [p1, p2, p3] = geometry.end_points_mm();
            [(p2 - p1).norm(), (p3 - p2).norm(), (p1 - p3).norm()]
        };
        let indices = of_kind(&machine, |kind| matches!(kind, MachineParameter::Ends(_)));
        for (edge, index) in indices.into_iter().enumerate() {
            let change = derivative::<3, 1>(|step| edges(&displaced(&machine, index, step[0])));
            let mut expected = SMatrix::<f64, 3, 1>::zeros();
            expected[edge] = 1.0;
            assert!((change - expected).amax() < 1e-6, "edge {edge}: {change}");
            // P1 stays at the origin and P2 on the x axis.
            let [p1, p2, _] = displaced(&machine, index, 1.0).end_points_mm();
            assert!(p1.norm() < 1e-12 && p2.y.abs() < 1e-12 && p2.z.abs() < 1e-12);
        }
    }
}

/// A pose at a wrong estimate.
struct Seen {
    rotation: Matrix3<f64>,
    centre: JointCentre<f64>,
    lengths: CableLengths<f64>,
}

fn seen(rng: &mut ChaCha8Rng, rig: &Rig<f64>, worn: &Worn) -> Seen {
    let geometry = Geometry::new(rig);
    let centre = JointCentre::from_parameters(rig.nominal(), &geometry);
    Seen { rotation: *arm(rng, 30.0).matrix(), centre, lengths: as_cables(&worn.lengths_mm(&arm(rng, 30.0))) }
}

/// Computed minus corrected lengths of a machine estimate, from spans alone.
fn residuals(machine: &Machine<f64>, estimate: &MachineEstimate<f64>, seen: &Seen) -> [f64; CABLES] {
    let geometry = estimate.geometry();
    let corrected = estimate.corrected(machine, &seen.lengths);
    core::array::from_fn(|k| {
        let end = seen.centre.in_base_mm + seen.rotation * (geometry.end_mm[k] - seen.centre.in_platform_mm);
        geometry.span(k, &end).length_mm - corrected.as_mm()[k]
    })
}

#[test]
fn columns_are_the_derivatives_of_the_lengths() {
    let mut rng = rng(4204);
    for trial in 0..40 {
        let worn = if trial % 2 == 0 { Worn::random(&mut rng, 10.0) } else { shoulder() };
        let rig = if trial % 4 == 3 { general(&mut rng, ALL) } else { toleranced(&worn, ALL) };
        let machine = Machine::new(&rig);
        let seen = seen(&mut rng, &rig, &worn);
        let jacobian = LengthJacobian::new(machine.geometry(), &seen.centre, &seen.rotation, &seen.lengths);
        let at = PoseAt { rotation: &seen.rotation, lengths: &seen.lengths, jacobian: &jacobian };
        let here = MachineEstimate::new(&machine);
        for index in 0..machine.parameters() {
            let mine = match here.column(&machine, index, &at) {
                Column::OneCable(cable, change) => {
                    let mut all = [0.0; CABLES];
                    all[cable] = change;
                    all
                }
                Column::AllCables(all) => all,
            };
            // What the reading would be, and so by how much residual = measured - computed falls.
            let expected = derivative::<CABLES, 1>(|step| residuals(&machine, &moved(&machine, index, step[0]), &seen));
            for cable in 0..CABLES {
                let (mine, expected) = (mine[cable], expected[(cable, 0)]);
                // A drum's scale is seen through the modelled length, which differs from the measured one by the residual.
                let scale = matches!(machine.parameter(index), MachineParameter::Scale(of) if of == cable);
                let residual = residuals(&machine, &here, &seen)[cable];
                let expected = if scale { expected + residual * 0.01 } else { expected };
                assert!(
                    (mine - expected).abs() < 1e-6,
                    "{:?}, cable {}: {mine} not {expected}",
                    machine.parameter(index),
                    cable + 1
                );
            }
        }
    }
}

#[test]
fn offsets_and_scales_are_taken_off_about_home() {
    let worn = shoulder();
    let rig = toleranced(&worn, ALL);
    let machine = Machine::new(&rig);
    let home = rig.drum().home_length_mm;
    let mut estimate = MachineEstimate::new(&machine);
    let mut step = vec![0.0; machine.parameters()];
    for k in 0..CABLES {
        step[6 + k] = 0.5 * k as f64 - 1.0;
        step[12 + k] = (0.01 * k as f64 - 0.02) / SCALE_UNIT;
    }
    estimate.apply(&machine, &step);
    // reading = home + k (L - home) + offset
    let truth: [f64; CABLES] = core::array::from_fn(|k| home[k] + 13.0 * k as f64 - 30.0);
    let readings = core::array::from_fn(|k| {
        home[k] + (1.0 + 0.01 * k as f64 - 0.02) * (truth[k] - home[k]) + 0.5 * k as f64 - 1.0
    });
    let corrected = estimate.corrected(&machine, &CableLengths::new(readings).expect("lengths"));
    for (mine, expected) in corrected.as_mm().iter().zip(truth) {
        assert!((mine - expected).abs() < 1e-9, "{mine} instead of {expected}");
    }
    assert!((estimate.scales()[5] - 0.03).abs() < 1e-12);
    assert!((estimate.offsets_mm()[5] - 1.5).abs() < 1e-12);
}

#[test]
fn a_prior_is_one_equation_a_parameter() {
    let machine = Machine::new(&toleranced(&shoulder(), ALL));
    let mut estimate = MachineEstimate::new(&machine);
    let step: Vec<f64> = (0..18).map(|k| 0.1 * f64::from(k) - 0.7).collect();
    estimate.apply(&machine, &step);
    let variance = 0.06 * 0.06;
    let mut equations = Equations::<f64>::new(24);
    estimate.add_prior(&machine, &mut equations, 0, variance);
    let sigma = |index: usize| match machine.parameter(index) {
        MachineParameter::Base(_) => 0.5,
        MachineParameter::Ends(_) => 0.4,
        MachineParameter::Offset(_) => 0.3,
        MachineParameter::Scale(_) => 1e-3 / SCALE_UNIT,
    };
    let mut squares = 0.0;
    for i in 0..18 {
        let weight = variance / (sigma(i) * sigma(i));
        assert!((equations.matrix()[packed_index(i, i)] / weight - 1.0).abs() < 1e-9);
        assert!((equations.gradient()[i] + weight * step[i]).abs() < 1e-12);
        squares += weight * step[i] * step[i];
    }
    assert!((equations.squares() - squares).abs() < 1e-12);
    assert!(equations.matrix()[packed_index(18, 0)..].iter().all(|entry| *entry == 0.0));
    // Correlated, as commissioning leaves it: eᵀ P e with its gradient.
    let root = SMatrix::<f64, 18, 18>::from_fn(|i, j| if i >= j { (1 + (7 * i + 3 * j) % 5) as f64 } else { 0.0 });
    let precision = root * root.transpose();
    let packed: Vec<f64> = (0..18).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|at| precision[at]).collect();
    let machine = machine.with_precision(&packed);
    let mut equations = Equations::<f64>::new(24);
    estimate.add_prior(&machine, &mut equations, 0, 1.0);
    let values = SMatrix::<f64, 18, 1>::from_row_slice(&step);
    let expected = -precision * values;
    for i in 0..18 {
        assert!((equations.gradient()[i] - expected[i]).abs() < 1e-9);
        assert!((0..=i).all(|j| (equations.matrix()[packed_index(i, j)] - precision[(i, j)]).abs() < 1e-9));
    }
    assert!((equations.squares() - values.dot(&(precision * values))).abs() < 1e-9);
}
