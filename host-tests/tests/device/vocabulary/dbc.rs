//! Reads `glenoid.dbc` and decodes by it: an oracle that knows nothing of the library.

use std::collections::BTreeMap;

pub struct Signal {
    pub name: String,
    start: u32,
    bits: u32,
    signed: bool,
    /// Motorola byte order: the start is the highest bit, and the bits go down and on into the next byte.
    big_endian: bool,
    /// An IEEE single.
    single: bool,
    /// The number of the piece or parameter to which it belongs; None when it is always there.
    pub multiplexed: Option<u32>,
    factor: f64,
    offset: f64,
}

pub struct Definition {
    pub name: String,
    pub length: usize,
    pub sender: String,
    pub signals: Vec<Signal>,
}

pub struct Database {
    /// By identifier.
    pub messages: BTreeMap<u16, Definition>,
    /// By identifier and signal: number to name.
    pub values: BTreeMap<(u16, String), BTreeMap<u8, String>>,
}

impl Database {
    pub fn load() -> Self {
        let mut database = Self { messages: BTreeMap::new(), values: BTreeMap::new() };
        let mut current = 0;
        for line in include_str!("../../../../glenoid.dbc").lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                ["BO_", id, name, length, sender] => {
                    current = id.parse().unwrap();
                    let definition = Definition {
                        name: name.trim_end_matches(':').to_owned(),
                        length: length.parse().unwrap(),
                        sender: sender.to_owned(),
                        signals: Vec::new(),
                    };
                    assert!(database.messages.insert(current, definition).is_none(), "{id} twice");
                }
                ["SG_", name, ":", position, scale, ..] => {
                    database.messages.get_mut(&current).unwrap().signals.push(signal(name, None, position, scale));
                }
                ["SG_", name, multiplexed, ":", position, scale, ..] => {
                    let signals = &mut database.messages.get_mut(&current).unwrap().signals;
                    signals.push(signal(name, multiplexed.strip_prefix('m'), position, scale));
                }
                ["SIG_VALTYPE_", id, name, ":", "1;"] => {
                    let definition = database.messages.get_mut(&id.parse().unwrap()).unwrap();
                    definition.signals.iter_mut().find(|signal| signal.name == name).unwrap().single = true;
                }
                ["VAL_", id, signal, ..] => {
                    let pairs = line.split('"').collect::<Vec<_>>();
                    let number = |text: &str| text.split_whitespace().last().unwrap().parse().unwrap();
                    let table = pairs.chunks_exact(2).map(|pair| (number(pair[0]), pair[1].to_owned())).collect();
                    database.values.insert((id.parse().unwrap(), signal.to_owned()), table);
                }
                _ => {}
            }
        }
        database
    }
}

/// `0|16@1+` and `(1,0)`: bits from the start on, little-endian, sign; factor and offset.
fn signal(name: &str, multiplexed: Option<&str>, position: &str, scale: &str) -> Signal {
    let (start, rest) = position.split_once('|').unwrap();
    let (bits, order_and_sign) = rest.split_once('@').unwrap();
    let (factor, offset) = scale.trim_matches(['(', ')']).split_once(',').unwrap();
    Signal {
        name: name.to_owned(),
        start: start.parse().unwrap(),
        bits: bits.parse().unwrap(),
        signed: order_and_sign.ends_with('-'),
        big_endian: order_and_sign.starts_with('0'),
        single: false,
        multiplexed: multiplexed.map(|number| number.parse().unwrap()),
        factor: factor.parse().unwrap(),
        offset: offset.parse().unwrap(),
    }
}

impl Signal {
    /// The positions of the signal's bits in the frame.
    pub fn positions(&self) -> std::ops::Range<u32> {
        self.start..self.start + self.bits
    }

    /// One step of the physical value.
    pub fn step(&self) -> f64 {
        self.factor
    }

    /// The physical value in the data bytes. Bit by bit, on purpose not like the code under test.
    pub fn decode(&self, data: &[u8]) -> f64 {
        if self.big_endian {
            // sawtooth numbering of DBC: bit 7 of a byte comes first
            let first = self.start / 8 * 8 + 7 - self.start % 8;
            let bit = |position: u32| u64::from(data[position as usize / 8] >> (7 - position % 8) & 1);
            return (first..first + self.bits).fold(0, |raw, position| raw << 1 | bit(position)) as f64;
        }
        let mut raw = 0i64;
        for (weight, position) in self.positions().enumerate() {
            let bit = i64::from(data[position as usize / 8] >> (position % 8) & 1);
            let is_sign = self.signed && weight as u32 == self.bits - 1;
            raw += if is_sign { -bit << weight } else { bit << weight };
        }
        if self.single {
            return f64::from(f32::from_bits(raw as u32));
        }
        raw as f64 * self.factor + self.offset
    }
}
