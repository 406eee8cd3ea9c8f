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
