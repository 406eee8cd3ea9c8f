//! What breaks during a drive.

use core::ops::Range;

/// What can break.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    /// A sensor's plug is pulled.
    Unplugged {
        /// Which one.
        sensor: usize,
    },
    /// Something covers a sensor: its register is full.
    Saturated {
        /// Which one.
        sensor: usize,
    },
    /// A sensor measures the same again and again.
    Stuck {
        /// Which one.
        sensor: usize,
    },
    /// A sensor's measurements are 16 random bits each.
    Garbage {
        /// Which one.
        sensor: usize,
    },
    /// A lamp shines into a sensor: ambient light, and what of it is taken for the
    /// sensor's own.
    Lit {
        /// Which one.
        sensor: usize,
        /// What its ambient measurements give, counts.
        ambient: u16,
        /// What it adds to the proximity measurements, counts.
        added: u16,
    },
    /// No frame comes over the robot's bus.
    NoFrames,
    /// The odometry takes itself to be elsewhere, by so many metres.
    Elsewhere {
        /// Along x and y of the world.
        by_m: [f32; 2],
    },
}

/// What breaks when: times of the drive, microseconds from its start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotFaults {
    all: Vec<(Range<u64>, Trouble)>,
}

impl RobotFaults {
    /// Nothing breaks.
    #[must_use]
    pub const fn none() -> Self {
        Self { all: Vec::new() }
    }

    /// Something breaks from a time on, for good.
    #[must_use]
    pub fn from(self, from_us: u64, trouble: Trouble) -> Self {
        self.during(from_us..u64::MAX, trouble)
    }

    /// Something is broken for a time.
    #[must_use]
    pub fn during(mut self, when_us: Range<u64>, trouble: Trouble) -> Self {
        self.all.push((when_us, trouble));
        self
    }

    /// All of it, and when.
    pub fn all(&self) -> impl Iterator<Item = (&Range<u64>, Trouble)> {
        self.all
            .iter()
            .map(|(when_us, trouble)| (when_us, *trouble))
    }

    /// What is broken at a time.
    pub fn at(&self, drive_us: u64) -> impl Iterator<Item = Trouble> {
        self.all()
            .filter(move |(when_us, _)| when_us.contains(&drive_us))
            .map(|(_, trouble)| trouble)
    }
}
