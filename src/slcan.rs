//! SLCAN (Lawicel) codec: CAN frames over a serial line.
