//! Lines that follow from the form and the eye, as chains of points in space. What hides them, and how they are drawn,
//! is decided by whoever looks.

mod contour;

pub use contour::{Chains, Contours, Eye};
