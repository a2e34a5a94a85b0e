//! A short number that distinguishes two rigs.

use crate::rig::{Rig, Tolerance};

/// Fingerprint of a rig's constants: FNV-1a (32 bits) over the bits of its geometry, its drive and its tolerances.
pub fn fingerprint(rig: &Rig<f32>) -> u32 {
    let drum = rig.drum();
    let geometry = rig.base_mm().iter().flat_map(|point| point.iter()).chain(rig.edges_mm());
    // a machine whose cables have ends of their own, or that was commissioned, is another one
    let ends = rig.cables().into_iter().flatten().flat_map(|cable| {
        let pulley = [&cable.pulley.radius_mm].into_iter().chain(cable.pulley.axis.iter());
        cable.base_mm.iter().chain(cable.end_mm.iter()).chain(pulley)
    });
    // and one that is known otherwise: a centre is kept with what was found of the machine within its tolerances
    let Tolerance { base_mm, edges_mm, offset_mm, drum: relative } = rig.tolerance();
    let found = rig.correction().into_iter().flat_map(|found| found.offset_mm.iter().chain(&found.scale));
    let drive = drum.home_length_mm.iter().chain([&drum.radius_mm, &drum.counts_per_turn]);
    geometry
        .chain(drive)
        .chain(ends)
        .chain(found)
        .chain([base_mm, edges_mm, offset_mm, relative])
        .flat_map(|constant| constant.to_bits().to_le_bytes())
        .fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
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
