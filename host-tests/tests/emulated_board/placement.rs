//! The code that runs from another memory than the flash.

use std::path::Path;

use firmware_image::ccm_code::{self, CcmCode};
use firmware_image::elf::Elf;
use firmware_image::memory::Memory;
use glenoid::can::Opcode;
use glenoid::procedure::{Reason, StateName};
use host_tests::debugger::Debugger;
use host_tests::emulator::{Emulator, Options};
use libtest_mimic::Failed;

use crate::scene::Scene;

/// The emulator puts the image where a programmer would, into the flash: what lies in the other memory was copied by the
/// board. It calls it there, through the linker's veneers, and finds a centre with it.
pub fn the_ccm_code_is_copied_and_called(image: &Path) -> Result<(), Failed> {
    let elf = Elf::read(image)?;
    let ccm = CcmCode::read(&elf)?;
    assert_eq!(ccm.faults(Memory::EMULATED), []);
    let options = Options { debugger: true, ..Options::default() };
    let mut scene = Scene::on(Emulator::start(image, &options)?, 44)?;
    assert_eq!(scene.ask_when_still(Opcode::Start, 1)?.code, Reason::Fine);
    scene.capture(6)?;

    let mut debugger = Debugger::halt(scene.board.debugger_address().ok_or("the board serves no debugger")?)?;
    let there = debugger.read(u32::try_from(ccm.code.from)?, usize::try_from(ccm.bytes())?)?;
    let words: Vec<u32> = there.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
    assert_eq!(words, elf.words(ccm_code::SECTION)?);
    // every pass of the estimator comes by here
    let add = ccm.functions.iter().find(|function| function.name.ends_with("::add_placed"));
    let add = u32::try_from(add.ok_or("the passes of the estimator are not in the core-coupled memory")?.address)?;
    let mut told = Ok(());
    debugger.run_to(add, || told = scene.tell(Opcode::Identify))?;
    told?;
    debugger.resume()?;
    scene.wait_for_state(StateName::Verifying)
}
