"""One volume, written by programs that are not dotwork in every format that they know, gives one picture.

usage: independent_writers.py DOTWORK

Needs nibabel, SimpleITK, pydicom, pynrrd and tifffile. Files are drawn to tables of dots, which hold no file names, and
compared byte by byte. Spacings and origins are whole sixteenths, so that every format holds them exactly.

A file whose samples run the other way gives other triangles, and so other dots: there the ink of blocks is compared.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import nibabel
import nrrd
import numpy as np
import pydicom
import SimpleITK as sitk
import tifffile
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, ImplicitVRLittleEndian, RLELossless, generate_uid

SPACING = (1.25, 1.5, 1.75)
ORIGIN = (-20.0, -16.5, 8.25)


def volume():
    """A lump with a horn and a dent, unlike itself in every mirror; axes z, y, x, as numpy has them."""
    z, y, x = np.mgrid[0:30, 0:34, 0:38].astype(float)
    body = 900 * np.exp(-(((x - 18) / 9) ** 2 + ((y - 17) / 7) ** 2 + ((z - 14) / 8) ** 2))
    horn = 700 * np.exp(-(((x - 27) / 3) ** 2 + ((y - 12) / 3) ** 2 + ((z - 22) / 3) ** 2))
    dent = 500 * np.exp(-(((x - 12) / 4) ** 2 + ((y - 10) / 3) ** 2 + ((z - 9) / 3) ** 2))
    return np.clip(body + horn - dent, 0, 4000).round().astype(np.int16)


def image(data):
    made = sitk.GetImageFromArray(data)
    made.SetSpacing(SPACING)
    made.SetOrigin(ORIGIN)
    return made


def dicom(folder, data, syntax):
    """A CT series; the names of its files run against the positions of its slices."""
    folder.mkdir()
    study, series, frame = generate_uid(), generate_uid(), generate_uid()
    for k, pixels in enumerate(data):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = CTImageStorage
        meta.MediaStorageSOPInstanceUID = generate_uid()
        meta.TransferSyntaxUID = ExplicitVRLittleEndian if syntax == RLELossless else syntax
        path = folder / f"{99 - k:03}.dcm"
        ds = FileDataset(str(path), {}, file_meta=meta, preamble=b"\0" * 128)
        ds.SOPClassUID, ds.SOPInstanceUID = CTImageStorage, meta.MediaStorageSOPInstanceUID
        ds.StudyInstanceUID, ds.SeriesInstanceUID, ds.FrameOfReferenceUID = study, series, frame
        ds.Modality, ds.PatientID, ds.PatientName = "CT", "lump", "Lump"
        ds.SeriesNumber, ds.InstanceNumber = 1, 1
        ds.Rows, ds.Columns = pixels.shape
        ds.PixelSpacing = [SPACING[1], SPACING[0]]
        ds.SliceThickness = SPACING[2]
        ds.ImagePositionPatient = [ORIGIN[0], ORIGIN[1], ORIGIN[2] + k * SPACING[2]]
        ds.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
        ds.SamplesPerPixel, ds.PhotometricInterpretation = 1, "MONOCHROME2"
        ds.BitsAllocated, ds.BitsStored, ds.HighBit, ds.PixelRepresentation = 16, 16, 15, 1
        # Rescaled, so that whoever leaves that out is found: the values stored are 1024 higher.
        ds.RescaleIntercept, ds.RescaleSlope = -1024, 1
        ds.PixelData = (pixels + 1024).astype("<i2").tobytes()
        if syntax == RLELossless:
            ds.compress(RLELossless)
        ds.save_as(path, enforce_file_format=True)


def nifti(path, data, kind, big=False):
    # NIfTI's axes are x, y, z and its space is RAS.
    affine = np.diag([-SPACING[0], -SPACING[1], SPACING[2], 1.0])
    affine[:3, 3] = (-ORIGIN[0], -ORIGIN[1], ORIGIN[2])
    made = kind(data.transpose(2, 1, 0), affine)
    if big:
        made = kind(data.transpose(2, 1, 0), affine, made.header.as_byteswapped(">"))
    made.header.set_xyzt_units("mm")
    nibabel.save(made, path)


def write_all(folder, data):
    """The files, each in a folder of its own, under one name."""

    def place(name):
        inner = folder / name
        inner.mkdir()
        return inner

    for ending in ["nrrd", "nhdr", "mha", "mhd", "nii", "nii.gz", "hdr", "vtk"]:
        path = place(f"SimpleITK {ending}") / f"v.{ending}"
        sitk.WriteImage(image(data), str(path))
        yield path
    for ending in ["nrrd", "mha", "nii.gz"]:
        path = place(f"SimpleITK compressed {ending}") / f"v.{ending}"
        sitk.WriteImage(image(data), str(path), useCompression=True)
        yield path
    # Slices turned round: the file says so, and the picture must not.
    turned = sitk.Flip(image(data), [True, False, True])
    path = place("SimpleITK turned nrrd") / "v.nrrd"
    sitk.WriteImage(turned, str(path))
    yield path
    for name, kind, ending, big in [
        ("nibabel 1", nibabel.Nifti1Image, "nii", False),
        ("nibabel 1 gz", nibabel.Nifti1Image, "nii.gz", False),
        ("nibabel 1 pair", nibabel.Nifti1Pair, "hdr", False),
        ("nibabel 1 big endian", nibabel.Nifti1Image, "nii", True),
        ("nibabel 2", nibabel.Nifti2Image, "nii", False),
    ]:
        path = place(name) / f"v.{ending}"
        nifti(path, data, kind, big)
        yield path
    for encoding in ["raw", "gzip", "bzip2", "ascii"]:
        path = place(f"pynrrd {encoding}") / "v.nrrd"
        header = {
            "space": "left-posterior-superior",
            "space directions": np.diag(SPACING),
            "space origin": np.array(ORIGIN),
            "encoding": encoding,
        }
        nrrd.write(str(path), data.transpose(2, 1, 0), header)
        yield path
    for name, syntax in [
        ("explicit", ExplicitVRLittleEndian),
        ("implicit", ImplicitVRLittleEndian),
        ("RLE", RLELossless),
    ]:
        path = place(f"pydicom {name}") / "v"
        dicom(path, data, syntax)
        yield path


def write_unspaced(folder, data):
    """The formats that keep no spacing."""
    plain = sitk.GetImageFromArray(data)
    for name, write in [
        ("SimpleITK tif", lambda path: sitk.WriteImage(plain, str(path))),
        ("tifffile", lambda path: tifffile.imwrite(path, data, photometric="minisblack")),
        ("tifffile deflate", lambda path: tifffile.imwrite(path, data, photometric="minisblack", compression="zlib")),
        ("tifffile big", lambda path: tifffile.imwrite(path, data, photometric="minisblack", bigtiff=True)),
    ]:
        (folder / name).mkdir()
        path = folder / name / "v.tif"
        write(path)
        yield path
    (folder / "tifffile pages").mkdir()
    pages = folder / "tifffile pages" / "v"
    pages.mkdir()
    for k, page in enumerate(data):
        tifffile.imwrite(pages / f"{k}.tif", page, photometric="minisblack")
    yield pages


def dots(program, path, out):
    view = ["--up", "z", "--camera", "30,20", "--size", "400x400", "--stipples", "20000", "--set", "dot_size=4px"]
    command = [program, "render", str(path), "-o", str(out), *view, "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{path.parent.name}: {done.stderr}")
    return out.read_bytes()


def ink(table, block=80, size=400):
    """The dots' summed area in blocks of the page."""
    rows = np.genfromtxt(table.decode().splitlines(), delimiter=",", names=True, usecols=("x_px", "y_px", "radius_px"))
    n = size // block
    edges = np.arange(n + 1) * block
    return np.histogram2d(rows["y_px"], rows["x_px"], [edges, edges], weights=np.pi * rows["radius_px"] ** 2)[0]


def alike(a, b):
    """No block differs by more than 4 % of its area."""
    return np.abs(ink(a) - ink(b)).max() <= 0.04 * 80 * 80


def main():
    program = sys.argv[1]
    data = volume()
    differ = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for write in (write_all, write_unspaced):
            first = None
            for path in write(folder, data):
                table = dots(program, path, folder / "v.csv")
                first = first or (path.parent.name, table)
                turned = "turned" in path.parent.name
                same = alike(table, first[1]) if turned else table == first[1]
                rows = table.count(b"\n") - 1
                how = ("nearly as" if turned else "as") if same else "NOT as"
                print(f"{path.parent.name:28} {rows} dots, {how} {first[0]}")
                if not same or rows < 1000:
                    differ.append(path.parent.name)
    if differ:
        sys.exit(f"differ: {', '.join(differ)}")


main()
