//! What breaks during a drive.

use core::ops::Range;

use amiro_ipf::board::acquisition::Bus;

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
    /// A sensor measures so many counts more than it should, or fewer.
    Wrong {
        /// Which one.
        sensor: usize,
        /// What is added; a full register stays full.
        counts: i32,
    },
    /// A sensor measures less often than it was told to.
    Slow {
        /// Which one.
        sensor: usize,
        /// Between two measurements, microseconds.
        period_us: u64,
    },
    /// A sensor's measurements are those of some time before.
    Late {
        /// Which one.
        sensor: usize,
        /// How long before, microseconds.
        by_us: u64,
    },
    /// A sensor does not answer in a share of all rounds, and keeps its power.
    Loose {
        /// Which one.
        sensor: usize,
        /// Of the rounds.
        share: f64,
    },
    /// One of the sensors' buses.
    Bus {
        /// Which one.
        bus: Bus,
        /// What is wrong with it.
        trouble: BusTrouble,
    },
    /// The multiplexer of one of these buses.
    Mux {
        /// Which bus.
        bus: Bus,
        /// What is wrong with it.
        trouble: MuxTrouble,
    },
    /// No frame comes over the robot's bus.
    NoFrames,
    /// All frames say what the first of them said.
    SameFrames,
    /// The frames carry random bytes.
    GarbledFrames,
    /// Frames come less often than they should.
    SeldomFrames {
        /// Least time between two of them, microseconds.
        period_us: u64,
    },
    /// Frames come late.
    LateFrames {
        /// By how much, microseconds.
        by_us: u64,
    },
    /// A share of all frames is lost, each by itself.
    LooseFrames {
        /// Of the frames.
        share: f64,
    },
    /// The odometry takes itself to be elsewhere, by so many metres.
    Elsewhere {
        /// Along x and y of the world.
        by_m: [f32; 2],
    },
}

/// What can be wrong with a bus of sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BusTrouble {
    /// Its cable is out: nobody answers.
    Off,
    /// Somebody holds a wire low.
    HeldLow,
    /// Bytes are disturbed, one in 20 in the mean.
    Disturbed,
    /// Nobody answers in a share of all rounds.
    Loose {
        /// Of the rounds.
        share: f64,
    },
}

/// What can be wrong with a multiplexer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MuxTrouble {
    /// It does not answer and connects nothing.
    Off,
    /// It stays on the channel where it is.
    Stuck,
    /// It jumps to random channels, once in 100 bytes in the mean.
    Jumping,
    /// It does not answer in a share of all rounds.
    Loose {
        /// Of the rounds.
        share: f64,
    },
}

/// What breaks when: times of the drive, microseconds from its start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotFaults {
    all: Vec<(Range<u64>, Trouble)>,
    seed: u64,
}

impl RobotFaults {
    /// Nothing breaks.
    #[must_use]
    pub const fn none() -> Self {
        Self {
            all: Vec::new(),
            seed: 0,
        }
    }

    /// The same, with another seed for what is random about it; by itself it is 0.
    #[must_use]
    pub fn seeded(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// The seed of what is random about it, beside the robot's own.
    #[must_use]
    pub const fn seed(&self) -> u64 {
        self.seed
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
