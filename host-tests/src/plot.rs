//! Charts as SVG and PNG: the same bytes for the same data, on a machine without fonts or graphics libraries.
//!
//! A figure ([`Chart`], [`HeatMap`], [`Sphere`]) describes data and says nothing about pixels. It paints itself on a
//! [`Sheet`], of which there are two: text in SVG, anti-aliased pixels in PNG. Both take coordinates in CSS pixels
//! (1/96 inch), x to the right and y downwards.
//!
//! The series differ in three ways, by colour (Okabe and Ito, "Color Universal Design", 2008), by marker
//! and by dash, so that a chart survives a black-and-white printer and any kind of colour vision.
//!
//! ```
//! use host_tests::plot::{Axis, Chart, Series, to_svg};
//!
//! let chart = Chart::new("Decay", Axis::linear("time (s)"), Axis::log10("amplitude (mm)"))
//!     .with(Series::line("damped", vec![(0.0, 8.0), (1.0, 0.9), (2.0, 0.1)]));
//! assert!(to_svg(&chart)?.starts_with("<svg"));
//! # Ok::<(), host_tests::plot::PlotError>(())
//! ```

mod axis;
mod chart;
mod frame;
mod heat;
mod letters;
mod marker;
mod palette;
mod png;
mod sheet;
mod sphere;
mod svg;

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

pub use axis::{Axis, Scale};
pub use chart::{Chart, Level, Look, Series};
pub use heat::HeatMap;
pub use palette::Colour;
pub use sheet::{Anchor, Lettering, Sheet, Stroke};
pub use sphere::{Directions, Sphere};

/// Something that can be painted on a sheet of its own size, by whichever thread.
pub trait Figure: Send {
    /// Width and height of the sheet, CSS pixels.
    fn size(&self) -> (f32, f32);

    /// Paints everything but the white background.
    ///
    /// # Errors
    /// [`PlotError::NoData`], [`PlotError::OffScale`] or [`PlotError::Ragged`] when the data cannot be shown. Nothing
    /// is ever left out silently.
    fn paint(&self, sheet: &mut dyn Sheet) -> Result<(), PlotError>;
}

/// Why a figure could not be made.
#[derive(Debug)]
pub enum PlotError {
    /// The figure holds no point at all.
    NoData,
    /// A coordinate is not finite, or not positive on a logarithmic axis.
    OffScale {
        /// Label of the series, or title of the axis.
        label: String,
        /// Index of the point in that series, from 0.
        index: usize,
    },
    /// A heat map whose rows do not match its axes.
    Ragged,
    /// The PNG could not be encoded.
    Encoding,
    /// A file could not be written.
    Writing(PathBuf, io::Error),
}

impl fmt::Display for PlotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlotError::NoData => write!(f, "the chart has no data"),
            PlotError::OffScale { label, index } => {
                write!(f, "point {index} of \"{label}\" cannot be shown on its axis")
            }
            PlotError::Ragged => write!(f, "the heat map's rows do not match its axes"),
            PlotError::Encoding => write!(f, "the PNG could not be encoded"),
            PlotError::Writing(path, error) => write!(f, "cannot write {}: {error}", path.display()),
        }
    }
}

impl std::error::Error for PlotError {}

/// The figure as an SVG document. Text is set in the viewer's own sans-serif.
///
/// # Errors
/// As [`Figure::paint`].
pub fn to_svg(figure: &dyn Figure) -> Result<String, PlotError> {
    let mut sheet = svg::SvgSheet::new(figure.size());
    figure.paint(&mut sheet)?;
    Ok(sheet.finish())
}

/// The figure as a PNG file, two pixels for each CSS pixel. Text is set in DejaVu Sans.
///
/// # Errors
/// As [`Figure::paint`], and [`PlotError::Encoding`].
pub fn to_png(figure: &dyn Figure) -> Result<Vec<u8>, PlotError> {
    let mut sheet = png::PixelSheet::new(figure.size())?;
    figure.paint(&mut sheet)?;
    sheet.finish()
}

/// Writes `<stem>.svg` and `<stem>.png`, creating the folder, and returns the two paths in this order.
///
/// # Errors
/// As [`to_svg`] and [`to_png`], and [`PlotError::Writing`] with the path.
pub fn save(figure: &dyn Figure, stem: &Path) -> Result<[PathBuf; 2], PlotError> {
    if let Some(folder) = stem.parent() {
        fs::create_dir_all(folder).map_err(|error| PlotError::Writing(folder.to_path_buf(), error))?;
    }
    let paths = ["svg", "png"].map(|extension| {
        let mut name = stem.as_os_str().to_owned();
        name.push(".");
        name.push(extension);
        PathBuf::from(name)
    });
    let contents = [to_svg(figure)?.into_bytes(), to_png(figure)?];
    for (path, content) in paths.iter().zip(&contents) {
        fs::write(path, content).map_err(|error| PlotError::Writing(path.clone(), error))?;
    }
    Ok(paths)
}
