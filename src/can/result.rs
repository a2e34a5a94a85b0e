//! Messages about an identified centre: the parameters, how well they fit, what the poses fix worst.

use super::payload::{Field, PackError, Payload, RUN};
use super::rounding::Scale;

/// A distance that holds an `f32` of 64 mm or more to the bit: ±1024 mm in steps of 2^-17 mm (8 nm).
const LENGTH: Scale = Scale::signed(28, -17);
/// A standard deviation of a parameter: up to 8 mm in steps of 2^-13 mm (0.12 µm).
const SIGMA: Scale = Scale::unsigned(16, -13);
/// A root mean square of residuals: up to 16 mm in steps of 2^-12 mm (0.24 µm).
const DEVIATION: Scale = Scale::unsigned(16, -12);

/// One identified parameter, never without its standard deviation: a coordinate of the centre or a radius.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameter {
    /// The run that identified it.
    pub run_id: u16,
    /// 0 to 2: x, y, z of the centre in {B}, or p1, p2, p3.
    pub index: u8,
    /// The value, mm.
    pub value_mm: f32,
    /// Its standard deviation, mm.
    pub sigma_mm: f32,
}

mod parameter {
    use super::{Field, LENGTH, SIGMA as SIGMA_SCALE};
    pub(super) const INDEX: Field = Field::integer(16, 4);
    pub(super) const VALUE: Field = Field::scaled(20, LENGTH);
    pub(super) const SIGMA: Field = Field::scaled(48, SIGMA_SCALE);
}

impl Parameter {
    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        Payload::new()
            .with(RUN, self.run_id)
            .with(parameter::INDEX, self.index)
            .with_value(parameter::VALUE, self.value_mm)?
            .with_value(parameter::SIGMA, self.sigma_mm)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            index: payload.get_u8(parameter::INDEX),
            value_mm: payload.get_value(parameter::VALUE),
            sigma_mm: payload.get_value(parameter::SIGMA),
        }
    }
}

/// The zero error of one encoder, found with the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ZeroError {
    /// The run that identified it.
    pub run_id: u16,
    /// Cable, 1 to 6.
    pub cable: u8,
    /// What the cable's length reads too much, mm.
    pub value_mm: f32,
    /// Its standard deviation, mm, up to 64: no prior is wider.
    pub sigma_mm: f32,
}

mod zero {
    use super::{Field, LENGTH, Scale};
    pub(super) const CABLE: Field = Field::integer(16, 4);
    pub(super) const VALUE: Field = Field::scaled(20, LENGTH);
    pub(super) const SIGMA: Field = Field::scaled(48, Scale::unsigned(16, -10));
}

impl ZeroError {
    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        Payload::new()
            .with(RUN, self.run_id)
            .with(zero::CABLE, self.cable)
            .with_value(zero::VALUE, self.value_mm)?
            .with_value(zero::SIGMA, self.sigma_mm)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            cable: payload.get_u8(zero::CABLE),
            value_mm: payload.get_value(zero::VALUE),
            sigma_mm: payload.get_value(zero::SIGMA),
        }
    }
}

/// A part of how the centre moves with the arm (see [`ShownMotion`](crate::identification::joint::ShownMotion)).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotionPart {
    /// The run that identified it.
    pub run_id: u16,
    /// 0 to 7.
    pub part: u8,
    /// Its three numbers in steps of 1/128: mm per unit of φ in parts 0 to 5, mm in part 6, none in part 7.
    pub numbers: [i16; 3],
}

mod motion {
    use super::{Field, Scale};
    const NUMBER: Scale = Scale::signed(15, -7);
    pub(super) const PART: Field = Field::integer(16, 3);
    pub(super) const NUMBERS: [Field; 3] =
        [Field::scaled(19, NUMBER), Field::scaled(34, NUMBER), Field::scaled(49, NUMBER)];
}

impl MotionPart {
    pub(super) fn pack(&self) -> Payload {
        let [x, y, z] = motion::NUMBERS;
        // two's complement, as wide as the field
        let raw = self.numbers.map(|number| number as u16);
        let [a, b, c] = raw;
        Payload::new().with(RUN, self.run_id).with(motion::PART, self.part).with(x, a).with(y, b).with(z, c)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        // the sign's bit, 15th of the field, to the 16th and back
        let number = |field| ((payload.get_u16(field) << 1) as i16) >> 1;
        Self { run_id: payload.get_u16(RUN), part: payload.get_u8(motion::PART), numbers: motion::NUMBERS.map(number) }
    }

    /// The three numbers as the DBC scales them.
    pub fn values(&self) -> [f32; 3] {
        self.numbers.map(|number| f32::from(number) * (1.0 / 128.0))
    }
}

