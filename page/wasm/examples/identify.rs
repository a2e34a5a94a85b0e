//! The page's identification on this machine instead of in a browser: lengths on standard input (six a line, mm), JSON on
//! standard output. The page's tests hold WebAssembly against it.

use glenoid::procedure::ModuleRig;
use std::io::Read;

fn main() {
    let mut text = String::new();
    if std::io::stdin().read_to_string(&mut text).is_ok() {
        let bytes: Vec<u8> = text
            .split_whitespace()
            .filter_map(|number| number.parse::<f32>().ok())
            .flat_map(f32::to_le_bytes)
            .collect();
        match page_wasm::parameters::rig_of(&[]) {
            Ok(ModuleRig::Ball(rig)) => println!("{}", page_wasm::mathematics::identify(&rig, &bytes)),
            Ok(ModuleRig::Hinge(_)) => eprintln!("identify: the defaults are a hinge's"),
            Err(complaint) => eprintln!("identify: {complaint}"),
        }
    }
}
