//! The arm's file: three modules with their logs, rigs and lengths in one posture, and how they stand on the limbs.

use super::report;
use crate::identify::input_error::{self, InputError};
use crate::identify::rig_file::source::Source;
use crate::identify::rig_file::{RigFile, default_rig, read_hinge};
use crate::identify::wording::small;
use glenoid::identification::arm::{Module, Mount};
use glenoid::identification::hinge::{HingeRig, MAX_CABLES};
use glenoid::kinematics::CableLengths;
use glenoid::rig::CABLES;
use nalgebra::{Matrix3, Vector3};
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The keys of the file.
const KEYS: [&str; 6] = ["hand", "shoulder", "elbow", "wrist", "upper_arm", "forearm"];

/// The sections among them, and the keys of each.
const SECTIONS: [(&str, &[&str]); 5] = [
    ("shoulder", &["log", "rig", "posture"]),
    ("elbow", &["log", "rig", "posture"]),
    ("wrist", &["log", "rig", "posture"]),
    ("upper_arm", &["rotation", "origin", "sigma_mm", "sigma_deg"]),
    ("forearm", &["rotation", "origin", "sigma_mm", "sigma_deg"]),
];

/// The most that can be meant as a standard deviation of a mount: beyond that, turning is not linear any more.
const MOST_DEG: f64 = 30.0;
const MOST_MM: f64 = 100.0;

/// No point of an arm is further from the origin of its frame, mm; and one that is nearer than this, but not at it, is in metres.
const FARTHEST_MM: f64 = 2000.0;
const NEAREST_MM: f64 = 1.0;

/// A module that is a ball.
pub struct BallFile {
    /// Its log.
    pub log: PathBuf,
    /// The file of its rig, if it has one.
    pub rig_path: Option<PathBuf>,
    /// Its rig.
    pub rig: RigFile,
    /// Its lengths in the posture.
    pub posture: CableLengths<f64>,
}

/// The module that is a hinge.
pub struct HingeFile {
    /// Its log.
    pub log: PathBuf,
    /// The file of its rig.
    pub rig_path: PathBuf,
    /// Its rig.
    pub rig: HingeRig<f64>,
    /// Its lengths in the posture, mm.
    pub posture_mm: [f64; MAX_CABLES],
}

/// All of it.
pub struct ArmFile {
    /// Its name for messages.
    pub file: String,
    /// Between trunk and upper arm.
    pub shoulder: BallFile,
    /// Between upper arm and forearm.
    pub elbow: HingeFile,
    /// Between forearm and hand.
    pub wrist: BallFile,
    /// The elbow's base in the shoulder's platform.
    pub upper_arm: Mount<f64>,
    /// The wrist's base in the elbow's platform.
    pub forearm: Mount<f64>,
    /// The hand in the wrist's platform, mm.
    pub hand_mm: Vector3<f64>,
}

/// A section of the file.
struct Section<'s, 'a> {
    source: &'s Source<'a>,
    name: &'static str,
    table: &'s DeTable<'a>,
    place: std::ops::Range<usize>,
    folder: PathBuf,
}

impl ArmFile {
    /// Reads it, and the rigs that it names.
    ///
    /// # Errors
    /// [`InputError`] names the place that cannot be read.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (file, bytes) = input_error::read(path)?;
        let source = Source::of(&file, &bytes)?;
        let table = &source.any_table()?;
        source.refuse_unknown(table, "the file", &KEYS)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let section = |index: usize| Section::new(&source, table, SECTIONS[index], &folder);
        let hand = source.value(table, "hand", "[x, y, z], in mm,")?;
        let (shoulder, elbow, wrist) = (section(0)?, section(1)?, section(2)?);
        elbow.has_a_log_of_its_own(&[&shoulder])?;
        wrist.has_a_log_of_its_own(&[&shoulder, &elbow])?;
        Ok(Self {
            file: file.clone(),
            hand_mm: place_mm(&source, hand, "hand")?,
            shoulder: shoulder.ball()?,
            elbow: elbow.hinge()?,
            wrist: wrist.ball()?,
            upper_arm: section(3)?.mount()?,
            forearm: section(4)?.mount()?,
        })
    }
}

