//! The address and the bits of the control register.

/// Address on the bus, 7 bits: 0x70 to 0x77, by the pins A2, A1 and A0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Address(u8);

impl Address {
    /// Address of a part whose pins are high (`true`) or low.
    #[must_use]
    pub const fn from_pins(a2: bool, a1: bool, a0: bool) -> Self {
        Self(0x70 | (a2 as u8) << 2 | (a1 as u8) << 1 | a0 as u8)
    }

    /// The seven bits.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }
}

/// One of the four channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(missing_docs, reason = "each name is its number")]
pub enum Channel {
    Zero,
    One,
    Two,
    Three,
}

impl Channel {
    /// All channels, ascending.
    pub const ALL: [Self; 4] = [Self::Zero, Self::One, Self::Two, Self::Three];

    /// Number of the channel, 0 to 3.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }
}

/// What is connected to the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Selection {
    /// No channel; so after a reset of the part.
    None,
    /// This channel.
    Channel(Channel),
    /// Any of these: nothing was read back yet, or something failed since.
    Unknown,
}

impl Selection {
    /// Value of the control register that selects this; `Unknown` selects no channel.
    #[must_use]
    pub const fn bits(self) -> u8 {
        match self {
            Self::Channel(channel) => ENABLE | channel.number(),
            Self::None | Self::Unknown => 0,
        }
    }
}

/// Enable bit, without which the channel's number has no meaning.
const ENABLE: u8 = 0x04;

/// Interrupt inputs that are low, by channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Interrupts(u8);

impl Interrupts {
    /// Whether the input of this channel is low.
    #[must_use]
    pub const fn contains(self, channel: Channel) -> bool {
        self.0 & 1 << channel.number() != 0
    }

    /// Whether none is low.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// Decodes the control register's selection; [`Selection::Unknown`] unless it is one byte.
#[must_use]
pub const fn selection(answer: &[u8]) -> Selection {
    let [control] = *answer else {
        return Selection::Unknown;
    };
    match control & 0x07 {
        0x04 => Selection::Channel(Channel::Zero),
        0x05 => Selection::Channel(Channel::One),
        0x06 => Selection::Channel(Channel::Two),
        0x07 => Selection::Channel(Channel::Three),
        _ => Selection::None,
    }
}

/// Decodes the control register's interrupt bits; none unless it is one byte.
#[must_use]
pub const fn interrupts(answer: &[u8]) -> Interrupts {
    match *answer {
        [control] => Interrupts(control >> 4),
        _ => Interrupts(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_make_the_address() {
        assert_eq!(Address::from_pins(false, false, false).bits(), 0x70);
        assert_eq!(Address::from_pins(true, false, false).bits(), 0x74);
        assert_eq!(Address::from_pins(false, true, true).bits(), 0x73);
        assert_eq!(Address::from_pins(true, true, true).bits(), 0x77);
    }

    #[test]
    fn a_channel_is_a_number_and_not_a_bit() {
        for (channel, control) in Channel::ALL.into_iter().zip([0x04, 0x05, 0x06, 0x07]) {
            assert_eq!(Selection::Channel(channel).bits(), control);
            assert_eq!(selection(&[control | 0xf0]), Selection::Channel(channel));
        }
    }

    #[test]
    fn every_register_value_has_one_meaning() {
        for control in 0..=u8::MAX {
            let expected = match (control & 4, control & 3) {
                (0, _) => Selection::None,
                (_, number) => Selection::Channel(Channel::ALL[usize::from(number)]),
            };
            assert_eq!(selection(&[control]), expected, "{control:#04x}");
        }
        assert_eq!(selection(&[]), Selection::Unknown);
        assert_eq!(selection(&[4, 4]), Selection::Unknown);
    }

    #[test]
    fn interrupt_bits_belong_to_their_channels() {
        for (index, channel) in Channel::ALL.into_iter().enumerate() {
            let low = interrupts(&[0x10 << index | 0x0f]);
            for other in Channel::ALL {
                assert_eq!(low.contains(other), other == channel);
            }
        }
        assert!(interrupts(&[0x0f]).is_empty());
        assert!(interrupts(&[0xf0, 0xf0]).is_empty());
    }
}
