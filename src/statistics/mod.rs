//! Responses over the design; knows nothing of curves or cloth.

pub mod box_wilson;
