//! From the sform, the qform or the spacings to an affine in LPS.

use dotwork_drawing::Warnings;
use dotwork_volume::{Affine, Space, Unit};
use glam::{DMat3, DVec3};

use crate::volume::facts::Facts;
use crate::volume::grid::{self, lps_from_ras, usable_spacing};
use crate::volume::nifti::header::Header;

/// Two transforms that place a corner of the volume apart by more than this part of a voxel's shortest side disagree.
const AGREEMENT: f64 = 0.1;

/// Steps and origin in RAS.
#[derive(Clone, Copy)]
struct Transform {
    steps: [DVec3; 3],
    origin: DVec3,
}

impl Transform {
    fn usable(&self) -> bool {
        let finite = |v: &DVec3| v.is_finite() && v.abs().max_element() < 1e100;
        let [x, y, z] = self.steps.map(DVec3::normalize_or_zero);
        self.steps.iter().all(finite) && finite(&self.origin) && x.cross(y).dot(z).abs() > 1e-6
    }

    fn point(&self, index: DVec3) -> DVec3 {
        self.steps[0] * index.x + self.steps[1] * index.y + self.steps[2] * index.z + self.origin
    }

    fn affine(&self, unit: Unit, warnings: &mut Warnings) -> Affine {
        let steps = self.steps.map(|s| Some(lps_from_ras(s)));
        grid::affine(steps, lps_from_ras(self.origin), Space::Patient, unit, warnings)
    }
}

pub(super) fn affine(
    header: &Header,
    dims: [usize; 3],
    unit: Unit,
    facts: &mut Facts,
    warnings: &mut Warnings,
) -> Affine {
    let check = |name: &str, found: Option<Transform>, warnings: &mut Warnings| {
        if found.is_some_and(|t| !t.usable()) {
            warnings.say(format!("the {name} is degenerate and is ignored"));
            return None;
        }
        found
    };
    let sform = check("sform", sform(header), warnings);
    let qform = check("qform", qform(header, warnings), warnings);
    if let (Some(s), Some(q)) = (&sform, &qform) {
        let apart = distance(s, q, dims);
        let shortest = s.steps.iter().map(|v| v.length()).fold(f64::INFINITY, f64::min);
        if apart > AGREEMENT * shortest {
            warnings.say(format!(
                "sform ({}) and qform ({}) place the volume up to {apart:.3} apart; the sform is taken",
                code_name(header.sform_code),
                code_name(header.qform_code)
            ));
        }
    }
    if let Some(sform) = sform {
        facts.add("space", format!("sform, {}", code_name(header.sform_code)));
        return sform.affine(unit, warnings);
    }
    if let Some(qform) = qform {
        facts.add("space", format!("qform, {}", code_name(header.qform_code)));
        return qform.affine(unit, warnings);
    }
    facts.add("space", "not given");
    warnings.say("the header gives no orientation (sform and qform codes are 0): only its spacing is taken");
    let spacing = spacings(header, warnings);
    let steps = [0, 1, 2].map(|i| Some(DVec3::AXES[i] * spacing[i]));
    grid::affine(steps, DVec3::ZERO, Space::Unknown, unit, warnings)
}

fn sform(header: &Header) -> Option<Transform> {
    if header.sform_code <= 0 {
        return None;
    }
    let column = |c: usize| DVec3::from_array(header.rows.map(|row| row[c]));
    Some(Transform { steps: [column(0), column(1), column(2)], origin: column(3) })
}

fn qform(header: &Header, warnings: &mut Warnings) -> Option<Transform> {
    if header.qform_code <= 0 {
        return None;
    }
    let [b, c, d] = header.quaternion;
    // Rounding may leave a little more than 1; then the rotation is by a half turn.
    let rest = 1.0 - (b * b + c * c + d * d);
    let (a, [b, c, d]) = if rest < 1e-7 {
        let length = (b * b + c * c + d * d).sqrt();
        (0.0, [b / length, c / length, d / length])
    } else {
        (rest.sqrt(), [b, c, d])
    };
    let rotation = DMat3::from_cols(
        DVec3::new(a * a + b * b - c * c - d * d, 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)),
        DVec3::new(2.0 * (b * c - a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d + a * b)),
        DVec3::new(2.0 * (b * d + a * c), 2.0 * (c * d - a * b), a * a + d * d - b * b - c * c),
    );
    let [x, y, z] = spacings(header, warnings);
    let handed = if header.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    Some(Transform {
        steps: [rotation.x_axis * x, rotation.y_axis * y, rotation.z_axis * (z * handed)],
        origin: DVec3::from_array(header.offset),
    })
}

/// The spacings, positive; of axes that the file does not have, 1 where it says nothing useful.
fn spacings(header: &Header, warnings: &mut Warnings) -> [f64; 3] {
    [0, 1, 2].map(|i| {
        let declared = header.pixdim[i + 1];
        if (i as i64) < header.dim[0] {
            if declared < 0.0 {
                warnings.say(format!("the spacing along {} is negative: its size is taken", grid::AXES[i]));
            }
            usable_spacing(declared.abs(), i, warnings)
        } else if declared > 0.0 && declared.is_finite() {
            declared
        } else {
            1.0
        }
    })
}

/// The greatest distance of a corner under two transforms.
fn distance(a: &Transform, b: &Transform, dims: [usize; 3]) -> f64 {
    let last = DVec3::from_array(dims.map(|n| (n - 1) as f64));
    (0..8)
        .map(|corner| {
            let pick = |axis: u32| if corner >> axis & 1 == 1 { last[axis as usize] } else { 0.0 };
            let index = DVec3::new(pick(0), pick(1), pick(2));
            a.point(index).distance(b.point(index))
        })
        .fold(0.0, f64::max)
}

fn code_name(code: i64) -> String {
    match code {
        1 => "scanner".into(),
        2 => "aligned to another scan".into(),
        3 => "Talairach".into(),
        4 => "MNI 152".into(),
        5 => "template".into(),
        _ => format!("code {code}"),
    }
}
