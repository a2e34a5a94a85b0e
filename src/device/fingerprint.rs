//! A short number that distinguishes two rigs.

use crate::identification::hinge::Drawing;
use crate::procedure::ModuleRig;
use crate::procedure::elbow::ElbowRig;
use crate::rig::{CableEnds, Rig, Tolerance};

/// Fingerprint of a rig's constants: FNV-1a (32 bits) over the bits of its geometry, its drive and its tolerances.
pub fn fingerprint(rig: &Rig<f32>) -> u32 {
    let mut hash = Fnv(0x811C_9DC5);
    for_each_number(rig, &mut |numbers| hash.add(numbers));
    hash.0
}

/// The same of a module's, whichever joint it is about.
pub fn module_fingerprint(rig: &ModuleRig) -> u32 {
    match rig {
        ModuleRig::Ball(rig) => fingerprint(rig),
        ModuleRig::Hinge(rig) => {
            let mut hash = Fnv(0x811C_9DC5);
            for_each_number_of_elbow(rig, &mut |numbers| hash.add(numbers));
            hash.0
        }
    }
}

/// The numbers of an elbow's rig in their order: no ball's rig has so few.
pub(super) fn for_each_number_of_elbow(rig: &ElbowRig, add: &mut impl FnMut(&[f32])) {
    let hinge = rig.hinge();
    add(&[hinge.cables().len() as f32]);
    hinge.cables().iter().for_each(|cable| add_cable(cable, add));
    let drum = rig.drum();
    add(&drum.home_length_mm);
    add(&[drum.radius_mm, drum.counts_per_turn]);
    add_tolerance(hinge.tolerance(), add);
    if let Some(Drawing { hinge, sigma, range_rad: (lowest, highest) }) = hinge.drawing() {
        add(&hinge.to_array());
        sigma.iter().for_each(|sigma| add(sigma));
        add(&[*lowest, *highest]);
    }
}

fn add_cable(cable: &CableEnds<f32>, add: &mut impl FnMut(&[f32])) {
    add(cable.base_mm.as_slice());
    add(cable.end_mm.as_slice());
    add(&[cable.pulley.radius_mm]);
    add(cable.pulley.axis.as_slice());
}

fn add_tolerance(tolerance: &Tolerance<f32>, add: &mut impl FnMut(&[f32])) {
    let Tolerance { base_mm, edges_mm, offset_mm, drum } = *tolerance;
    add(&[base_mm, edges_mm, offset_mm, drum]);
}

/// The numbers of a rig's geometry, its drive and its tolerances, in their order.
pub(super) fn for_each_number(rig: &Rig<f32>, add: &mut impl FnMut(&[f32])) {
    rig.base_mm().iter().for_each(|point| add(point.as_slice()));
    add(rig.edges_mm());
    let drum = rig.drum();
    add(&drum.home_length_mm);
    add(&[drum.radius_mm, drum.counts_per_turn]);
    // A machine whose cables have ends of their own, or that was commissioned, is another one.
    for cable in rig.cables().into_iter().flatten() {
        add_cable(cable, add);
    }
    if let Some(found) = rig.correction() {
        add(&found.offset_mm);
        add(&found.scale);
    }
    // And one that is known otherwise: a centre is kept with what was found of the machine within its tolerances.
    add_tolerance(rig.tolerance(), add);
}

struct Fnv(u32);

impl Fnv {
    fn add(&mut self, numbers: &[f32]) {
        for byte in numbers.iter().flat_map(|number| number.to_bits().to_le_bytes()) {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::fingerprint;
    use crate::rig::{Rig, Tolerance};

    #[test]
    fn rigs_are_distinguished() {
        let of = |radius_mm| Rig::shoulder(radius_mm).map(|rig| fingerprint(&rig));
        assert_eq!(of(150.0), of(150.0));
        assert_ne!(of(150.0), of(150.001));
        assert_ne!(of(150.0), Rig::wrist().map(|rig| fingerprint(&rig)));
        let hand_built = Rig::shoulder(150.0).and_then(|rig| rig.with_tolerance(Tolerance::hand_built()));
        assert_ne!(of(150.0), hand_built.map(|rig| fingerprint(&rig)));
    }
}
