//! One description against the other, register by register and field by field.
//!
//! What counts is where a field lies: a field whose bits the other description does not have as one field is a
//! difference. Names are compared only where a name stands at different bits, since the two spell many names otherwise.

use crate::{Bits, Block, Register, mask};
use std::fmt;

/// One difference.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Difference {
    /// Peripheral and register.
    pub register: String,
    /// What differs.
    pub what: What,
}

/// What differs in a register.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum What {
    /// The driver's description has no such register.
    OnlyVendor,
    /// Only the vendor's description has this field.
    VendorField(Bits, String),
    /// Only the driver's description has this field.
    DriverField(Bits, String),
    /// The same name stands at other bits: vendor's, driver's.
    Moved(String, Bits, Bits),
}

impl fmt::Display for Difference {
    /// As a line of the list of known differences, without its reason.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let register = &self.register;
        match &self.what {
            What::OnlyVendor => write!(f, "{register}: only the vendor has it"),
            What::VendorField(bits, name) => write!(f, "{register}.{name}: only the vendor has {bits}"),
            What::DriverField(bits, name) => write!(f, "{register}.{name}: only the driver has {bits}"),
            What::Moved(name, vendor, driver) => {
                write!(f, "{register}.{name}: the vendor has {vendor}, the driver {driver}")
            }
        }
    }
}

impl fmt::Display for Bits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.width {
            1 => write!(f, "bit {}", self.from),
            width => write!(f, "bits {}:{}", self.from, self.from + width - 1),
        }
    }
}

/// All differences in the registers that `vendor` has, and how many fields are alike.
pub fn compare(peripheral: &str, vendor: &Block, driver: &Block) -> (Vec<Difference>, usize) {
    let mut differences = Vec::new();
    let mut alike = 0;
    for (offset, register) in vendor {
        let name = format!("{peripheral}.{}", register.name);
        let mut differ = |what| differences.push(Difference { register: name.clone(), what });
        let Some(other) = driver.get(offset) else {
            differ(What::OnlyVendor);
            continue;
        };
        let only = |one: &Register, other: &Register| -> Vec<(Bits, String)> {
            let missing = one.fields.iter().filter(|(bits, _)| !is_in(**bits, one, other));
            missing.map(|(bits, names)| (*bits, names.iter().next().cloned().unwrap_or_default())).collect()
        };
        let (of_vendor, mut of_driver) = (only(register, other), only(other, register));
        for (bits, field) in of_vendor {
            match of_driver.iter().position(|(_, name)| *name == field) {
                Some(at) => differ(What::Moved(field, bits, of_driver.remove(at).0)),
                None => differ(What::VendorField(bits, field)),
            }
        }
        for (bits, field) in of_driver {
            differ(What::DriverField(bits, field));
        }
        alike += register.fields.keys().filter(|bits| is_in(**bits, register, other)).count();
    }
    differences.sort();
    (differences, alike)
}

/// The field of `one` is a field of `other` as well. One description may have a row of fields where the other has them as
/// one: the bits are the same.
fn is_in(bits: Bits, one: &Register, other: &Register) -> bool {
    let divides_alike = |whole: &&Bits| mask(**whole) & mask(bits) == mask(bits) && is_row(**whole, one);
    other.fields.contains_key(&bits) || is_row(bits, other) || other.fields.keys().any(|whole| divides_alike(&whole))
}

/// The register has several fields that make up exactly these bits.
fn is_row(bits: Bits, register: &Register) -> bool {
    let inside = register.fields.keys().filter(|field| mask(**field) & !mask(bits) == 0 && **field != bits);
    inside.fold(0, |row, field| row | mask(*field)) == mask(bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn register(fields: &[(u32, u32, &str)]) -> Block {
        let names = |name: &str| BTreeSet::from([name.to_owned()]);
        let fields = fields.iter().map(|(from, width, name)| (Bits { from: *from, width: *width }, names(name)));
        Block::from([(0, Register { name: "R".to_owned(), fields: fields.collect(), reset: None })])
    }

    fn differences(vendor: &[(u32, u32, &str)], driver: &[(u32, u32, &str)]) -> Vec<String> {
        compare("P", &register(vendor), &register(driver)).0.iter().map(Difference::to_string).collect()
    }

    #[test]
    fn a_field_at_other_bits_is_told_with_both_places() {
        assert_eq!(differences(&[(8, 1, "A")], &[(0, 1, "A")]), ["P.R.A: the vendor has bit 8, the driver bit 0"]);
    }

    #[test]
    fn a_field_of_another_width_is_told() {
        assert_eq!(
            differences(&[(4, 3, "A")], &[(4, 2, "A")]),
            ["P.R.A: the vendor has bits 4:6, the driver bits 4:5"]
        );
    }

    #[test]
    fn a_field_that_only_one_has_is_told() {
        assert_eq!(differences(&[(1, 1, "A")], &[]), ["P.R.A: only the vendor has bit 1"]);
        assert_eq!(differences(&[], &[(1, 1, "A")]), ["P.R.A: only the driver has bit 1"]);
    }

    #[test]
    fn a_row_of_bits_is_the_field_that_they_make_up() {
        let row = [(0, 1, "A0"), (1, 1, "A1"), (2, 1, "A2")];
        assert!(differences(&[(0, 3, "A")], &row).is_empty());
        assert!(differences(&row, &[(0, 3, "A")]).is_empty());
        // one of them is missing
        assert_eq!(differences(&[(0, 3, "A")], &row[..2]).len(), 3);
    }

    #[test]
    fn a_register_that_only_the_vendor_has_is_told() {
        let (differences, _) = compare("P", &register(&[(0, 1, "A")]), &Block::new());
        assert_eq!(differences.iter().map(Difference::to_string).collect::<Vec<_>>(), ["P.R: only the vendor has it"]);
    }
}
