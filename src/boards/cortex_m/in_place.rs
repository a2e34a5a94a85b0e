//! The device in its place.

use core::mem::MaybeUninit;

use cortex_m::singleton;
use glenoid::device::{Config, Device};
use glenoid::procedure::ModuleRig;
use glenoid::procedure::elbow::ElbowRig;
use glenoid::rig::Rig;

/// The device in its place; `None` if it was called before.
pub fn device(config: &Config) -> Option<&'static mut Device> {
    let place = singleton!(: MaybeUninit<Device> = MaybeUninit::uninit())?;
    Some(match &config.rig {
        ModuleRig::Ball(rig) => of_ball(place, config, rig),
        ModuleRig::Hinge(rig) => of_hinge(place, config, rig),
    })
}

// Frames of their own: what building it takes of the stack (`cargo stack --ways`) is free again before anything else runs. Two,
// for in a single one both joints' procedures would lie on the stack.
#[inline(never)]
fn of_ball(place: &'static mut MaybeUninit<Device>, config: &Config, rig: &Rig<f32>) -> &'static mut Device {
    place.write(Device::of_ball(config, rig))
}

#[inline(never)]
fn of_hinge(place: &'static mut MaybeUninit<Device>, config: &Config, rig: &ElbowRig) -> &'static mut Device {
    place.write(Device::of_hinge(config, rig))
}
