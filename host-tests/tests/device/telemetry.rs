//! Telemetry on a crowded bus; `cargo campaign telemetry` plays a million sets.

use host_tests::campaign::telemetry;

#[test]
fn a_consumer_on_a_crowded_bus_takes_no_mixed_and_no_stale_set() {
    let outcome = telemetry::run(20_000, 2).unwrap();
    assert!(outcome.holds(), "{outcome}");
    assert!(outcome.sent > 19_000 && outcome.commands > 500, "{outcome}");
}