impl ArmFile {
    /// What to do about lengths of a posture that cannot be.
    pub fn read_again(&self, module: Module) -> String {
        let section = report::name(module);
        format!(
            "Correct posture = [...] of [{section}] in {}: mm, in the order of the cables, all of them read while the arm holds \
             one posture, with the encoders homed as for the log.",
            self.file
        )
    }
}

impl BallFile {
    /// The command that says what to do about its log: on the same lengths, with the same noise.
    pub fn identify(&self) -> String {
        // What the rig's file states is known to the command as well.
        let noise_mm = self.rig.samples_a_row.is_none().then(|| self.rig.rig.length_noise_mm());
        identify(&self.log, self.rig_path.as_deref(), noise_mm)
    }
}

impl HingeFile {
    /// The command that says what to do about its log: on the same lengths, with the same noise.
    pub fn identify(&self) -> String {
        identify(&self.log, Some(&self.rig_path), Some(self.rig.length_noise_mm()))
    }
}

/// A point in a module's frame, mm.
fn place_mm(source: &Source, value: &Spanned<DeValue>, name: &str) -> Result<Vector3<f64>, InputError> {
    let point_mm = Vector3::from(source.numbers::<3>(value, name)?);
    let distance_mm = point_mm.norm();
    if distance_mm > 0.0 && distance_mm < NEAREST_MM {
        let message = format!("{name}: {distance_mm} from the origin looks like metres; millimetres are wanted");
        return Err(source.error(value.span(), message));
    }
    if !(distance_mm <= FARTHEST_MM) {
        let message = format!("{name}: a point within {FARTHEST_MM} mm of the origin is wanted");
        return Err(source.error(value.span(), message));
    }
    Ok(point_mm)
}

fn identify(log: &Path, rig: Option<&Path>, noise_mm: Option<f64>) -> String {
    let rig = rig.map_or_else(String::new, |rig| format!(" --rig {}", rig.display()));
    let noise = noise_mm.map_or_else(String::new, |noise_mm| format!(" --noise {}", small(noise_mm)));
    format!("This says what to do: cargo identify -- {}{rig}{noise}", log.display())
}