/// How well the first set of poses fits the new centre.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Quality {
    /// The run.
    pub run_id: u16,
    /// δE of the poses that identified the centre (Eq. 17), mm.
    pub deviation_mm: f32,
    /// Noise of one cable length as the residuals show it, mm.
    pub noise_mm: f32,
    /// Iterations.
    pub iterations: u8,
    /// Poses that were left out; each has a [`LeftOut`](super::report::LeftOut) of its own.
    pub left_out: u8,
}

mod quality {
    use super::{DEVIATION as SCALE, Field};
    pub(super) const DEVIATION: Field = Field::scaled(16, SCALE);
    pub(super) const NOISE: Field = Field::scaled(32, SCALE);
    pub(super) const ITERATIONS: Field = Field::integer(48, 8);
    pub(super) const LEFT_OUT: Field = Field::integer(56, 8);
}

impl Quality {
    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        let payload = Payload::new()
            .with(RUN, self.run_id)
            .with_value(quality::DEVIATION, self.deviation_mm)?
            .with_value(quality::NOISE, self.noise_mm)?;
        Ok(payload.with(quality::ITERATIONS, self.iterations).with(quality::LEFT_OUT, self.left_out))
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            deviation_mm: payload.get_value(quality::DEVIATION),
            noise_mm: payload.get_value(quality::NOISE),
            iterations: payload.get_u8(quality::ITERATIONS),
            left_out: payload.get_u8(quality::LEFT_OUT),
        }
    }
}

/// How well the second set of poses, which never identified anything, fits the new centre.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VerificationReport {
    /// The run.
    pub run_id: u16,
    /// δE of the second set (Eq. 17), mm.
    pub deviation_mm: f32,
    /// The limit that it was held against, mm.
    pub limit_mm: f32,
    /// Poses of the second set.
    pub poses: u8,
}

mod verification {
    use super::{DEVIATION as SCALE, Field};
    pub(super) const DEVIATION: Field = Field::scaled(16, SCALE);
    pub(super) const LIMIT: Field = Field::scaled(32, SCALE);
    pub(super) const POSES: Field = Field::integer(48, 8);
}

impl VerificationReport {
    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        let payload = Payload::new()
            .with(RUN, self.run_id)
            .with_value(verification::DEVIATION, self.deviation_mm)?
            .with_value(verification::LIMIT, self.limit_mm)?;
        Ok(payload.with(verification::POSES, self.poses))
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            deviation_mm: payload.get_value(verification::DEVIATION),
            limit_mm: payload.get_value(verification::LIMIT),
            poses: payload.get_u8(verification::POSES),
        }
    }
}

/// The direction in the space of the six parameters that the poses fix worst.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WeakDirection {
    /// The run.
    pub run_id: u16,
    /// Unit vector in the order x, y, z, p1, p2, p3.
    pub direction: [f32; 6],
}

mod weak_direction {
    use super::{Field, Scale};
    const COMPONENT: Scale = Scale::signed(8, -6);
    pub(super) const COMPONENTS: [Field; 6] = [
        Field::scaled(16, COMPONENT),
        Field::scaled(24, COMPONENT),
        Field::scaled(32, COMPONENT),
        Field::scaled(40, COMPONENT),
        Field::scaled(48, COMPONENT),
        Field::scaled(56, COMPONENT),
    ];
}

impl WeakDirection {
    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        let mut payload = Payload::new().with(RUN, self.run_id);
        for (field, component) in weak_direction::COMPONENTS.into_iter().zip(self.direction) {
            payload = payload.with_value(field, component)?;
        }
        Ok(payload)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            direction: weak_direction::COMPONENTS.map(|field| payload.get_value(field)),
        }
    }
}

/// The direction in {B} that the run's reason is about: the common axis of all poses, or where the centre is weak.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Axis {
    /// The run.
    pub run_id: u16,
    /// Unit vector in {B}.
    pub axis: [f32; 3],
}

mod axis {
    use super::{Field, Scale};
    const COMPONENT: Scale = Scale::signed(16, -14);
    pub(super) const COMPONENTS: [Field; 3] =
        [Field::scaled(16, COMPONENT), Field::scaled(32, COMPONENT), Field::scaled(48, COMPONENT)];
}

impl Axis {
    pub(super) fn pack(&self) -> Result<Payload, PackError> {
        let mut payload = Payload::new().with(RUN, self.run_id);
        for (field, component) in axis::COMPONENTS.into_iter().zip(self.axis) {
            payload = payload.with_value(field, component)?;
        }
        Ok(payload)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self { run_id: payload.get_u16(RUN), axis: axis::COMPONENTS.map(|field| payload.get_value(field)) }
    }
}
