//! When a VCNL4020 raises its interrupt line.

/// Of the interrupt status register.
const ABOVE: u8 = 0x01;
const BELOW: u8 = 0x02;
const AMBIENT_READY: u8 = 0x04;
const PROXIMITY_READY: u8 = 0x08;

/// A quantity that the sensor measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// Ambient light.
    Ambient,
    /// Reflected light of the LED.
    Proximity,
}

/// The interrupt registers and the counts of exceeding values in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Thresholds {
    /// Register 0x89: 7..5 log2 of the count, 3 and 2 on a result, 1 on a threshold,
    /// 0 the quantity that is compared.
    pub(super) control: u8,
    /// Registers 0x8A and 0x8B.
    pub(super) low: u16,
    /// Registers 0x8C and 0x8D.
    pub(super) high: u16,
    /// Register 0x8E.
    pub(super) status: u8,
    below: u16,
    above: u16,
}

impl Thresholds {
    /// Compares a result with the thresholds.
    pub(super) fn judge(&mut self, quantity: Quantity, value: u16) {
        let (ready, compared) = match quantity {
            Quantity::Ambient => (AMBIENT_READY, self.control & 0x01 != 0),
            Quantity::Proximity => (PROXIMITY_READY, self.control & 0x01 == 0),
        };
        // The bits that enable an interrupt are those that report it.
        self.status |= self.control & ready;
        if self.control & 0x02 == 0 || !compared {
            return;
        }
        self.below = in_a_row(self.below, value < self.low);
        self.above = in_a_row(self.above, value > self.high);
        let needed = 1 << (self.control >> 5);
        if self.below >= needed {
            self.status |= BELOW;
        }
        if self.above >= needed {
            self.status |= ABOVE;
        }
    }
}

fn in_a_row(before: u16, exceeds: bool) -> u16 {
    if exceeds { before.saturating_add(1) } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_threshold_must_be_exceeded_as_often_in_a_row_as_asked() {
        // Four in a row of proximity, between 100 and 200.
        let mut thresholds = Thresholds {
            control: 0x42,
            low: 100,
            high: 200,
            ..Thresholds::default()
        };
        for value in [201, 201, 201, 200, 201, 201, 201] {
            thresholds.judge(Quantity::Proximity, value);
            thresholds.judge(Quantity::Ambient, 60_000);
        }
        assert_eq!(thresholds.status, 0);
        thresholds.judge(Quantity::Proximity, 201);
        assert_eq!(thresholds.status, ABOVE);
        for _ in 0..4 {
            thresholds.judge(Quantity::Proximity, 99);
        }
        assert_eq!(thresholds.status, ABOVE | BELOW, "status bits stay");
    }

    #[test]
    fn results_raise_the_line_only_if_asked_for() {
        let mut thresholds = Thresholds::default();
        thresholds.judge(Quantity::Proximity, 1);
        assert_eq!(thresholds.status, 0);
        thresholds.control = PROXIMITY_READY;
        thresholds.judge(Quantity::Ambient, 1);
        assert_eq!(thresholds.status, 0);
        thresholds.judge(Quantity::Proximity, 1);
        assert_eq!(thresholds.status, PROXIMITY_READY);
    }
}