impl<'s, 'a> Section<'s, 'a> {
    fn new(
        source: &'s Source<'a>,
        file: &'s DeTable<'a>,
        (name, keys): (&'static str, &[&str]),
        folder: &Path,
    ) -> Result<Self, InputError> {
        let end = source.text.len();
        let section =
            file.get(name).ok_or_else(|| source.error(end..end, format!("the section [{name}] is missing")))?;
        let table = section.get_ref().as_table();
        let table = table.ok_or_else(|| source.error(section.span(), format!("{name}: a section is wanted")))?;
        source.refuse_unknown(table, name, keys)?;
        Ok(Self { source, name, table, place: section.span(), folder: folder.to_owned() })
    }

    fn path(&self, key: &str) -> Result<Option<PathBuf>, InputError> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(name) => Ok(Some(self.folder.join(name))),
            None => Err(self.source.error(value.span(), format!("{key}: the name of a file is wanted"))),
        }
    }

    /// Refuses a log that another module has: one recording shows one joint.
    fn has_a_log_of_its_own(&self, others: &[&Self]) -> Result<(), InputError> {
        let is_same = |other: &&&Self| match (self.log(), other.log()) {
            (Ok(own), Ok(other)) => input_error::have_same_content(&own, &other),
            _ => false,
        };
        let Some(other) = others.iter().find(is_same) else { return Ok(()) };
        let place = self.table.get("log").map_or(self.place.clone(), Spanned::span);
        Err(self.source.error(place, format!("{}: the log is that of the {}", self.name, other.name)))
    }

    fn log(&self) -> Result<PathBuf, InputError> {
        let missing = || self.source.error(self.place.clone(), format!("{}: log = \"FILE.csv\" is missing", self.name));
        self.path("log")?.ok_or_else(missing)
    }

    fn ball(&self) -> Result<BallFile, InputError> {
        let rig_path = self.path("rig")?;
        let rig = match &rig_path {
            Some(path) if read_hinge(path)?.is_some() => {
                return Err(self.other_joint("a hinge, where a ball is wanted"));
            }
            Some(path) => RigFile::read(path)?,
            None if self.name == "wrist" => return Err(self.other_joint("missing")),
            None => RigFile::of(default_rig()?),
        };
        let value = self.source.value_at(self.place.clone(), self.table, "posture", "[six lengths], in mm,")?;
        let posture = CableLengths::new(self.source.numbers::<CABLES>(value, "posture")?)
            .map_err(|error| self.source.error(value.span(), format!("posture: {}", error.fault.text())))?;
        Ok(BallFile { log: self.log()?, rig_path, rig, posture })
    }

    fn hinge(&self) -> Result<HingeFile, InputError> {
        let rig_path = self.path("rig")?.ok_or_else(|| self.other_joint("missing"))?;
        let no_hinge = || self.other_joint("no hinge: joint = \"hinge\" is wanted in it");
        let rig = read_hinge(&rig_path)?.ok_or_else(no_hinge)?.rig;
        let count = rig.cables().len();
        let value =
            self.source.value_at(self.place.clone(), self.table, "posture", "[a length for each cable], in mm,")?;
        let items = value.get_ref().as_array().filter(|items| items.len() == count);
        let message = || self.source.error(value.span(), format!("posture: {count} lengths are wanted, one a cable"));
        let mut posture_mm = [0.0; MAX_CABLES];
        for (length, item) in posture_mm.iter_mut().zip(items.ok_or_else(message)?.iter()) {
            *length = self.source.number(item, "posture")?;
            if *length <= 0.0 {
                return Err(self.source.error(item.span(), "posture: a length is positive"));
            }
        }
        Ok(HingeFile { log: self.log()?, rig_path, rig, posture_mm })
    }

    fn other_joint(&self, what: &str) -> InputError {
        let place = self.table.get("rig").map_or(self.place.clone(), Spanned::span);
        self.source.error(place, format!("{}: the rig is {what}", self.name))
    }

    fn mount(&self) -> Result<Mount<f64>, InputError> {
        let value = |key: &str, shape: &str| self.source.value_at(self.place.clone(), self.table, key, shape);
        let rotation = value("rotation", "[[…], […], […]], three rows of three numbers,")?;
        let mut rows = [[0.0; 3]; 3];
        for (row, item) in rows.iter_mut().zip(self.source.items::<3>(rotation, "rotation", "rows")?) {
            *row = self.source.numbers::<3>(item, "a row of rotation")?;
        }
        let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
        let is_rotation =
            (matrix * matrix.transpose() - Matrix3::identity()).norm() < 1e-3 && matrix.determinant() > 0.0;
        if !is_rotation {
            return Err(self.source.error(rotation.span(), "rotation: the rows are no rotation"));
        }
        let origin_mm = place_mm(self.source, value("origin", "[x, y, z], in mm,")?, "origin")?;
        let sigma = |key: &str, most: f64| match self.table.get(key) {
            None => Ok(0.0),
            Some(value) => match self.source.number(value, key)? {
                sigma if (0.0..=most).contains(&sigma) => Ok(sigma),
                _ => Err(self
                    .source
                    .error(value.span(), format!("{key}: a standard deviation of 0 to {most} is wanted"))),
            },
        };
        let sigma_rad = sigma("sigma_deg", MOST_DEG)?.to_radians();
        Ok(Mount { rotation: matrix, origin_mm, sigma_mm: sigma("sigma_mm", MOST_MM)?, sigma_rad })
    }
}
