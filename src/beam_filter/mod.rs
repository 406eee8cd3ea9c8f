//! The inverted particle filter for range beams: obstacles around a moving robot.
//!
//! The sensors are narrow: laser, time of flight, infrared triangulation. Particles fill
//! a disc about the robot. The weight of a particle is the probability that its position
//! is part of an obstacle: 0.5 is undetermined. A beam overwrites the weights along
//! itself: low up to the measured range, high at it. Weights return to 0.5 by a decay, so
//! an obstacle that is not measured again fades. Memory is constant; the time of a cycle
//! is linear in particles and beams.
//!
//! [`BeamParticleFilter::cycle`] is Algorithm 2 of \[KS\]: it moves the particles against
//! the robot's motion (`advance`), lets those that leave the disc enter it again
//! ([`Reentry`]), moves low particles to obstacles (`resample`) and weighs by a set of
//! [`RangeBeam`]s. [`BeamFilterParameters::PAPER`] is the paper's form,
//! [`BeamFilterParameters::MOVING`] the form for a robot that moves. Robots can share
//! their obstacles: [`BeamParticleFilter::export`], [`BeamParticleFilter::import`].
//!
//! It is no part of [`crate::filter`]: there a particle is a hypothesis that survives or
//! is rejected, and an infrared sensor is a wide lobe with a photometric law. Here a
//! particle stays and its weight is the answer.
//!
//! # Axes
//!
//! Positions are relative to the robot, in axes that do **not** turn with it. The filter
//! holds the heading of the body in these axes. A correction of the heading
//! ([`BeamParticleFilter::set_heading`]) therefore moves no particle.
//! [`BeamParticleFilter::particle_frame`] places the axes in the world.
//!
//! # Misprints of the paper, corrected here
//!
//! | printed | here | why |
//! |---|---|---|
//! | x^2 + y^2 <= r at the start | r^2 | wrong for every r but 1 |
//! | w (1 + e_w) below 0.5, w (1 - e_w) else | 0.5 + (w - 0.5) (1 - e_w) | 0 is absorbing, 0.5 no fixed point |
//! | distance to the line through the beam | to the segment | a line clears what is behind the robot and behind the obstacle |
//! | l_y, length of the beam, as tolerance | a tolerance of centimetres | every particle within one range becomes an obstacle |
//! | maximum range as a measurement | clears only | a ring of obstacles at the maximum range |
//! | e_m required, not used | N(0, (e_m m)^2) per axis | |
//! | e_w per reading | per cycle | a frame of 32 beams would decay 32 times |
//! | 5 floats, 10 000 particles in 50 kB | 3 floats, 120 kB | 5 floats are 200 kB; theta is written and never read |
//!
//! Other deviations are documented where they are: the order of the stages at
//! [`BeamParticleFilter::cycle`], resampling in one pass, re-entry at [`Reentry`].
//!
//! # Example
//!
//! ```
//! use amiro_ipf::beam_filter::{
//!     BeamFilterParameters, BeamModel, BeamParticle, BeamParticleFilter, BeamRange, RangeBeam,
//! };
//! use amiro_ipf::geometry::{Angle, Motion, Point, Pose};
//! use amiro_ipf::random::Generator;
//!
//! let model = BeamModel::new(BeamFilterParameters::MOVING)?;
//! let mut rng = Generator::seeded(1);
//! let mut filter = BeamParticleFilter::<4000>::new();
//! filter.reset(&model, 4000, Angle::default(), &mut rng);
//! // 10 cm of straight driving towards a wall 0.7 m ahead, with five beams at the front.
//! for millimetre in 0..=100_u8 {
//!     let to_wall = 0.7 - f32::from(millimetre) * 1e-3;
//!     let advanced = if millimetre == 0 { 0.0 } else { 1e-3 };
//!     let motion = Motion { displacement: Point::new(advanced, 0.0), ..Motion::NONE };
//!     let mut beams = Vec::new();
//!     for column in -2..=2_i8 {
//!         let mount = Pose::new(0.0, 0.05 * f32::from(column), 0.0);
//!         beams.push(RangeBeam::new(&mount, BeamRange::Echo(to_wall))?);
//!     }
//!     filter.cycle(&model, &motion, &beams, &mut rng);
//! }
//! let nearest = filter.nearest_obstacle(BeamParticle::HIGH).expect("an obstacle is known");
//! assert!((nearest.x - 0.6).abs() < 0.04);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Source key: \[KS\] is Kleppe, Skavhaug: Obstacle detection and mapping in low-cost,
//! low-power multi-robot systems using an Inverted Particle Filter, SAFECOMP 2013, workshop
//! DECS, hal-00849817.

mod beam;
mod filter;
mod model;
mod parameters;
mod particle;
mod propagate;
mod resample;
mod sharing;
#[cfg(test)]
mod tests;

pub use beam::{BeamError, BeamRange, RangeBeam};
pub use filter::{BeamParticleFilter, BeamTally};
pub use model::BeamModel;
pub use parameters::{BeamFilterParameters, Reentry};
pub use particle::BeamParticle;
pub use sharing::ImportTally;
