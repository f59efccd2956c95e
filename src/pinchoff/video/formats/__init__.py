"""The formats of clips, a file each: what they say of themselves, and their pictures in sequence.

`opened` chooses by the name. A further format is one file with a `Source`, and a line there.
"""

from __future__ import annotations

from pathlib import Path

from pinchoff.support.errors import InputError
from pinchoff.video.formats.source import CHOICE, IMAGE_SUFFIXES, Source

STACK_SUFFIXES = (".tif", ".tiff", ".btf", ".tf8", ".tf2")
VIDEO_SUFFIXES = (
    *(".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".wmv", ".mts", ".m2ts"),
    *(".ts", ".3gp", ".gif", ".cine", ".h264", ".h265", ".hevc", ".mjpeg"),
    *(".nd2", ".czi"),
)

_BY_FIJI = "open it in Fiji and save it as TIFF"
_REFUSED = {
    ".seq": ("StreamPix sequence", "export it from StreamPix as AVI or TIFF"),
    ".mraw": ("Photron raw film", "export it from PFV4 as TIFF or AVI"),
    ".cihx": ("Photron header", "export the film from PFV4 as TIFF or AVI"),
    ".cih": ("Photron header", "export the film from PFV4 as TIFF or AVI"),
    ".raw": ("headerless raw film", "import it in Fiji (File > Import > Raw) and save it as TIFF"),
    ".lif": ("Leica image file", f"{_BY_FIJI}, one series a file"),
    ".lsm": ("Zeiss LSM stack", _BY_FIJI),
    ".oib": ("Olympus image file", _BY_FIJI),
    ".oif": ("Olympus image file", _BY_FIJI),
    ".oir": ("Olympus image file", _BY_FIJI),
    ".vsi": ("Olympus VSI image", _BY_FIJI),
    ".stk": ("MetaMorph stack", _BY_FIJI),
    ".ims": ("Imaris file", _BY_FIJI),
    ".sif": ("Andor SIF file", "export it from Solis as TIFF"),
    ".spe": ("Princeton SPE file", "export it from LightField as TIFF"),
    ".dv": ("DeltaVision file", _BY_FIJI),
    ".zvi": ("Zeiss ZVI file", _BY_FIJI),
    ".r3d": ("RED film", "transcode it with the maker's tool or FFmpeg"),
    ".zarr": ("Zarr array", "save it as OME-TIFF"),
    ".h5": ("HDF5 file", "save its frames as TIFF, with tifffile.imwrite for instance"),
    ".hdf5": ("HDF5 file", "save its frames as TIFF, with tifffile.imwrite for instance"),
    ".npy": ("NumPy array", "save it as TIFF with tifffile.imwrite"),
}


def opened(path: Path, channel: str | None = None) -> Source:
    """Return what reads a clip.

    Parameters
    ----------
    path : Path
        A film, a TIFF stack, a picture or a folder of pictures.
    channel : str, optional
        Which of several channels: its name, or its number from 0.

    Raises
    ------
    InputError
        Nothing is there, it cannot be read, or its format is none of these.
    """
    from pinchoff.video.formats import films, folders, microscopes, phantom, tiff

    if not path.exists():
        raise InputError.of(str(path), "an existing clip", "nothing there", CHOICE)
    suffix = path.suffix.lower()
    if suffix in _REFUSED:
        name, advice = _REFUSED[suffix]
        raise InputError.of(str(path), "of a format that is read here", f"a {name}", advice)
    if suffix in STACK_SUFFIXES and not path.is_dir():
        return tiff.TiffStack(path, channel)
    if suffix in IMAGE_SUFFIXES or path.is_dir():
        return folders.PictureFolder(path, channel)
    if suffix == ".nd2":
        return microscopes.NikonFile(path, channel)
    if suffix == ".czi":
        return microscopes.ZeissFile(path, channel)
    if suffix == ".cine":
        return phantom.opened_phantom(path, channel)
    return films.Film(path, channel)
