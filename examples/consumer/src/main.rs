//! The least that a firmware of one's own needs: six lengths in, the platform's pose out. No runtime crate, no heap.
#![no_std]
#![no_main]

use glenoid::kinematics::{CableLengths, ForwardKinematics};
use glenoid::rig::Rig;

/// Where the platform's origin lies in the base, mm, for the six lengths `lengths_mm`.
fn origin_mm(lengths_mm: [f32; 6]) -> Option<[f32; 3]> {
    let rig = Rig::<f32>::shoulder(150.0).ok()?;
    let pose = ForwardKinematics::new(&rig).solve(&CableLengths::new(lengths_mm).ok()?).ok()?;
    Some(pose.origin_mm.into())
}

/// The linker's entry; a real firmware has its start-up code here.
#[unsafe(no_mangle)]
extern "C" fn _start() -> ! {
    let lengths_mm = core::hint::black_box([277.9; 6]);
    core::hint::black_box(origin_mm(lengths_mm));
    loop {}
}

#[panic_handler]
fn on_panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
