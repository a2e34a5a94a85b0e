//! One description against the other, register by register and field by field.
//!
//! A field whose bits the other description does not have as one field is a difference. So is a name that both have, but at other
//! bits: two fields of one width that change places leave the same bits in use. A name that only one has says nothing, since
//! the two spell many names otherwise.

use crate::{Bits, Block, Register, mask};
use std::collections::{BTreeMap, BTreeSet};
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
        let moved = moved(register, other);
        let is_moved = |name: &str| moved.iter().any(|(moved, ..)| moved == name);
        let only = |one: &Register, other: &Register| -> Vec<(Bits, String)> {
            let missing = one.fields.iter().filter(|(bits, _)| !is_in(**bits, one, other));
            let named = missing.map(|(bits, names)| (*bits, names.iter().next().cloned().unwrap_or_default()));
            named.filter(|(_, name)| !is_moved(name)).collect()
        };
        let (of_vendor, of_driver) = (only(register, other), only(other, register));
        of_vendor.into_iter().for_each(|(bits, field)| differ(What::VendorField(bits, field)));
        of_driver.into_iter().for_each(|(bits, field)| differ(What::DriverField(bits, field)));
        let is_alike = |bits: Bits, names: &BTreeSet<String>| {
            is_in(bits, register, other) && !names.iter().any(|name| is_moved(name))
        };
        alike += register.fields.iter().filter(|(bits, names)| is_alike(**bits, names)).count();
        moved.into_iter().for_each(|(name, vendor, driver)| differ(What::Moved(name, vendor, driver)));
    }
    differences.sort();
    (differences, alike)
}

/// Names that both have, at other bits: the name, the vendor's place and the driver's. A row of fields may share its name with one of
/// them, so a place within the other one is the same place if the row is complete.
fn moved(vendor: &Register, driver: &Register) -> Vec<(String, Bits, Bits)> {
    let (of_vendor, of_driver) = (places(vendor), places(driver));
    let differs = |one: &[Bits], other: &[Bits]| {
        let both = |bits: &Bits, of: &[Bits]| of.iter().any(|place| mask(*place) & mask(*bits) != 0);
        let is_row = one.iter().all(|bits| is_in(*bits, vendor, driver) && both(bits, other))
            && other.iter().all(|bits| is_in(*bits, driver, vendor) && both(bits, one));
        !one.iter().any(|bits| other.contains(bits)) && !is_row
    };
    let in_both = of_vendor.iter().filter_map(|(name, one)| Some((name, one, of_driver.get(name)?)));
    let moved = in_both.filter(|(_, one, other)| differs(one, other));
    moved.map(|(name, one, other)| ((*name).to_owned(), one[0], other[0])).collect()
}

/// Where each name stands.
fn places(register: &Register) -> BTreeMap<&str, Vec<Bits>> {
    let mut places = BTreeMap::<&str, Vec<Bits>>::new();
    for (bits, names) in &register.fields {
        names.iter().for_each(|name| places.entry(name).or_default().push(*bits));
    }
    places
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

    /// All bits are in use on both sides, so that only the names tell.
    #[test]
    fn two_fields_of_one_width_that_changed_places_are_told() {
        let exchanged =
            ["P.R.A: the vendor has bit 3, the driver bit 7", "P.R.B: the vendor has bit 7, the driver bit 3"];
        assert_eq!(differences(&[(3, 1, "A"), (7, 1, "B")], &[(3, 1, "B"), (7, 1, "A")]), exchanged);
        let (vendor, driver) = ([(0, 4, "A"), (8, 4, "B")], [(0, 4, "B"), (8, 4, "A")]);
        let exchanged = [
            "P.R.A: the vendor has bits 0:3, the driver bits 8:11",
            "P.R.B: the vendor has bits 8:11, the driver bits 0:3",
        ];
        assert_eq!(differences(&vendor, &driver), exchanged);
        // none of them counts as alike
        assert_eq!(compare("P", &register(&vendor), &register(&driver)).1, 0);
    }

    #[test]
    fn a_name_that_only_one_has_says_nothing() {
        assert!(differences(&[(3, 1, "A"), (7, 1, "B")], &[(3, 1, "X"), (7, 1, "B")]).is_empty());
        // three in a ring: the name that both have tells
        let ring = differences(&[(0, 1, "A"), (1, 1, "B"), (2, 1, "C")], &[(0, 1, "X"), (1, 1, "A"), (2, 1, "C")]);
        assert_eq!(ring, ["P.R.A: the vendor has bit 0, the driver bit 1"]);
    }

    /// The capture and the compare mode of a timer lie at one address, and so in one register with several names a field.
    #[test]
    fn a_name_may_stand_at_several_places() {
        assert!(differences(&[(0, 1, "A"), (4, 1, "A")], &[(0, 1, "A"), (4, 1, "B")]).is_empty());
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
        // a row may have the field's own name first
        assert!(differences(&[(0, 3, "A")], &[(0, 1, "A"), (1, 1, "B"), (2, 1, "C")]).is_empty());
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
