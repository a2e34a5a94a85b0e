//! The memory protection unit, as far as this firmware uses it: regions that nobody may touch.

use crate::breach::{Breaches, Rule};

const REGIONS: usize = 8;
const REGION_VALID: u32 = 1 << 4;

/// The unit (ARMv7-M ARM, B3.5).
#[derive(Debug, Clone, Default)]
pub struct Mpu {
    control: u32,
    region: usize,
    base: [u32; REGIONS],
    attributes: [u32; REGIONS],
}

impl Mpu {
    /// Reads from 0xE000ED90 on.
    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            0x0 => (REGIONS as u32) << 8,
            0x4 => self.control,
            0x8 => self.region as u32,
            0xC => self.base[self.region],
            0x10 => self.attributes[self.region],
            _ => 0,
        }
    }

    /// Writes from 0xE000ED90 on.
    pub fn write(&mut self, offset: u32, value: u32, breaches: &mut Breaches) {
        match offset {
            0x4 => self.control = value & 7,
            0x8 => self.region = value as usize % REGIONS,
            0xC => {
                if value & REGION_VALID != 0 {
                    self.region = value as usize & 0xF;
                }
                self.base[self.region] = value & !0x1F;
            }
            0x10 => {
                self.attributes[self.region] = value;
                let access = value >> 24 & 7;
                if value & 1 != 0 && access != 0 {
                    breaches.add(Rule::Architecture, format!("MPU: access permission {access}, which the model lacks"));
                }
                let len = Self::len(value);
                if value & 1 != 0 && u64::from(self.base[self.region]) % len != 0 {
                    breaches.add(Rule::Architecture, "MPU: a region that does not lie at a multiple of its length");
                }
            }
            _ => {}
        }
    }

    fn len(attributes: u32) -> u64 {
        1 << ((attributes >> 1 & 0x1F) + 1)
    }

    /// The regions that are forbidden now: address and length. Hard fault and NMI run without the unit unless HFNMIENA is
    /// set.
    pub fn forbidden(&self, in_hard_fault: bool) -> Vec<(u32, u64)> {
        let is_on = self.control & 1 != 0 && (!in_hard_fault || self.control & 2 != 0);
        (0..REGIONS)
            .filter(|region| is_on && self.attributes[*region] & 1 != 0)
            .map(|region| (self.base[region], Self::len(self.attributes[region])))
            .collect()
    }

    /// The address lies in a forbidden region.
    pub fn forbids(&self, address: u32, in_hard_fault: bool) -> bool {
        let inside = |(from, len): &(u32, u64)| (u64::from(*from)..u64::from(*from) + len).contains(&address.into());
        self.forbidden(in_hard_fault).iter().any(|region| inside(region))
    }
}
