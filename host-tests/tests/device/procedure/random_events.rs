//! Random sequences of events: no panic, no state outside the table, no value in use that nobody has chosen. `cargo
//! campaign accepts` plays a million.

use host_tests::campaign::accepts;

#[test]
fn twenty_thousand_random_sequences() {
    let outcome = accepts::run(0..20_000).unwrap();
    assert_eq!(outcome.unseen(), [], "changes of state that no sequence has seen");
    let [by_command, by_button] = outcome.accepted();
    assert!(by_command > 100 && by_button > 20, "{outcome}");
}
