//! Both descriptions are read rightly: against places that the reference manual states.

use registers::{Bits, Block, driver, vendor};

fn field(block: &Block, register: &str, name: &str) -> Option<Bits> {
    let register = block.values().find(|found| found.name == register)?;
    register.fields.iter().find(|(_, names)| names.contains(name)).map(|(bits, _)| *bits)
}

/// RM0440: RCC_CR, FLASH_ACR, FDCAN_NBTP, GPIOx_MODER.
const STATED: [(&str, &str, &str, &str, u32, u32); 5] = [
    ("RCC", "rcc", "CR", "PLLRDY", 25, 1),
    ("FLASH", "flash", "ACR", "LATENCY", 0, 4),
    ("FDCAN1", "fdcan", "NBTP", "NBRP", 16, 9),
    ("FDCAN1", "fdcan", "NBTP", "NSJW", 25, 7),
    ("GPIOB", "gpiob", "MODER", "MODER6", 12, 2),
];

#[test]
fn both_have_the_fields_that_the_manual_states() {
    let folder = vendor::folder().unwrap();
    for (peripheral, block, register, name, from, width) in STATED {
        let by_vendor = vendor::block(&folder, block).unwrap();
        assert_eq!(field(&by_vendor, register, name), Some(Bits { from, width }), "vendor: {register}.{name}");
        let by_driver = driver::block(peripheral).unwrap();
        assert_eq!(field(&by_driver, register, name), Some(Bits { from, width }), "driver: {register}.{name}");
    }
}

#[test]
fn the_vendor_has_the_reset_values_that_the_manual_states() {
    let folder = vendor::folder().unwrap();
    let reset = |block: &str, name: &str| {
        let block = vendor::block(&folder, block).unwrap();
        block.values().find(|register| register.name == name).and_then(|register| register.reset)
    };
    // RM0440: PWR_CR5, FDCAN_NBTP, GPIOA_MODER
    assert_eq!(reset("pwr", "CR5"), Some(0x0000_0100));
    assert_eq!(reset("fdcan", "NBTP"), Some(0x0600_0A03));
    assert_eq!(reset("gpioa", "MODER"), Some(0xABFF_FFFF));
}

/// The one that this comparison exists for.
#[test]
fn the_misplaced_boost_bit_is_found() {
    let folder = vendor::folder().unwrap();
    let (by_vendor, by_driver) = (vendor::block(&folder, "pwr").unwrap(), driver::block("PWR").unwrap());
    let (differences, _) = registers::compare::compare("PWR", &by_vendor, &by_driver);
    let said: Vec<String> = differences.iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|line| line == "PWR.CR5.R1MODE: the vendor has bit 8, the driver bit 0"), "{said:?}");
}
