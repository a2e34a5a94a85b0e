//! Test vectors of the CAN vocabulary, for the check against cantools (`clients/check_vocabulary.py`).
//!
//! `vocabulary encode COUNT` prints random messages: name, identifier, data bytes, fields.
//! `vocabulary decode` reads lines of identifier and data bytes (hexadecimal), prints name and fields of each.

use glenoid::can::{BaseId, Frame, Message};
use host_tests::vocabulary::{KINDS, fields, random_message};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::error::Error;
use std::io::BufRead;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let outcome = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["encode", count] => encode(count),
        ["decode"] => decode(),
        _ => Err("usage: vocabulary encode COUNT | vocabulary decode".into()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("vocabulary: {error}");
            ExitCode::FAILURE
        }
    }
}

fn encode(count: &str) -> Result<(), Box<dyn Error>> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for number in 0..count.parse::<u32>()? {
        let message = random_message((number % u32::from(KINDS)) as u8, &mut random);
        let frame = message.pack(BaseId::DEFAULT)?;
        let data: String = frame.data().iter().map(|byte| format!("{byte:02x}")).collect();
        println!("{:03x} {data} {}", frame.raw_id(), named(&message));
    }
    Ok(())
}

fn decode() -> Result<(), Box<dyn Error>> {
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let (id, data) = line.split_once(' ').ok_or("a line is an identifier and data bytes")?;
        let data = (0..data.len() / 2)
            .map(|k| data.get(2 * k..2 * k + 2).map(|pair| u8::from_str_radix(pair, 16)))
            .collect::<Option<Result<Vec<u8>, _>>>()
            .ok_or("data bytes are pairs of hexadecimal digits")??;
        let frame = Frame::new(u16::from_str_radix(id, 16)?, &data)?;
        println!("{}", named(&Message::unpack(&frame, BaseId::DEFAULT)?));
    }
    Ok(())
}

fn named(message: &Message) -> String {
    let (name, fields) = fields(message);
    let fields: Vec<String> = fields.iter().map(|(field, value)| format!("{field}={value}")).collect();
    format!("{name} {}", fields.join(" "))
}
