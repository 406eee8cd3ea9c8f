//! A set of the multiplexer's channels.

use pca9544a::Channel;

/// A set of channels, one bit each.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_leave_the_set_by_their_number_and_each_once() {
        let mut some = Channels::NONE;
        for channel in [Channel::Three, Channel::Zero, Channel::Two, Channel::Three] {
            some.insert(channel);
        }
        assert!(some.contains(Channel::Two) && !some.contains(Channel::One));
        some.remove(Channel::Two);
        some.remove(Channel::Two);
        let left: Vec<Channel> = core::iter::from_fn(|| some.pop()).collect();
        assert_eq!(left, [Channel::Zero, Channel::Three]);
        assert_eq!(some, Channels::NONE);
    }
}
