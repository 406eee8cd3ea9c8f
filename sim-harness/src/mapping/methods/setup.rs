//! The arguments of a mapper's constructor.

use crate::geometry::Rectangle;
use crate::lattice::Lattice;
use crate::mapping::NoEcho;
use crate::rig::Rig;

/// The arguments of a mapper's constructor.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// The robot.
    pub rig: &'a Rig,
    /// The cells.
    pub lattice: Lattice,
    /// Whether the robot's footprint is free in the map (see
    /// [`FootprintMapper`](crate::mapping::FootprintMapper)).
    pub footprint: bool,
    /// The rule for returns without an echo; `None` for the method's own rule.
    pub no_echo: Option<NoEcho>,
    /// The rectangle that [`Method::ALL_FREE`](super::Method::ALL_FREE) maps; without one its
    /// map is empty.
    pub extent: Option<Rectangle>,
}

impl<'a> Setup<'a> {
    /// Cells for a robot; no footprint, no rectangle, and the method's own rule for returns
    /// without an echo.
    #[must_use]
    pub fn new(rig: &'a Rig, lattice: impl Into<Lattice>) -> Self {
        Self {
            rig,
            lattice: lattice.into(),
            footprint: false,
            no_echo: None,
            extent: None,
        }
    }
}
