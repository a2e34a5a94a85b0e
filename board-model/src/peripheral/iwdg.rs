//! The independent watchdog (RM0440, "Independent watchdog").

use super::Env;
use crate::breach::Rule;
use crate::register_file::RegisterFile;
use crate::time::PS_A_SECOND;

/// Its own oscillator, Hz.
const LSI_HZ: u64 = 32_000;
/// A new value takes so many periods to get there.
const UPDATE_PERIODS: u64 = 5;

/// The peripheral.
#[derive(Debug, Clone)]
pub struct Iwdg {
    /// Its registers.
    pub file: RegisterFile,
    unlocked: bool,
    /// When it last was fed, once it runs.
    fed_ps: Option<u64>,
    updated_ps: u64,
}

impl Iwdg {
    /// As a reset leaves it.
    pub fn new() -> Self {
        Self { file: RegisterFile::new("IWDG"), unlocked: false, fed_ps: None, updated_ps: 0 }
    }

    /// Reads a register.
    pub fn read(&mut self, offset: u32, env: &Env) -> u32 {
        let busy = u32::from(env.now_ps < self.updated_ps);
        self.file.put("SR", "PVU", busy);
        self.file.put("SR", "RVU", busy);
        self.file.at(offset)
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, env: &mut Env) {
        match (self.file.name_at(offset), value) {
            (Some("KR"), 0x5555) => self.unlocked = true,
            (Some("KR"), 0xAAAA) => {
                self.unlocked = false;
                self.fed_ps = self.fed_ps.map(|_| env.now_ps);
            }
            (Some("KR"), 0xCCCC) => {
                self.unlocked = false;
                self.fed_ps.get_or_insert(env.now_ps);
            }
            (Some("KR"), key) => env.breaches.add(Rule::WrongKey, format!("IWDG.KR: {key:#x}")),
            (Some("PR" | "RLR" | "WINR"), _) if self.unlocked => {
                self.file.write(offset, value, env.breaches);
                self.updated_ps = env.now_ps + UPDATE_PERIODS * PS_A_SECOND / LSI_HZ;
            }
            (name, _) => env.breaches.add(Rule::Protected, format!("IWDG.{}", name.unwrap_or("?"))),
        }
    }

    /// How long it goes without food, ps.
    pub fn patience_ps(&self) -> u64 {
        let prescaler = 4 << self.file.get("PR", "PR").min(6);
        u64::from(self.file.get("RLR", "RL") + 1) * prescaler * PS_A_SECOND / LSI_HZ
    }

    /// When it bites, once it runs.
    pub fn bites_ps(&self) -> Option<u64> {
        self.fed_ps.map(|at| at + self.patience_ps())
    }
}

impl Default for Iwdg {
    fn default() -> Self {
        Self::new()
    }
}
