//! How far the end of a map has come.

/// How far [`Mapper::finish`](super::Mapper::finish) has come, stage by stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FinishProgress {
    /// What is counted, as in `places searched`.
    pub stage: &'static str,
    /// How much of it is done, never less than before in the same stage.
    pub done: usize,
    /// How much there is to do, at most.
    pub of: usize,
}
