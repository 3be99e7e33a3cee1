//! Shapes into particles: lattice filling of fluid bodies.
