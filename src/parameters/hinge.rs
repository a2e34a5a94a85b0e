//! From a set of values to an elbow's machine, and back.

use super::machine::{Contradiction, ELBOW, OFFSETS, SCALES};
use super::set::ParameterSet;
use super::table::Key;
use crate::identification::hinge::{Drawing, HINGE_UNKNOWNS, Hinge, MAX_CABLES};
use crate::procedure::Limits;
use crate::procedure::elbow::ElbowRig;
use crate::rig::RigError;
use nalgebra::Vector3;

use Key::*;

const AXIS: [Key; 3] = [HingeAxisX, HingeAxisY, HingeAxisZ];
const POINT: [Key; 3] = [HingePointX, HingePointY, HingePointZ];
const END_AXIS: [Key; 3] = [HingeEndAxisX, HingeEndAxisY, HingeEndAxisZ];
const END_POINT: [Key; 3] = [HingeEndPointX, HingeEndPointY, HingeEndPointZ];
/// In the order of the hinge's unknowns.
const SIGMAS: [Key; HINGE_UNKNOWNS] = [
    HingeSigmaAxis,
    HingeSigmaAxis,
    HingeSigmaPoint,
    HingeSigmaPoint,
    HingeSigmaEndAxis,
    HingeSigmaEndAxis,
    HingeSigmaEndPoint,
    HingeSigmaEndPoint,
    HingeSigmaAlong,
];

/// There is a drawing, which only tells two solutions apart, or is a prior.
const TELLS_APART: u32 = 1;
const IS_PRIOR: u32 = 2;
/// A direction shorter than this is none.
const SHORTEST: f32 = 1e-3;

impl Contradiction {
    /// About an elbow: some faults lie elsewhere than with a ball.
    pub(super) fn of_elbow(error: RigError) -> Self {
        match error {
            RigError::NotFinite => Self::about(Cable1BaseX),
            other => Self::of_rig(other),
        }
    }
}

impl ParameterSet {
    /// An elbow has neither corrections of commissioning nor offsets stated for a run, nor what a ball's capture has.
    pub(super) fn require_nothing_of_a_ball(&self) -> Result<(), Contradiction> {
        let off = |keys: &[Key], none: f32| keys.iter().find(|key| self.single(**key) != none).copied();
        let single = off(&OFFSETS, 0.0).or(off(&SCALES, 1.0)).or(off(&[SampleNoise, OffsetPrior], 0.0));
        let asked = single.or((self.integer(CaptureInMotion) != 0).then_some(CaptureInMotion));
        asked.map_or(Ok(()), |key| Err(Contradiction::about(key)))
    }

    /// The machine of an elbow's board.
    pub(super) fn elbow(&self) -> Result<ElbowRig, RigError> {
        let cables = self.cables();
        let count = (self.integer(HingeCables) as usize).min(MAX_CABLES);
        let cables = cables.get(..count).unwrap_or(&cables);
        ElbowRig::new(cables, self.drum(), self.single(LengthNoise), self.tolerance(), self.drawing()?)
    }

    fn drawing(&self) -> Result<Option<Drawing<f32>>, RigError> {
        let drawing = self.integer(HingeDrawing);
        if drawing == 0 {
            return Ok(None);
        }
        let vector = |keys: [Key; 3]| Vector3::from(keys.map(|key| self.single(key)));
        let (axis, end_axis) = (vector(AXIS), vector(END_AXIS));
        let range_rad = (self.single(HingeLowest), self.single(HingeHighest));
        let has_length = |axis: &Vector3<f32>| axis.norm_squared() > SHORTEST * SHORTEST;
        if !(has_length(&axis) && has_length(&end_axis) && range_rad.0 < range_rad.1) {
            return Err(RigError::DrawingMissing);
        }
        let hinge = Hinge::through(&axis, &vector(POINT), &end_axis, &vector(END_POINT));
        let sigma = (drawing == IS_PRIOR).then(|| SIGMAS.map(|key| self.single(key)));
        Ok(Some(Drawing { hinge, sigma, range_rad }))
    }

    /// The values of an elbow that was made by other means. Of a drawing's standard deviations the first of each pair counts.
    pub(super) fn of_elbow(rig: &ElbowRig, limits: &Limits) -> Self {
        let mut set = Self::new();
        set.put_integer(Geometry, ELBOW);
        set.put_integer(HingeCables, rig.cables().into());
        set.put_cables(rig.hinge().cables());
        set.put_tolerance(rig.hinge().tolerance());
        set.put_drum(rig.drum());
        set.put_single(LengthNoise, rig.hinge().length_noise_mm());
        if let Some(drawing) = rig.hinge().drawing() {
            set.put_drawing(drawing);
        }
        set.put_settings(limits.settings());
        set
    }

    fn put_drawing(&mut self, drawing: &Drawing<f32>) {
        let Drawing { hinge, sigma, range_rad: (lowest, highest) } = drawing;
        self.put_integer(HingeDrawing, if sigma.is_some() { IS_PRIOR } else { TELLS_APART });
        let (point, end_axis) = (hinge.platform_foot_mm(), hinge.axis_in_platform());
        let vectors =
            [(AXIS, hinge.axis()), (POINT, &point), (END_AXIS, &end_axis), (END_POINT, hinge.foot_in_platform_mm())];
        for (keys, vector) in vectors {
            keys.iter().zip(vector.iter()).for_each(|(key, value)| self.put_single(*key, *value));
        }
        self.put_single(HingeLowest, *lowest);
        self.put_single(HingeHighest, *highest);
        for (key, sigma) in SIGMAS.iter().zip(sigma.iter().flatten()) {
            self.put_single(*key, *sigma);
        }
    }
}
