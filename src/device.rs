//! The whole board without hardware: events in, actions out.
