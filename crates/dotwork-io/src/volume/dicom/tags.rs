//! The elements that are read (PS3.6), by group and number.

macro_rules! tags {
    ($($(#[$doc:meta])* $name:ident = $tag:literal;)*) => {
        $($(#[$doc])* pub(super) const $name: u32 = $tag;)*
        /// All of them.
        const ALL: &[u32] = &[$($tag),*];
    };
}

tags! {
    TRANSFER_SYNTAX = 0x0002_0010;
    /// What DICOMDIR holds.
    DIRECTORY_RECORDS = 0x0004_1220;
    REFERENCED_FILE = 0x0004_1500;
    IMAGE_TYPE = 0x0008_0008;
    MODALITY = 0x0008_0060;
    MANUFACTURER = 0x0008_0070;
    SERIES_DESCRIPTION = 0x0008_103e;
    MODEL = 0x0008_1090;
    THICKNESS = 0x0018_0050;
    ECHO_TIME = 0x0018_0081;
    SLICE_DISTANCE = 0x0018_0088;
    IMAGER_SPACING = 0x0018_1164;
    SCANNED_SPACING = 0x0018_2010;
    EFFECTIVE_ECHO_TIME = 0x0018_9082;
    B_VALUE = 0x0018_9087;
    ECHO = 0x0018_9114;
    DIFFUSION = 0x0018_9117;
    SERIES_UID = 0x0020_000e;
    SERIES_NUMBER = 0x0020_0011;
    ACQUISITION_NUMBER = 0x0020_0012;
    INSTANCE_NUMBER = 0x0020_0013;
    POSITION = 0x0020_0032;
    ORIENTATION = 0x0020_0037;
    TEMPORAL_POSITION = 0x0020_0100;
    SLICE_LOCATION = 0x0020_1041;
    FRAME_CONTENT = 0x0020_9111;
    PLANE_POSITION = 0x0020_9113;
    PLANE_ORIENTATION = 0x0020_9116;
    TEMPORAL_INDEX = 0x0020_9128;
    COMPONENTS = 0x0028_0002;
    PHOTOMETRIC = 0x0028_0004;
    PLANAR = 0x0028_0006;
    FRAMES = 0x0028_0008;
    ROWS = 0x0028_0010;
    COLUMNS = 0x0028_0011;
    PIXEL_SPACING = 0x0028_0030;
    BITS_ALLOCATED = 0x0028_0100;
    BITS_STORED = 0x0028_0101;
    HIGH_BIT = 0x0028_0102;
    PIXEL_REPRESENTATION = 0x0028_0103;
    PADDING = 0x0028_0120;
    PADDING_LIMIT = 0x0028_0121;
    INTERCEPT = 0x0028_1052;
    SLOPE = 0x0028_1053;
    PIXEL_MEASURES = 0x0028_9110;
    VALUE_TRANSFORMATION = 0x0028_9145;
    /// Of nuclear medicine: where its frames lie.
    DETECTORS = 0x0054_0022;
    /// Of dose grids: how far each frame lies from the first.
    FRAME_OFFSETS = 0x3004_000c;
    SHARED_GROUPS = 0x5200_9229;
    FRAME_GROUPS = 0x5200_9230;
    FLOAT_PIXELS = 0x7fe0_0008;
    DOUBLE_PIXELS = 0x7fe0_0009;
    PIXELS = 0x7fe0_0010;
    ITEM = 0xfffe_e000;
    ITEM_END = 0xfffe_e00d;
    SEQUENCE_END = 0xfffe_e0dd;
}

/// The sequences among them: the form without types does not say so.
pub(super) const SEQUENCES: [u32; 11] = [
    DIRECTORY_RECORDS,
    ECHO,
    DIFFUSION,
    FRAME_CONTENT,
    PLANE_POSITION,
    PLANE_ORIENTATION,
    PIXEL_MEASURES,
    VALUE_TRANSFORMATION,
    DETECTORS,
    SHARED_GROUPS,
    FRAME_GROUPS,
];

/// True for elements that somebody asks for.
pub(super) fn is_kept(tag: u32) -> bool {
    ALL.binary_search(&tag).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_can_be_searched() {
        assert!(ALL.is_sorted() && SEQUENCES.iter().all(|&t| is_kept(t)));
        // The patient's name and number.
        assert!(!is_kept(0x0010_0010) && !is_kept(0x0010_0020));
    }
}
