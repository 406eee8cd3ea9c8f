//! The counting model: survivors and rejects per cell (paper equations 3 and 4).

use amiro_ipf::filter::Outcome;
use amiro_ipf::geometry::{Point, Pose, Rotation};
use amiro_ipf::node::{Config, Event, ParticleEvent, StepBegun};

use super::carving::Carver;
use super::{Grid, Map, Mapper};

/// Carvings that weigh as much as one particle found free.
const CARVINGS_A_COUNT: u32 = 10;

/// How often a cell was found occupied and free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Counts {
    occupied: u16,
    free: u16,
    /// Steps in which some sensor saw past the cell; a tenth of a free count each.
    carved: u16,
}

impl Counts {
    /// f_occ = c_occ / (c_occ + c_free); an untouched cell is 0.5, unknown (eq. 4).
    fn p_occ(self) -> f32 {
        let occupied = CARVINGS_A_COUNT * u32::from(self.occupied);
        let free = CARVINGS_A_COUNT * u32::from(self.free) + u32::from(self.carved);
        if occupied == free {
            // Exactly as much for as against: unknown, whatever rounding would say.
            return 0.5;
        }
        occupied as f32 / (occupied + free) as f32
    }

    fn count(&mut self, occupied: bool) {
        self.make_room();
        if occupied {
            self.occupied += 1;
        } else {
            self.free += 1;
        }
    }

    fn carve(&mut self) {
        self.make_room();
        self.carved += 1;
    }

    /// At the cap all counts halve, which keeps their ratio.
    fn make_room(&mut self) {
        let counts = [&mut self.occupied, &mut self.free, &mut self.carved];
        if counts.iter().any(|count| **count == u16::MAX) {
            counts.into_iter().for_each(|count| *count /= 2);
        }
    }
}

/// Counts particle events into a grid that is fixed in the world.
#[derive(Clone, Debug)]
pub struct CountingMapper {
    counts: Grid<Counts>,
    carver: Option<Carver>,
    /// The lowest bits of the step whose outcomes come.
    step: Option<u8>,
    position: Point,
    rotation: Rotation,
}

impl CountingMapper {
    /// A mapper with square cells of the given size, metres.
    #[must_use]
    pub fn new(cell_m: f64) -> Self {
        Self {
            counts: Grid::new(cell_m, Counts::default()),
            carver: None,
            step: None,
            position: Point::default(),
            rotation: Rotation::by(0.0),
        }
    }

    /// A mapper that also carves the lobes of the sensors of a configuration: each step
    /// gives a tenth of a free count to every cell that some sensor sees past.
    ///
    /// Not in the paper. Where few particles leave the free space speckled it fills the
    /// gaps, at the cost of reading the sensors on the map's side as well.
    #[must_use]
    pub fn carving(cell_m: f64, config: &Config) -> Self {
        Self {
            carver: Some(Carver::new(cell_m, config)),
            ..Self::new(cell_m)
        }
    }

    /// Where the robot is while the following outcomes are counted.
    pub fn begin_step(&mut self, step: &StepBegun) {
        self.move_to(&step.pose);
        let Some(carver) = &self.carver else {
            return;
        };
        let Some(cells) = carver.seen_past(step) else {
            self.counts.refuse();
            return;
        };
        for cell in cells {
            if let Some(counts) = self.counts.reach(cell) {
                counts.carve();
            }
        }
    }

    fn move_to(&mut self, pose: &Pose) {
        self.position = pose.position;
        self.rotation = Rotation::by(pose.heading.radians());
    }

    /// Counts outcomes of the current step (eq. 3).
    pub fn count(&mut self, outcomes: &[ParticleEvent]) {
        for event in outcomes {
            let occupied = match event.outcome() {
                Outcome::SurvivedPastGate => true,
                Outcome::RejectedFree => false,
                Outcome::SurvivedBelowGate | Outcome::RejectedUnobserved => continue,
            };
            let world = self.position + event.position().rotated(self.rotation);
            let (x, y) = (f64::from(world.x), f64::from(world.y));
            if let Some(counts) = self.counts.reach_at(x, y) {
                counts.count(occupied);
            }
        }
    }

    /// The map so far.
    #[must_use]
    pub fn map(&self) -> Map {
        self.counts.map(0.5, |counts| counts.p_occ())
    }
}

impl Mapper for CountingMapper {
    fn take(&mut self, event: &Event) {
        match event {
            Event::StepBegun(step) => {
                self.step = Some(step.index as u8);
                self.begin_step(step);
            }
            // Those of a step whose begin was lost would be counted at another pose.
            Event::Particles(particles) if self.step == Some(particles.step) => {
                self.count(&particles.outcomes);
            }
            _ => {}
        }
    }

    fn map(&self) -> Map {
        self.map()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Occupancy;

    fn counts(occupied: u16, free: u16) -> Counts {
        Counts {
            occupied,
            free,
            carved: 0,
        }
    }

    #[test]
    fn ten_carvings_weigh_one_count() {
        let mut cell = counts(1, 0);
        (0..9).for_each(|_| cell.carve());
        assert_eq!(Occupancy::of(cell.p_occ()), Occupancy::Occupied);
        cell.carve();
        assert_eq!(Occupancy::of(cell.p_occ()), Occupancy::Unknown);
        cell.carve();
        assert_eq!(Occupancy::of(cell.p_occ()), Occupancy::Free);
    }

    #[test]
    fn probability_is_the_share_of_occupied_counts() {
        for (occupied, free, p) in [
            (0, 0, 0.5),
            (3, 1, 0.75),
            (0, 9, 0.0),
            (1, 0, 1.0),
            (7, 7, 0.5),
        ] {
            let error = (counts(occupied, free).p_occ() - p).abs();
            assert!(error < 1e-7, "{occupied} / {free}");
        }
        assert_eq!(Occupancy::of(counts(7, 7).p_occ()), Occupancy::Unknown);
    }

    #[test]
    fn f53_halving_at_the_cap_keeps_the_ratio() {
        let mut cell = counts(u16::MAX, 20_000);
        let before = cell.p_occ();
        cell.count(true);
        assert!((cell.p_occ() - before).abs() < 1e-4);
        assert_eq!(cell, counts(32_768, 10_000));
    }

    #[test]
    fn outcomes_land_in_the_world_and_two_of_four_count() {
        let mut mapper = CountingMapper::new(0.01);
        mapper.move_to(&Pose::new(1.0, 2.0, core::f32::consts::FRAC_PI_2));
        // 100 mm ahead of a robot that looks along +y: 1.0, 2.1.
        let ahead = |outcome| ParticleEvent::new((6400 + 320, -320), outcome);
        mapper.count(&[
            ahead(Outcome::SurvivedPastGate),
            ahead(Outcome::SurvivedBelowGate),
            ahead(Outcome::RejectedUnobserved),
        ]);
        let map = mapper.map();
        let cell = map.cell_at(1.005, 2.105).unwrap();
        assert_eq!(
            map.get(cell).map(|p| Occupancy::of(*p)),
            Some(Occupancy::Occupied)
        );
        mapper.count(&[ahead(Outcome::RejectedFree); 2]);
        assert_eq!(
            mapper.map().get(cell).map(|p| Occupancy::of(*p)),
            Some(Occupancy::Free)
        );
    }
}
