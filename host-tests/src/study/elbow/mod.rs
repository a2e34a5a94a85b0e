//! The elbow: is its axis as good as the lengths allow, is its bar true, and is everything else refused by name?

pub mod bound;
pub mod scene;
