//! A few words that the main loop publishes and an interrupt reads: never half of one set and half of another, without a
//! lock and without masking anything.
//!
//! There are two copies. The writer fills the one that is not in use and then says that it is; a reader takes the one in
//! use and looks afterwards whether it still is. An interrupt that has stopped the writer always succeeds at once. A reader
//! that the writer can stop tries again, which it has to once in a while.

use core::sync::atomic::{AtomicU32, Ordering, fence};

/// The last published words; one writer, any number of readers.
#[derive(Debug)]
pub struct Snapshot<const WORDS: usize> {
    copies: [[AtomicU32; WORDS]; 2],
    /// How often something was published, modulo 2³²; the lowest bit tells the copy in use.
    published: AtomicU32,
}

impl<const WORDS: usize> Snapshot<WORDS> {
    /// Zeros: nothing was published.
    pub const fn new() -> Self {
        Self { copies: [const { [const { AtomicU32::new(0) }; WORDS] }; 2], published: AtomicU32::new(0) }
    }

    /// Publishes the next words. Call it from one place only.
    pub fn publish(&self, words: &[u32; WORDS]) {
        let next = self.published.load(Ordering::Relaxed).wrapping_add(1);
        // whoever sees a word from here on sees that the copy before it was published, too
        fence(Ordering::Release);
        for (place, word) in self.copy(next).iter().zip(words) {
            place.store(*word, Ordering::Relaxed);
        }
        self.published.store(next, Ordering::Release);
    }

    /// The words published last. None when others were published meanwhile: never in an interrupt that stops the writer.
    pub fn read(&self) -> Option<[u32; WORDS]> {
        let published = self.published.load(Ordering::Acquire);
        let mut words = [0; WORDS];
        for (word, place) in words.iter_mut().zip(self.copy(published)) {
            *word = place.load(Ordering::Relaxed);
        }
        fence(Ordering::Acquire);
        (self.published.load(Ordering::Relaxed) == published).then_some(words)
    }

    fn copy(&self, published: u32) -> &[AtomicU32; WORDS] {
        let [even, odd] = &self.copies;
        if published & 1 == 0 { even } else { odd }
    }
}

impl<const WORDS: usize> Default for Snapshot<WORDS> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::thread;

    #[test]
    fn what_was_published_last_is_read() {
        let snapshot = Snapshot::<3>::new();
        assert_eq!(snapshot.read(), Some([0; 3]));
        for number in 1..5 {
            snapshot.publish(&[number; 3]);
            assert_eq!(snapshot.read(), Some([number; 3]));
        }
    }

    /// A writer that publishes as fast as it can, and two readers that it stops anywhere.
    #[test]
    fn no_reader_sees_half_of_a_set() {
        static SNAPSHOT: Snapshot<16> = Snapshot::new();
        const LAST: u32 = 300_000;
        let read = || {
            let (mut seen, mut newest) = (0_u32, 0);
            while newest != LAST {
                let Some(words) = SNAPSHOT.read() else { continue };
                assert!(words.iter().all(|word| *word == words[0]), "{words:?}");
                assert!(words[0] >= newest, "{} after {newest}", words[0]);
                seen += u32::from(words[0] != newest);
                newest = words[0];
            }
            seen
        };
        thread::scope(|scope| {
            let readers = [scope.spawn(read), scope.spawn(read)];
            for number in 1..=LAST {
                SNAPSHOT.publish(&[number; 16]);
            }
            for reader in readers {
                assert!(reader.join().unwrap() > 0);
            }
        });
    }
}
