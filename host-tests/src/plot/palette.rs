//! Colours and dashes that stay apart for every kind of colour vision and in black and white.

/// An opaque colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour {
    /// Red, 0..=255, sRGB.
    pub red: u8,
    /// Green, 0..=255, sRGB.
    pub green: u8,
    /// Blue, 0..=255, sRGB.
    pub blue: u8,
}

impl Colour {
    /// Text and axes.
    pub const INK: Self = Self::of(0x22_22_22);
    /// Secondary text.
    pub const GREY: Self = Self::of(0x66_66_66);
    /// Grid lines.
    pub const GRID: Self = Self::of(0xE4_E4_E4);
    /// The sheet.
    pub const WHITE: Self = Self::of(0xFF_FF_FF);

    /// From `0xRRGGBB`.
    pub const fn of(rgb: u32) -> Self {
        Self { red: (rgb >> 16) as u8, green: (rgb >> 8) as u8, blue: rgb as u8 }
    }

    /// The colour between `self` (`share` 0) and `other` (`share` 1).
    fn towards(self, other: Self, share: f64) -> Self {
        let mix = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * share).round() as u8;
        Self { red: mix(self.red, other.red), green: mix(self.green, other.green), blue: mix(self.blue, other.blue) }
    }

    /// Black or white, whichever reads better on `self` (Rec. 709 luma on the encoded values).
    pub(super) fn readable_on_it(self) -> Self {
        let luma = 0.2126 * f64::from(self.red) + 0.7152 * f64::from(self.green) + 0.0722 * f64::from(self.blue);
        if luma > 130.0 { Self::INK } else { Self::WHITE }
    }
}

/// Line and marker colours in order of use: Okabe and Ito's palette without its yellow, which is lost on white.
const SERIES: [Colour; 7] = [
    Colour::of(0x00_72_B2),
    Colour::of(0xD5_5E_00),
    Colour::of(0x00_9E_73),
    Colour::of(0xCC_79_A7),
    Colour::of(0xE6_9F_00),
    Colour::of(0x56_B4_E9),
    Colour::of(0x00_00_00),
];

const DASHES: [&[f32]; 5] = [&[], &[7.0, 4.0], &[2.0, 3.0], &[9.0, 3.0, 2.0, 3.0], &[14.0, 4.0]];

/// Colour of the `index`-th series.
pub(super) fn series_colour(index: usize) -> Colour {
    SERIES[index % SERIES.len()]
}

/// Dash of the `index`-th series. Five dashes and seven colours only repeat together after 35 series.
pub(super) fn series_dash(index: usize) -> &'static [f32] {
    DASHES[index % DASHES.len()]
}

/// Nine stops of matplotlib's "viridis": its lightness grows steadily, so it also orders without colour.
const VIRIDIS: [Colour; 9] = [
    Colour::of(0x44_01_54),
    Colour::of(0x47_2D_7B),
    Colour::of(0x3B_52_8B),
    Colour::of(0x2C_72_8E),
    Colour::of(0x21_91_8C),
    Colour::of(0x28_AE_80),
    Colour::of(0x5E_C9_62),
    Colour::of(0xAD_DC_30),
    Colour::of(0xFD_E7_25),
];

/// The colour that stands for `share` of the way from least (0, dark) to most (1, light).
pub(super) fn shade(share: f64) -> Colour {
    let position = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let below = (position as usize).min(VIRIDIS.len() - 2);
    VIRIDIS[below].towards(VIRIDIS[below + 1], position - below as f64)
}
