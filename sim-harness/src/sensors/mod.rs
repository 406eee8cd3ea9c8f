//! Sensor models: where a return looks, one file per kind of sensor.

mod cone;
mod infrared;
mod scanner;
mod wall_law;

use crate::drive::Return;
use crate::geometry::{Pose2, Vector};
use crate::lattice::{Cell, Lattice};

pub use cone::{Cone, Directivity};
pub use infrared::Infrared;
pub use scanner::Scanner;
pub use wall_law::{EndGradient, WallLaw, WallSegment};

/// The sensor on a mount.
#[derive(Clone, Debug, PartialEq)]
pub enum Sensor {
    /// Reflective infrared: a range that is ambiguous over the lobe.
    Infrared(Infrared),
    /// Sonar, or the minimum of a wide time-of-flight sensor.
    Cone(Cone),
    /// A fan of narrow beams: a laser scanner, the columns of a time-of-flight array.
    Scanner(Scanner),
}

/// A kind of sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorKind {
    /// [`Sensor::Infrared`].
    Infrared,
    /// [`Sensor::Cone`].
    Cone,
    /// [`Sensor::Scanner`].
    Scanner,
}

impl SensorKind {
    /// The kind's name for several sensors.
    #[must_use]
    pub const fn plural(self) -> &'static str {
        match self {
            Self::Infrared => "infrared sensors",
            Self::Cone => "cones",
            Self::Scanner => "scanners",
        }
    }
}

/// A cell that a return is evidence about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenCell {
    /// The cell.
    pub cell: Cell,
    /// Where the cell lies with regard to the measured range.
    pub region: Region,
    /// Distance of its centre from the sensor, metres (r). Of a beam: the distance along it
    /// at which the beam enters the cell.
    pub range_m: f64,
    /// Bearing of its centre off the sensor's axis, radians (theta); of a beam the beam's.
    pub bearing_rad: f64,
    /// Weight of the evidence, in (0, 1]: 1 on the axis.
    pub weight: f64,
    /// The measured range in the cell's direction, or the limit without an echo, metres (z).
    pub measured_m: f64,
}

/// Where a cell lies with regard to a return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// Before the echo (E).
    Before,
    /// Within the tolerance of the echo (O).
    AtEcho,
    /// Before the limit of a return without an echo.
    BeforeLimit,
    /// Within the tolerance of the limit of a return without an echo; of sensors whose
    /// limit is not sharp.
    AtLimit,
}

/// How one kind of sensor measures a range.
pub trait RangeSensor {
    /// Number of returns of one scan.
    fn returns(&self) -> usize;

    /// Visits every cell that a return is evidence about, each once.
    ///
    /// Returns that are too close or invalid are evidence about no cell. Returns whether
    /// all cells have an index in the lattice: false for a robot beyond its range.
    fn footprint(&self, view: &View, visit: &mut dyn FnMut(SeenCell)) -> bool;
}

impl Sensor {
    /// The model of this kind of sensor.
    #[must_use]
    pub fn model(&self) -> &dyn RangeSensor {
        match self {
            Self::Infrared(infrared) => infrared,
            Self::Cone(cone) => cone,
            Self::Scanner(scanner) => scanner,
        }
    }

    /// Its kind.
    #[must_use]
    pub const fn kind(&self) -> SensorKind {
        match self {
            Self::Infrared(_) => SensorKind::Infrared,
            Self::Cone(_) => SensorKind::Cone,
            Self::Scanner(_) => SensorKind::Scanner,
        }
    }

    /// The cone in which it returns the nearest surface; `None` for a scanner.
    ///
    /// That of an infrared sensor is its lobe up to theta_max, which is crude: its range
    /// depends on the bearing. Its limit is x_max, its directivity flat.
    #[must_use]
    pub fn cone(&self) -> Option<Cone> {
        match self {
            Self::Infrared(infrared) => {
                let law = infrared.photometry();
                Some(Cone {
                    half_angle_rad: f64::from(law.theta_max_rad),
                    range_m: [0.0, f64::from(law.x_max_m)],
                    sigma_m: 0.0,
                    directivity: Directivity::Flat,
                })
            }
            Self::Cone(cone) => Some(*cone),
            Self::Scanner(_) => None,
        }
    }

    /// Whether it is a reflective infrared sensor, whose scans carry signals.
    #[must_use]
    pub const fn is_infrared(&self) -> bool {
        matches!(self, Self::Infrared(_))
    }
}

/// One return and where its sensor was.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Number of the return within the sensor's scan, from 0.
    pub index: usize,
    /// What was returned.
    pub measured: Return,
    /// The sensor's pose.
    pub world_from_sensor: Pose2,
    /// Least half width of the band in which an echo lies, metres (beta); a larger
    /// standard deviation of the return takes its place.
    pub tolerance_m: f64,
    /// The cells.
    pub lattice: Lattice,
}

impl View {
    /// The measured range with its tolerance; `None` for a return without a range.
    fn range(&self) -> Option<MeasuredRange> {
        let (measured_m, sigma_m, is_echo) = match self.measured {
            Return::Echo { range_m, sigma_m } => (range_m, sigma_m, true),
            Return::NoEcho { limit_m, sigma_m } => (limit_m, sigma_m, false),
            Return::TooClose | Return::Invalid => return None,
        };
        Some(MeasuredRange {
            measured_m,
            sigma_m,
            is_echo,
            tolerance_m: self.tolerance_m.max(sigma_m),
        })
    }

    /// The cells, row by row, whose centres lie before the sensor in a wedge about its
    /// axis, with the centres in the sensor's frame: all up to a range, some beyond it.
    /// `None` if they have no place in the lattice.
    ///
    /// `tangent` is that of the wedge's half angle. Cost: the cells of the square around
    /// the sensor.
    fn wedge(
        &self,
        tangent: f64,
        reach_m: f64,
    ) -> Option<impl Iterator<Item = (Cell, Vector)> + use<>> {
        let Self {
            world_from_sensor,
            lattice,
            ..
        } = *self;
        let centre = world_from_sensor.position;
        let low = lattice.cell_at(centre.x - reach_m, centre.y - reach_m)?;
        let high = lattice.cell_at(centre.x + reach_m, centre.y + reach_m)?;
        let cells = (low.row..=high.row).flat_map(move |row| {
            (low.column..=high.column).map(move |column| Cell { row, column })
        });
        let seen = cells.map(move |cell| {
            let (x, y) = lattice.centre(cell);
            (cell, world_from_sensor.view(Vector::new(x, y)))
        });
        Some(seen.filter(move |(_, seen)| seen.x > 0.0 && seen.y.abs() <= tangent * seen.x))
    }
}

/// A measured range and the band around it.
#[derive(Clone, Copy, Debug)]
struct MeasuredRange {
    measured_m: f64,
    sigma_m: f64,
    is_echo: bool,
    tolerance_m: f64,
}

impl MeasuredRange {
    /// Where a range lies; `None` beyond the band.
    fn region(&self, range_m: f64) -> Option<Region> {
        let is_before = range_m < self.measured_m - self.tolerance_m;
        let is_beyond = range_m > self.measured_m + self.tolerance_m;
        match (self.is_echo, is_before) {
            _ if is_beyond => None,
            (true, true) => Some(Region::Before),
            (true, false) => Some(Region::AtEcho),
            (false, true) => Some(Region::BeforeLimit),
            (false, false) => Some(Region::AtLimit),
        }
    }
}
