//! The place of a control loop, and a loop in it that shows how: build with the feature `control-loop`.
//!
//! The sampling interrupts everything else (priority 0) and then runs [`RATE_KHZ`] times a millisecond; each time it calls
//! [`step`] with the fresh counts of the six encoders. The device and all that it computes go on below. What delays a step
//! is another part masking the interrupts for a moment, and nothing else; `board-model/run test --test control_loop`
//! prints by how much. A step must be over well before the next one: at 10 kHz it has 17 000 cycles.
//!
//! The loop here turns the six lengths into the arm's rotation about the centre in use. A loop of your own takes its place
//! behind that: the rotation, the lengths and whether the centre may be used are what it gets.

use core::cell::Cell;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::DWT;
use cortex_m::singleton;
use glenoid::can::Standing;
use glenoid::device::{ControlSet, Device, PublishedControlSet};
use glenoid::kinematics::{AttitudeSearch, AttitudeSolver, CableLengths, CableSet, Geometry, JointCentre};
use glenoid::rig::{CABLES, Rig};
use nalgebra::UnitQuaternion;

/// Steps a millisecond, 1 to 20.
pub const RATE_KHZ: u32 = 10;

/// What the device has published for the loop.
static PUBLISHED: PublishedControlSet = PublishedControlSet::new();

/// The machine, once it is known.
static MACHINE: Mutex<Cell<Option<&'static Machine>>> = Mutex::new(Cell::new(None));

/// The rotation at the last step, or the search for the first one.
static ATTITUDE: Mutex<Cell<Known>> = Mutex::new(Cell::new(Known::Nothing));

#[derive(Clone, Copy)]
enum Known {
    Nothing,
    /// Four assembly modes are tried, a few steps of the iteration in each step of the loop.
    Searching(CableLengths<f32>, AttitudeSearch<f32>),
    Rotation(UnitQuaternion<f32>),
}

/// What was measured, clock cycles.
static LAST_CYCLES: AtomicU32 = AtomicU32::new(0);
static SHORTEST: AtomicU32 = AtomicU32::new(u32::MAX);
static LONGEST: AtomicU32 = AtomicU32::new(0);
static LONGEST_STEP: AtomicU32 = AtomicU32::new(0);
static FOLLOWED: AtomicU32 = AtomicU32::new(0);
static STEPS: AtomicU32 = AtomicU32::new(0);

/// What of the machine does not change.
struct Machine {
    rig: Rig<f32>,
    geometry: Geometry<f32>,
}

/// The machine is known: the loop may begin.
pub fn start(rig: &Rig<f32>) {
    let machine = singleton!(: Machine = Machine { rig: *rig, geometry: Geometry::new(rig) });
    free(|cs| MACHINE.borrow(cs).set(machine.map(|machine| &*machine)));
}

/// Tells the loop what it may go by. Called with every sample of the device.
pub fn publish(device: &Device) {
    PUBLISHED.publish(&device.control_set().to_words());
}

/// One step, in the sampling's interrupt. `began`: the cycle counter when it struck.
pub fn step(counts: &[i32; CABLES], began: u32) {
    note_interval(began);
    if let Some(machine) = free(|cs| MACHINE.borrow(cs).get()) {
        let before = free(|cs| ATTITUDE.borrow(cs).get());
        let known = attitude(machine, counts, before).unwrap_or(Known::Nothing);
        free(|cs| ATTITUDE.borrow(cs).set(known));
        let is_known = matches!(known, Known::Rotation(_));
        FOLLOWED.store(FOLLOWED.load(Ordering::Relaxed).wrapping_add(is_known.into()), Ordering::Relaxed);
        // the loop's own work goes here
    }
    let took = DWT::cycle_count().wrapping_sub(began);
    LONGEST_STEP.store(LONGEST_STEP.load(Ordering::Relaxed).max(took), Ordering::Relaxed);
}

/// The arm's rotation, as far as it is known; None while there is no centre that may be used, and when the lengths fit none.
fn attitude(machine: &Machine, counts: &[i32; CABLES], before: Known) -> Option<Known> {
    let set = ControlSet::from_words(&PUBLISHED.read()?)?;
    if !matches!(set.standing, Standing::Confirmed | Standing::Unconfirmed) {
        return None;
    }
    let lengths = CableLengths::from_counts(&machine.rig, counts).ok()?.less(&set.offsets_mm).ok()?;
    let centre = JointCentre::from_parameters(&set.parameters, &machine.geometry);
    let solver = AttitudeSolver { geometry: &machine.geometry, centre: &centre };
    match before {
        Known::Nothing => Some(Known::Searching(lengths, AttitudeSearch::new())),
        Known::Searching(lengths, mut search) => {
            let is_over = search.advance(&solver, &lengths, CableSet::ALL);
            if is_over {
                search.best().map(|fit| Known::Rotation(fit.attitude))
            } else {
                Some(Known::Searching(lengths, search))
            }
        }
        Known::Rotation(before) => solver.follow(&before, &lengths).map(|fit| Known::Rotation(fit.attitude)),
    }
}

fn note_interval(began: u32) {
    let interval = began.wrapping_sub(LAST_CYCLES.load(Ordering::Relaxed));
    LAST_CYCLES.store(began, Ordering::Relaxed);
    let steps = STEPS.load(Ordering::Relaxed);
    STEPS.store(steps.wrapping_add(1), Ordering::Relaxed);
    // there is no interval before the first step
    if steps != 0 {
        SHORTEST.store(SHORTEST.load(Ordering::Relaxed).min(interval), Ordering::Relaxed);
        LONGEST.store(LONGEST.load(Ordering::Relaxed).max(interval), Ordering::Relaxed);
    }
}

/// Forgets what was measured.
pub fn measure_anew() {
    for (place, value) in [(&SHORTEST, u32::MAX), (&LONGEST, 0), (&LONGEST_STEP, 0), (&FOLLOWED, 0), (&STEPS, 0)] {
        place.store(value, Ordering::Relaxed);
    }
}

/// Says in the log what was measured.
pub fn tell() {
    let get = |place: &AtomicU32| place.load(Ordering::Relaxed);
    // Whatever the log's level: beside the loop there is room for warnings only.
    defmt::println!(
        "control: {=u32} steps, {=u32} of them with a rotation; {=u32} to {=u32} cycles from step to step; a step takes {=u32} at most",
        get(&STEPS),
        get(&FOLLOWED),
        get(&SHORTEST),
        get(&LONGEST),
        get(&LONGEST_STEP)
    );
}
