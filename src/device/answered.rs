//! What was answered lately: a command with a nonce is obeyed once within a second, whatever comes between.

use heapless::Deque;

/// Within this time, ms, the same request (same nonce, not 0) is a repetition: its answer was lost, not its effect.
const WINDOW_MS: u32 = 1_000;

/// Requests of the last second with their answers.
#[derive(Debug, Clone)]
pub(super) struct Answered<Q, A, const N: usize> {
    entries: Deque<(Q, A, u32), N>,
}

impl<Q: PartialEq, A: Copy, const N: usize> Answered<Q, A, N> {
    /// Nothing was answered yet.
    pub const fn new() -> Self {
        Self { entries: Deque::new() }
    }

    /// The answer that this request was given within the last second, if it was.
    pub fn find(&mut self, now_ms: u32, request: &Q) -> Option<A> {
        while self.entries.front().is_some_and(|(_, _, at_ms)| now_ms.wrapping_sub(*at_ms) >= WINDOW_MS) {
            self.entries.pop_front();
        }
        self.entries.iter().find(|(asked, _, _)| asked == request).map(|(_, answer, _)| *answer)
    }

    /// There is room for so many more: to obey another request without would be to forget one that may still be repeated.
    pub fn has_room_for(&self, more: usize) -> bool {
        self.entries.len() + more <= N
    }

    /// Notes an answer; a full list keeps what it has.
    pub fn note(&mut self, now_ms: u32, request: Q, answer: A) {
        let _ = self.entries.push_back((request, answer, now_ms));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_remembered_for_a_second_whatever_comes_between() {
        let mut answered = Answered::<u8, char, 4>::new();
        let begin_ms = u32::MAX - 10;
        answered.note(begin_ms, 1, 'a');
        answered.note(begin_ms.wrapping_add(5), 2, 'b');
        assert_eq!(answered.find(begin_ms.wrapping_add(999), &1), Some('a'));
        assert_eq!(answered.find(begin_ms.wrapping_add(1_000), &1), None);
        assert_eq!(answered.find(begin_ms.wrapping_add(1_000), &2), Some('b'));
    }

    #[test]
    fn a_full_list_forgets_nothing() {
        let mut answered = Answered::<u8, u8, 2>::new();
        (0..3).for_each(|k| answered.note(0, k, k));
        assert!(!answered.has_room_for(1));
        assert_eq!((answered.find(1, &0), answered.find(1, &1), answered.find(1, &2)), (Some(0), Some(1), None));
    }
}
