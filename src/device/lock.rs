//! The lock of the parameters: open for whoever knows the key, which never goes over the bus.
//!
//! The device sends a challenge; the client answers with SipHash-2-4 of the challenge's four bytes (little-endian) under
//! the 128-bit key, of which the lowest 32 bits count. A challenge serves one attempt, and attempts are a second apart:
//! guessing 32 bits takes a lifetime. An all-zero key means that there is no lock; so it is until somebody sets one.

use core::hash::Hasher;
use siphasher::sip::SipHasher24;

/// Shortest time between two attempts, ms.
const ATTEMPT_MS: u32 = 1_000;
/// An open lock closes by itself after so long, ms.
const OPEN_MS: u32 = 600_000;

/// The lock.
#[derive(Debug, Clone)]
pub(super) struct Lock {
    key: [u32; 4],
    challenge: Option<u32>,
    /// Challenges so far: no two are alike.
    count: u32,
    opened_at_ms: Option<u32>,
    attempted_at_ms: Option<u32>,
}

impl Lock {
    /// A closed lock, or none if the key is all zero.
    pub const fn new(key: [u32; 4]) -> Self {
        Self { key, challenge: None, count: 0, opened_at_ms: None, attempted_at_ms: None }
    }

    /// May the guarded parameters be written?
    pub fn is_open(&self) -> bool {
        self.key == [0; 4] || self.opened_at_ms.is_some()
    }

    /// Time passes: an open lock closes by itself.
    pub fn tick(&mut self, now_ms: u32) {
        self.opened_at_ms = self.opened_at_ms.filter(|at_ms| now_ms.wrapping_sub(*at_ms) < OPEN_MS);
    }

    /// A number that the answer is to be formed from. It differs from boot to boot, and cannot be foreseen without the
    /// key.
    pub fn challenge(&mut self, now_ms: u32, boot: u32) -> u32 {
        self.count = self.count.wrapping_add(1);
        let challenge = self.hash(&[boot, now_ms, self.count]);
        self.challenge = Some(challenge);
        challenge
    }

    /// Tries to open. False when the answer is wrong, there is no challenge, or the last attempt was too short ago.
    pub fn open(&mut self, now_ms: u32, answer: u32) -> bool {
        let too_soon = self.attempted_at_ms.is_some_and(|at_ms| now_ms.wrapping_sub(at_ms) < ATTEMPT_MS);
        let Some(challenge) = self.challenge.take().filter(|_| !too_soon) else { return false };
        self.attempted_at_ms = Some(now_ms);
        let right = answer == self.hash(&[challenge]);
        if right {
            self.opened_at_ms = Some(now_ms);
        }
        right
    }

    /// Closes.
    pub fn close(&mut self) {
        self.opened_at_ms = None;
    }

    fn hash(&self, words: &[u32]) -> u32 {
        let [k0, k1, k2, k3] = self.key.map(u64::from);
        let mut hasher = SipHasher24::new_with_keys(k0 | k1 << 32, k2 | k3 << 32);
        for word in words {
            hasher.write(&word.to_le_bytes());
        }
        // the lowest 32 bits
        hasher.finish() as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: [u32; 4] = [0x0302_0100, 0x0706_0504, 0x0B0A_0908, 0x0F0E_0D0C];

    /// The vectors of the SipHash paper (Aumasson, Bernstein 2012, appendix A) use this key and the message 00 01 02 03.
    #[test]
    fn the_published_vector() {
        assert_eq!(Lock::new(KEY).hash(&[0x0302_0100]), 0xcf27_94e0_2771_87b7_u64 as u32);
    }

    #[test]
    fn only_the_answer_to_the_last_challenge_opens_and_only_once() {
        let mut lock = Lock::new(KEY);
        assert!(!lock.is_open() && !lock.open(0, 0));
        let first = lock.challenge(0, 1);
        let second = lock.challenge(0, 1);
        assert_ne!(first, second);
        let answer = lock.hash(&[first]);
        assert!(!lock.open(0, answer), "of an older challenge");
        let challenge = lock.challenge(10, 1);
        let answer = lock.hash(&[challenge]);
        assert!(!lock.open(999, answer), "too soon after an attempt");
        let challenge = lock.challenge(1_000, 1);
        let answer = lock.hash(&[challenge]);
        assert!(lock.open(1_000, answer) && lock.is_open());
        assert!(!lock.open(5_000, answer), "used up");
        lock.tick(600_999);
        assert!(lock.is_open());
        lock.tick(601_000);
        assert!(!lock.is_open());
    }

    #[test]
    fn without_a_key_there_is_no_lock() {
        assert!(Lock::new([0; 4]).is_open());
    }
}
