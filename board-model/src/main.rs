//! Runs the real image.
use board_model::chip::Chip;
use board_model::image::Image;
use board_model::machine::Machine;
use board_model::peripheral::flash::Cells;
use board_model::time::PS_A_MS;
use std::path::Path;

fn main() -> std::io::Result<()> {
    let image = Image::read(Path::new("../target/thumbv7em-none-eabihf/firmware/nucleo-g474re"))?;
    let mut machine = Machine::power_on(&image, Chip::new(Cells::new(1), 1), 1);
    for ms in 0..20 {
        machine.run_until((ms + 1) * PS_A_MS);
        let state = machine.state();
        println!("{ms} ms: {} instructions, resets {:?}, sent {}, pc {}", state.instructions, machine.resets, state.chip.can.bus.sent.len(), image.name_of(machine.get(unicorn_engine::RegisterARM::PC)));
    }
    for breach in machine.chip().breaches.all() {
        println!("{breach} {}", image.name_of(breach.pc));
    }
    Ok(())
}
