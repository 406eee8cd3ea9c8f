//! Identifiers of frames.

/// A module of the robot, by the number in its identifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AmiroModule {
    /// The base board with the wheels.
    DiWheelDrive = 1,
    /// The board that this firmware is for.
    PowerManagement = 2,
    /// The board with the lights.
    LightRing = 3,
    /// The computer on top.
    Cognition = 4,
}

impl AmiroModule {
    /// Every module, by rising number.
    pub const ALL: [Self; 4] = [
        Self::DiWheelDrive,
        Self::PowerManagement,
        Self::LightRing,
        Self::Cognition,
    ];
}

/// An identifier of 11 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StandardId(u16);

impl StandardId {
    /// TARGET_SPEED from this board, 0x082.
    pub const OWN_TARGET_SPEED: Self = Self::of(0x10, AmiroModule::PowerManagement);
    /// TARGET_SPEED from Cognition, 0x084.
    pub const TARGET_SPEED: Self = Self::of(0x10, AmiroModule::Cognition);
    /// ACTUAL_SPEED, 0x101.
    pub const ACTUAL_SPEED: Self = Self::of(0x20, AmiroModule::DiWheelDrive);
    /// ODOMETRY, 0x281.
    pub const ODOMETRY: Self = Self::of(0x50, AmiroModule::DiWheelDrive);
    /// CALIBRATE_PROXIMITY_RING, 0x414.
    pub const CALIBRATE_RING: Self = Self::of(0x82, AmiroModule::Cognition);

    /// BROADCAST_SHUTDOWN from a module, 0x401 to 0x404.
    #[must_use]
    pub const fn shutdown(from: AmiroModule) -> Self {
        Self::of(0x80, from)
    }

    /// The identifier of a device's message from a module: `device << 3 | module`.
    #[must_use]
    pub const fn of(device: u8, from: AmiroModule) -> Self {
        Self((device as u16) << 3 | from as u16)
    }

    /// The identifier of the given bits; those above the lowest 11 are cut off.
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits & 0x7ff)
    }

    /// The 11 bits.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }
}

/// An identifier of either length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CanIdentifier {
    /// 11 bits: every message of the AMiRo.
    Standard(StandardId),
    /// 29 bits: none of them.
    Extended(u32),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_those_of_the_robots() {
        for (identifier, bits) in [
            (StandardId::OWN_TARGET_SPEED, 0x082),
            (StandardId::TARGET_SPEED, 0x084),
            (StandardId::ACTUAL_SPEED, 0x101),
            (StandardId::ODOMETRY, 0x281),
            (StandardId::CALIBRATE_RING, 0x414),
            (StandardId::shutdown(AmiroModule::PowerManagement), 0x402),
            (StandardId::shutdown(AmiroModule::Cognition), 0x404),
            (StandardId::of(0x30, AmiroModule::PowerManagement), 0x182),
            (StandardId::of(0x37, AmiroModule::PowerManagement), 0x1ba),
        ] {
            assert_eq!(identifier.bits(), bits);
        }
    }

    #[test]
    fn no_identifier_has_more_than_eleven_bits() {
        assert_eq!(StandardId::of(0xff, AmiroModule::Cognition).bits(), 0x7fc);
        assert_eq!(StandardId::from_bits(0xffff).bits(), 0x7ff);
    }
}
