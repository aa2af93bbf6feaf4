//! Hostile words and every status survive in every format.
