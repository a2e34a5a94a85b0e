//! Peripherals whose registers do nothing else than hold what was written: PWR, SYSCFG, DBGMCU.

use super::Env;
use crate::register_file::RegisterFile;

/// Such a peripheral.
#[derive(Debug, Clone)]
pub struct Plain {
    /// Its registers.
    pub file: RegisterFile,
}

impl Plain {
    /// As a reset leaves it.
    pub fn new(name: &'static str) -> Self {
        Self { file: RegisterFile::new(name) }
    }

    /// Reads a register.
    pub fn read(&self, offset: u32) -> u32 {
        self.file.at(offset)
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, env: &mut Env) {
        self.file.write(offset, value, env.breaches);
    }
}
