//! Whole calibrations with the device, a virtual wearer and a client.

#[path = "device/bench.rs"]
mod bench;

use bench::Bench;
use glenoid::can::{Message, Opcode};
use glenoid::procedure::{Reason, StateName};
use host_tests::wearer::WearerSettings;

fn noisy(seed: u64) -> WearerSettings {
    WearerSettings { seed, noise_mm: 0.1, ..WearerSettings::default() }
}

#[test]
fn a_run_by_commands_finds_the_centre() {
    let mut bench = Bench::new(noisy(7));
    let start = bench.request(Opcode::Start as u8, 0, 1);
    assert_eq!((start.code, start.run_id), (Reason::Fine, 1));
    let mut captured = 0;
    while captured < 20 {
        bench.next_pose();
        let answer = bench.command(Opcode::Capture);
        assert!(matches!(answer.code, Reason::Fine | Reason::PoseTooNear), "{answer:?}");
        captured += u32::from(answer.code == Reason::Fine);
    }
    assert_eq!(bench.command(Opcode::Identify).code, Reason::Fine);
    bench.pass(500);
    assert_eq!(bench.device.procedure().state(), StateName::Verifying);
    for _ in 0..5 {
        bench.next_pose();
        bench.command(Opcode::Capture);
    }
    assert_eq!(bench.command(Opcode::Verify).code, Reason::Fine);
    bench.pass(100);
    assert_eq!(bench.device.procedure().state(), StateName::Review);
    assert_eq!(bench.heartbeat().progress_percent, 100);
    assert_eq!(bench.decide(Opcode::Accept).code, Reason::Fine);
    bench.messages.clear();
    bench.pass(100);

    let truth = bench.wearer.truth().to_array();
    let mut live = [None; 6];
    for message in &bench.messages {
        match message {
            Message::LiveCentre(p) => live[usize::from(p.index)] = Some(*p),
            Message::LiveRadius(p) => live[3 + usize::from(p.index)] = Some(*p),
            _ => {}
        }
    }
    for (value, truth) in live.iter().zip(truth) {
        let value = value.expect("all six parameters are reported");
        assert_eq!(value.run_id, 1);
        // four standard deviations, and the report's own resolution
        let error = (f64::from(value.value_mm) - truth).abs();
        assert!(error < 4.0 * f64::from(value.sigma_mm) + 1e-4, "{value:?} {truth}");
        assert!(value.sigma_mm < 0.2, "{value:?}");
    }
}
