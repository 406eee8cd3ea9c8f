//! A set of the multiplexer's channels.

use pca9544a::Channel;

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

#[cfg(test)]
mod tests {
    use super::*;

    fn set(channels: &[Channel]) -> Channels {
        let mut set = Channels::NONE;
        channels.iter().for_each(|channel| set.insert(*channel));
        set
    }

    #[test]
    fn a_channel_is_in_the_set_from_its_first_insertion_to_its_first_removal() {
        for channel in Channel::ALL {
            let mut one = set(&[channel, channel]);
            for other in Channel::ALL {
                assert_eq!(one.contains(other), other == channel, "{other:?}");
            }
            one.remove(channel);
            assert_eq!(one, Channels::NONE);
            one.remove(channel);
            assert_eq!(one, Channels::NONE);
        }
    }

    #[test]
    fn channels_leave_by_their_number_and_each_once() {
        let mut some = set(&[Channel::Three, Channel::Zero, Channel::Two]);
        let left: Vec<Channel> = core::iter::from_fn(|| some.pop()).collect();
        assert_eq!(left, [Channel::Zero, Channel::Two, Channel::Three]);
        assert_eq!(some, Channels::NONE);
    }
}
