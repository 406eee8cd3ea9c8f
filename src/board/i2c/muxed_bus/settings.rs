//! How the parts are used on the AMiRo.

use pca9544a::Address;
use vcnl4020::{Ambient, AmbientRate, Configuration, LedCurrent, ProximityRate};

/// Address of the multiplexer on either bus: all three pins are high.
pub const MUX_ADDRESS: Address = Address::from_pins(true, true, true);

/// Settings of each sensor, as AMiRo-OS leaves them: 125 proximity results per second at
/// 200 mA, 2 ambient light results per second of 32 conversions, no automatic offset.
///
/// AMiRo-OS means to have the automatic offset and sets a bit of the rate instead.
pub const SENSOR_CONFIGURATION: Configuration = Configuration {
    rate: ProximityRate::Hz125,
    led: LedCurrent::MAX,
    ambient: Some(Ambient {
        continuous: false,
        rate: AmbientRate::Hz2,
        auto_offset: false,
        conversions_log2: 5,
    }),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_have_the_bytes_that_amiro_os_writes() {
        assert_eq!(MUX_ADDRESS.bits(), 0x77);
        let configure = vcnl4020::transactions::write_configuration(&SENSOR_CONFIGURATION);
        assert_eq!(configure.write_bytes(), [0x82, 0x06, 0x14, 0x15]);
        assert_eq!(SENSOR_CONFIGURATION.command().0, 0x07);
    }
}
