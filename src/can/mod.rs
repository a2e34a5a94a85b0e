//! CAN vocabulary: frames and messages of `glenoid.dbc`.
