//! A short number that distinguishes two rigs.

use crate::rig::Rig;

/// Fingerprint of a rig's constants: FNV-1a (32 bits) over the bits of its geometry and its drive.
pub fn fingerprint(rig: &Rig<f32>) -> u32 {
    let drum = rig.drum();
    let geometry = rig.base_mm().iter().flat_map(|point| point.iter()).chain(rig.edges_mm());
    // a machine whose cables have ends of their own, or that was commissioned, is another one
    let ends = rig.cables().into_iter().flatten().flat_map(|cable| {
        let pulley = [&cable.pulley.radius_mm].into_iter().chain(cable.pulley.axis.iter());
        cable.base_mm.iter().chain(cable.end_mm.iter()).chain(pulley)
    });
    let found = rig.correction().into_iter().flat_map(|found| found.offset_mm.iter().chain(&found.scale));
    let drive = drum.home_length_mm.iter().chain([&drum.radius_mm, &drum.counts_per_turn]);
    geometry
        .chain(drive)
        .chain(ends)
        .chain(found)
        .flat_map(|constant| constant.to_bits().to_le_bytes())
        .fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

#[cfg(test)]
mod tests {
    use super::fingerprint;
    use crate::rig::Rig;

    #[test]
    fn rigs_are_distinguished() {
        let of = |radius_mm| Rig::shoulder(radius_mm).map(|rig| fingerprint(&rig));
        assert_eq!(of(150.0), of(150.0));
        assert_ne!(of(150.0), of(150.001));
        assert_ne!(of(150.0), Rig::wrist().map(|rig| fingerprint(&rig)));
    }
}
