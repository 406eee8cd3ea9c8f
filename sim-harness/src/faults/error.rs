//! The error of a text that is not a list of faults.

/// An invalid fault: the word, its position and the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{word}\" (character {place}) {problem}")]
pub struct FaultError {
    word: String,
    place: usize,
    problem: String,
}

impl FaultError {
    pub(super) fn new(word: &str, place: usize, problem: impl Into<String>) -> Self {
        Self {
            word: word.to_owned(),
            place,
            problem: problem.into(),
        }
    }

    /// The piece of the text that is wrong.
    #[must_use]
    pub fn word(&self) -> &str {
        &self.word
    }

    /// Where it begins: the number of its first character, counted from 1.
    #[must_use]
    pub const fn place(&self) -> usize {
        self.place
    }
}
