//! A set of the multiplexer's channels.

use crate::driver::pca9544a::Channel;

/// A set of channels, a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Channels(u8);

impl Channels {
    pub(super) const NONE: Self = Self(0);

    pub(super) const fn contains(self, channel: Channel) -> bool {
        self.0 & 1 << channel.number() != 0
    }

    pub(super) fn insert(&mut self, channel: Channel) {
        self.0 |= 1 << channel.number();
    }

    pub(super) fn remove(&mut self, channel: Channel) {
        self.0 &= !(1 << channel.number());
    }

    /// Takes the lowest channel out.
    pub(super) fn pop(&mut self) -> Option<Channel> {
        let lowest = Channel::ALL
            .into_iter()
            .find(|channel| self.contains(*channel))?;
        self.remove(lowest);
        Some(lowest)
    }
}
