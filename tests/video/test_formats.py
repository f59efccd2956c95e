"""What cameras and ImageJ write comes out right, or is refused by name.

Files are made by other writers (tifffile, OpenCV, FFmpeg through PyAV) and, where they are there,
taken from the collection of inputs that were once misread.
"""

from __future__ import annotations

import struct
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType, SimpleNamespace

import av
import cv2
import numpy as np
import pytest
import tifffile

from pinchoff.support.errors import InputError
from pinchoff.video.formats.selection import frame_range
from pinchoff.video.formats.whitepoint import range_of, to_bytes
from pinchoff.video.reading import Clip
from pinchoff.video.scale import clip_of, described, scaled
from pinchoff.video.settings import VideoSettings

MISREAD = Path(__file__).parents[3] / "shared" / "failing"

HEIGHT, WIDTH = 48, 64


def ramp(number: int = 0) -> np.ndarray:
    """Return a picture from 0 to 1 whose corner tells its number."""
    image = np.linspace(0.0, 1.0, WIDTH)[None, :].repeat(HEIGHT, axis=0)
    image[:8, :8] = number / 16
    return image


def stack(count: int = 5, white: float = 255, kind: type = np.uint8) -> np.ndarray:
    return np.stack([(ramp(number) * white).astype(kind) for number in range(count)])


def shows_ramp(frame, tolerance: float = 1.2) -> bool:
    """Return whether a frame is `ramp` with its own number, from black to white."""
    expected = ramp(frame.number) * 255
    return frame.luma.shape == expected.shape and np.abs(frame.luma - expected).max() <= tolerance


def read(path, **how):
    clip = Clip(Path(path), **how)
    return clip, list(clip.frames())


@pytest.fixture
def misread():
    """Function name -> path of an input that was once misread."""
    if not MISREAD.is_dir():
        pytest.skip("the collection of misread inputs is not there")
    return lambda name: MISREAD / name


# What was once misread


@pytest.fixture
def truth(misread):
    """The frames that all of the collection's clips show."""
    return [f.luma.astype(float) for f in Clip(misread("imagej_1000fps.tif")).frames()]


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [
        ("imagej_one_ifd.tif", 0),
        ("u12_dark_first_frame.tif", 1),
        ("gray16_of_12_bits.mkv", 1),
        ("two_channels.tif", 0),
        ("folder_with_background", 0),
        ("float_0_1.tif", 1.1),
    ],
)
def test_misread_once_is_right_now(misread, truth, name, tolerance):
    _, found = read(misread(name))
    assert [frame.number for frame in found] == list(range(12))
    compared = found[1:] if name.startswith("u12") else found
    for frame in compared:
        assert np.abs(frame.luma - truth[frame.number]).max() <= tolerance


def test_dark_first_frame_stays_dark(misread, truth):
    _, found = read(misread("u12_dark_first_frame.tif"))
    assert found[0].luma.mean() == pytest.approx(0.2 * truth[0].mean(), rel=0.01)


def test_wide_and_narrow_numbers(misread, truth):
    _, wide = read(misread("uint32.tif"))
    for frame in wide:  # 18 bits are filled, so that white is not reached
        share = frame.luma / np.maximum(truth[frame.number], 1.0)
        assert share.std() < 0.01
        assert 0.9 < share.mean() < 1.0
    _, narrow = read(misread("one_bit.tif"))
    assert {0, 255} == set(np.unique(np.stack([frame.luma for frame in narrow])).tolist())


def test_folder_with_gaps_keeps_time(misread, truth):
    clip, found = read(misread("folder_with_gaps"), fps=100.0)
    assert [frame.number for frame in found] == [0, 1, 3, 4, 6, 7, 9, 10]
    assert [f.time_s for f in found] == pytest.approx([f.number / 100 for f in found])
    for frame in found:
        assert np.array_equal(frame.luma, truth[frame.number])
    assert "3 of 11 pictures are missing" in clip.about.notes[0]


def test_background_is_named(misread):
    assert "background.png" in Clip(misread("folder_with_background")).about.notes[0]


def test_rotated_film_stands_upright(misread):
    clip, found = read(misread("rotated90.mp4"))
    assert clip.size == (256, 320)
    assert found[0].luma.shape == (320, 256)
    assert found[0].chroma.shape == (2, 160, 128)
    with av.open(str(misread("rotated90.mp4"))) as container:
        stored = next(container.decode(video=0)).to_ndarray(format="gray")
    # A matrix of -90 degrees turns clockwise: the stored top left comes to the top right.
    turned = np.rot90(stored, -1).astype(float)
    ours = found[0].luma.astype(float)
    assert np.corrcoef(turned.ravel(), ours.ravel())[0, 1] > 0.99
    assert np.corrcoef(turned[::-1].ravel(), ours.ravel())[0, 1] < 0.9


def test_raw_stream_wants_a_rate(misread, refused):
    path = misread("no_timestamps_60fps.h264")
    refused("fps", Clip, path)
    _, found = read(path, fps=60.0)
    assert [frame.time_s for frame in found[:3]] == pytest.approx([0, 1 / 60, 2 / 60])


def test_values_that_are_no_numbers(misread):
    clip, (frame,) = read(misread("damaged/nan.tif"))
    assert "1 values are no numbers" in clip.warning
    assert frame.luma.dtype == np.uint8


# TIFF as others write it


@pytest.mark.parametrize(("unit", "size"), [("um", 5.28), ("mm", 5.28e-3), ("micron", 5.28)])
def test_scale_of_imagej(tmp_path, unit, size):
    path = tmp_path / "a.tif"
    metadata = {"axes": "TYX", "finterval": 0.002, "unit": unit}
    resolution = (1 / size, 1 / size)
    tifffile.imwrite(path, stack(), imagej=True, metadata=metadata, resolution=resolution)
    clip, found = read(path)
    assert clip.about.fps == pytest.approx(500.0)
    assert clip.about.pixel_size_um == pytest.approx(5.28, rel=1e-4)
    assert [frame.time_s for frame in found] == pytest.approx([0.002 * k for k in range(5)])
    assert all(map(shows_ramp, found))


def test_scale_of_ome(tmp_path):
    path = tmp_path / "a.ome.tif"
    metadata = {
        "axes": "TCYX",
        "TimeIncrement": 4.0,
        "TimeIncrementUnit": "ms",
        "PhysicalSizeX": 650.0,
        "PhysicalSizeXUnit": "nm",
        "PhysicalSizeY": 650.0,
        "PhysicalSizeYUnit": "nm",
        "Channel": {"Name": ["dye", "bright field"]},
    }
    both = np.stack([255 - stack(), stack()], axis=1)
    tifffile.imwrite(path, both, ome=True, metadata=metadata)
    clip, found = read(path, channel="Bright field")
    assert clip.about.fps == pytest.approx(250.0)
    assert clip.about.pixel_size_um == pytest.approx(0.65)
    assert len(found) == 5
    assert all(map(shows_ramp, found))
    first, (frame, *_) = read(path)
    assert frame.luma[20, 0] == 255
    assert "2 channels, dye, bright field: the first is measured" in first.about.notes[0]
    _, (frame, *_) = read(path, channel="0")
    assert frame.luma[20, 0] == 255
    with pytest.raises(InputError, match="channel must be one of dye, bright field; got 2"):
        Clip(path, channel="2")


def test_dots_an_inch_are_no_scale(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", stack(), resolution=(72, 72), resolutionunit="INCH")
    assert Clip(tmp_path / "a.tif").about.pixel_size_um is None


@pytest.mark.parametrize("white", [255, 1023, 4095, 16383, 65535])
def test_bits_that_are_filled_anywhere(tmp_path, white):
    """The deepest frame tells, wherever it stands; all frames share its white."""
    pages = stack(4, white, np.uint16)
    pages[:3] //= 3
    tifffile.imwrite(tmp_path / "a.tif", pages, photometric="minisblack")
    _, found = read(tmp_path / "a.tif")
    assert shows_ramp(found[3])
    assert np.abs(found[0].luma[20] - ramp()[20] * 85).max() <= 1.2


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.int16, np.uint32, np.int32])
def test_other_numbers(tmp_path, kind):
    pages = stack(3, 1.0 if np.dtype(kind).kind == "f" else 4095, kind)
    tifffile.imwrite(tmp_path / "a.tif", pages, photometric="minisblack")
    assert all(map(shows_ramp, read(tmp_path / "a.tif")[1]))


def test_negative_values_reach_from_black():
    pages = [np.array([[-1.0, 0.0, 1.0, 3.0]], np.float32)]
    values = range_of(pages)
    assert values == (-1.0, 14.0)  # four bits hold 0 to 4
    assert to_bytes(pages[0], values).tolist() == [[0, 17, 34, 68]]


def test_palette_and_white_that_is_zero(tmp_path):
    grey = np.arange(256, dtype=np.uint16) * 257
    backwards = np.stack([grey[::-1]] * 3)
    tifffile.imwrite(tmp_path / "p.tif", 255 - stack(2), photometric="palette", colormap=backwards)
    assert all(map(shows_ramp, read(tmp_path / "p.tif")[1]))
    tifffile.imwrite(tmp_path / "w.tif", 255 - stack(2), photometric="miniswhite")
    assert all(map(shows_ramp, read(tmp_path / "w.tif")[1]))


@pytest.mark.parametrize("planar", ["contig", "separate"])
def test_colours_side_by_side_or_in_planes(tmp_path, planar):
    colour = np.zeros((3, HEIGHT, WIDTH, 3), np.uint8)
    colour[..., 0] = stack(3)
    data = np.moveaxis(colour, -1, 1) if planar == "separate" else colour
    tifffile.imwrite(tmp_path / "a.tif", data, photometric="rgb", planarconfig=planar)
    clip, found = read(tmp_path / "a.tif", channel="red")
    assert len(found) == 3
    assert clip.about.channels == ("red", "green", "blue")
    assert all(map(shows_ramp, found))
    _, plain = read(tmp_path / "a.tif")
    assert plain[0].chroma[1].max() > 200


@pytest.mark.parametrize(
    "how",
    [
        {"bigtiff": True},
        {"compression": "lzw"},
        {"compression": "zlib", "predictor": True},
        {"compression": "packbits"},
        {"compression": "jpeg", "compressionargs": {"level": 98}},
        {"tile": (16, 16)},
        {"rowsperstrip": 5},
        {"byteorder": ">"},
    ],
    ids=str,
)
def test_layouts(tmp_path, how):
    tifffile.imwrite(tmp_path / "a.tif", stack(), photometric="minisblack", **how)
    _, found = read(tmp_path / "a.tif")
    assert len(found) == 5
    assert all(
        shows_ramp(frame, 30 if how.get("compression") == "jpeg" else 1.2) for frame in found
    )


def test_pages_appended_one_by_one(tmp_path):
    with tifffile.TiffWriter(tmp_path / "a.tif") as writer:
        for page in stack():
            writer.write(page, contiguous=False, photometric="minisblack")
    assert all(map(shows_ramp, read(tmp_path / "a.tif")[1]))


def test_slices_are_taken_for_frames_with_a_word(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", stack(), imagej=True, metadata={"axes": "ZYX"})
    clip, found = read(tmp_path / "a.tif")
    assert len(found) == 5
    assert clip.about.notes == ("its 5 slices (Z) are taken for frames in time",)


def test_depth_and_time_are_refused(tmp_path, refused):
    both = np.stack([stack(), stack()], axis=1)
    tifffile.imwrite(tmp_path / "a.tif", both, imagej=True, metadata={"axes": "TZYX"})
    refused(str(tmp_path / "a.tif"), Clip, tmp_path / "a.tif")


def test_stack_that_breaks_off(tmp_path):
    """What is there is read; of the rest there is a word."""
    tifffile.imwrite(tmp_path / "a.tif", stack(), imagej=True, metadata={"axes": "TYX"})
    data = (tmp_path / "a.tif").read_bytes()
    (tmp_path / "a.tif").write_bytes(data[: len(data) - HEIGHT * WIDTH - 100])
    clip, found = read(tmp_path / "a.tif")
    assert [frame.number for frame in found] == [0]
    assert clip.about.notes == ("it says that it holds 5 pictures: 1 can be read",)


def test_pages_that_are_lost_are_told(tmp_path):
    """Without a count in its tags only the list of pages tells that there were more."""
    tifffile.imwrite(tmp_path / "a.tif", stack(), photometric="minisblack", metadata=None)
    assert Clip(tmp_path / "a.tif").about.notes == ()
    data = (tmp_path / "a.tif").read_bytes()
    (tmp_path / "a.tif").write_bytes(data[: len(data) // 2])
    assert "breaks off" in Clip(tmp_path / "a.tif").about.notes[0]


@pytest.mark.parametrize("kept", [300, 600, 1500])
@pytest.mark.parametrize(
    "how", [{}, {"metadata": None}, {"imagej": True}, {"bigtiff": True}], ids=str
)
def test_stack_cut_within_its_first_picture_is_refused(tmp_path, how, kept):
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, stack(), photometric="minisblack", **how)
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(InputError):
        read(path)


def test_damaged_page_costs_itself_only(tmp_path, capfd):
    tifffile.imwrite(tmp_path / "a.tif", stack(), compression="zlib", photometric="minisblack")
    with tifffile.TiffFile(tmp_path / "a.tif") as file:
        start = file.pages[2].dataoffsets[0]
    data = bytearray((tmp_path / "a.tif").read_bytes())
    data[start : start + 20] = bytes(20)
    (tmp_path / "a.tif").write_bytes(bytes(data))
    clip, found = read(tmp_path / "a.tif")
    assert [frame.number for frame in found] == [0, 1, 3, 4]
    assert "frame 2" in clip.warning
    assert capfd.readouterr() == ("", "")


# Films


def encoded(path, frames, pix_fmt, codec="ffv1", source="gray16le"):
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=50)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, pix_fmt
        for number, pixels in enumerate(frames):
            frame = av.VideoFrame.from_ndarray(pixels, format=source)
            frame.pts, frame.time_base = number, Fraction(1, 50)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


@pytest.mark.parametrize("white", [1023, 4095, 65535])
def test_bits_of_a_film(tmp_path, white):
    path = encoded(tmp_path / "a.mkv", stack(4, white, np.uint16), "gray16le")
    _, found = read(path)
    assert all(map(shows_ramp, found))


def test_deep_colour_film(tmp_path):
    grey = stack(3, 4095, np.uint16)
    colour = np.stack([grey] * 3, axis=-1)
    path = encoded(tmp_path / "a.mkv", colour, "gbrp16le", source="rgb48le")
    _, found = read(path)
    assert all(map(shows_ramp, found))
    assert abs(int(found[0].chroma.max()) - 128) <= 1


def test_channel_of_a_film(tmp_path):
    colour = np.zeros((3, HEIGHT, WIDTH, 3), np.uint8)
    colour[..., 1] = stack(3)
    path = encoded(tmp_path / "a.mkv", colour, "bgr0", source="rgb24")
    _, found = read(path, channel="green")
    assert found[0].chroma is None
    assert all(map(shows_ramp, found))


@pytest.mark.parametrize(
    ("matrix", "shown"),
    [
        ((1, 0, 0, 1), lambda image: image),
        ((0, 1, -1, 0), lambda image: np.rot90(image, -1)),
        ((-1, 0, 0, -1), lambda image: np.rot90(image, 2)),
        ((0, -1, 1, 0), lambda image: np.rot90(image, 1)),
        ((-1, 0, 0, 1), lambda image: image[:, ::-1]),
        ((1, 0, 0, -1), lambda image: image[::-1]),
        ((0, 1, 1, 0), lambda image: image.T),
    ],
)
def test_every_display_matrix(tmp_path, matrix, shown):
    """The matrix in the header says where the stored axes point; it is patched into the file."""
    path = tmp_path / "a.mp4"
    encoded(path, stack(2), "yuv420p", "libx264", source="gray")
    data = path.read_bytes()
    a, b, c, d = matrix
    track = data.index(b"tkhd")
    start = track + 4 + 40  # version 0: the matrix stands 40 bytes into the box
    nine = struct.pack(">9i", a << 16, b << 16, 0, c << 16, d << 16, 0, 0, 0, 1 << 30)
    assert data[start : start + 4] == struct.pack(">i", 1 << 16)
    path.write_bytes(data[:start] + nine + data[start + 36 :])
    _, (first, *_) = read(path)
    expected = shown(ramp() * 219 + 16)
    assert first.luma.shape == expected.shape
    assert np.abs(first.luma - expected).mean() < 4
    assert first.chroma.shape == (2, expected.shape[0] // 2, expected.shape[1] // 2)


def test_film_with_a_damaged_middle(tmp_path):
    """What is damaged costs its own frame; the others keep their numbers and times."""
    path = encoded(tmp_path / "a.mkv", stack(12), "yuvj420p", "mjpeg", source="gray")
    data = bytearray(path.read_bytes())
    with av.open(str(path)) as container:
        packets = [bytes(packet) for packet in container.demux(video=0) if packet.size]
    start, length = data.index(packets[5]), len(packets[5])
    data[start + length // 3 : start + length - 4] = bytes(length - length // 3 - 4)
    path.write_bytes(bytes(data))
    clip, found = read(path)
    assert [frame.number for frame in found] == [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11]
    assert all(f.time_s == pytest.approx(f.number / 50, abs=1e-3) for f in found)
    assert "damaged after frame 4" in clip.warning


# Folders


def pictures(folder, names, white=255, kind=np.uint8):
    folder.mkdir(exist_ok=True)
    for number, name in enumerate(names):
        cv2.imwrite(str(folder / name), (ramp(number) * white).astype(kind))
    return folder


def test_sixteen_bits_in_pictures(tmp_path):
    folder = pictures(tmp_path / "f", [f"a{k}.png" for k in range(4)], 4095, np.uint16)
    assert all(map(shows_ramp, read(folder)[1]))


def test_other_sizes_and_other_names_are_left_out(tmp_path):
    folder = pictures(tmp_path / "f", [f"a{k}.png" for k in range(5)])
    cv2.imwrite(str(folder / "a5.png"), np.zeros((30, 40), np.uint8))
    cv2.imwrite(str(folder / "overview.jpg"), np.zeros((30, 40), np.uint8))
    (folder / "notes.txt").write_text("no picture")
    (folder / ".hidden.png").write_bytes(b"")
    clip, found = read(folder)
    assert [frame.number for frame in found] == list(range(5))
    assert clip.about.notes == ("not of the sequence and left out: overview.jpg",)
    assert "a5.png (40 × 30 pixels)" in clip.warning


def test_the_number_that_counts(tmp_path):
    """Not the time of day, nor a constant, nor the milliseconds."""
    names = [
        f"Basler_2024_12h{3 + k // 2}m{(40 + 30 * k) % 60}s_{k:04d}_{17 * k}ms.png"
        for k in (0, 1, 3)
    ]
    _, found = read(pictures(tmp_path / "f", names), fps=10.0)
    assert [frame.number for frame in found] == [0, 1, 3]


def test_numbers_that_are_dates(tmp_path):
    names = [f"{20240102150312000 + 17 * k}.png" for k in range(3)]
    dates = [names[0], "20250102150312000.png", "20260102150312000.png"]
    clip, found = read(pictures(tmp_path / "f", dates))
    assert [frame.number for frame in found] == [0, 1, 2]
    assert "count no frames" in clip.about.notes[0]


def test_two_channels_in_one_folder_are_refused(tmp_path, refused):
    names = [f"t{t}_c{c}.png" for t in range(3) for c in range(2)]
    folder = pictures(tmp_path / "f", names)
    refused(str(folder), Clip, folder)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp", ".tif"])
def test_one_damaged_picture_costs_itself_only(tmp_path, capfd, suffix):
    folder = pictures(tmp_path / "f", [f"a{k}{suffix}" for k in range(4)])
    whole = (folder / f"a2{suffix}").read_bytes()
    (folder / f"a2{suffix}").write_bytes(whole[: len(whole) // 2])
    clip, found = read(folder)
    assert [frame.number for frame in found] == [0, 1, 3]
    assert clip.warning.startswith(f"could not be read and are left out: a2{suffix} (")
    assert found[2].time_s == pytest.approx(3 / 60)
    assert capfd.readouterr() == ("", "")


def test_grey_and_colour_mixed(tmp_path):
    folder = pictures(tmp_path / "f", [f"a{k}.png" for k in range(5)])
    cv2.imwrite(str(folder / "a2.png"), np.stack([ramp(2) * 255] * 3, axis=-1).astype(np.uint8))
    clip, found = read(folder)
    assert all(map(shows_ramp, found))
    assert {frame.chroma is None for frame in found} == {True}
    assert "colour" in clip.warning


# Parts of clips


def test_frames_keep_numbers_and_times(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", stack(10), photometric="minisblack")
    clip, found = read(tmp_path / "a.tif", fps=10.0, frames_wanted=frame_range("2:8:3"))
    assert [frame.number for frame in found] == [2, 5]
    assert [frame.time_s for frame in found] == pytest.approx([0.2, 0.5])
    assert clip.frame_count == 2
    assert all(map(shows_ramp, found))


@pytest.mark.parametrize("text", ["", "3", "5:5", "0:10:0", "-1:4", "a:b", "1:2:3:4"])
def test_ranges_without_frames_are_refused(text, refused):
    refused("frames", frame_range, text)
    refused("frames", lambda: VideoSettings(frames=text))


def test_crop(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", stack(2), photometric="minisblack")
    clip, (frame, *_) = read(tmp_path / "a.tif", crop=(10, 4, 21, 9))
    assert clip.size == (21, 9)
    assert np.array_equal(frame.luma, stack(1)[0, 4:13, 10:31])
    with pytest.raises(InputError, match="crop must be within 64 × 48 pixels"):
        Clip(tmp_path / "a.tif", crop=(50, 4, 21, 9))
    with pytest.raises(InputError, match="crop must be left, top, width and height"):
        VideoSettings(crop=(1, 4, 21, 9))


# What is refused


@pytest.mark.parametrize(
    ("name", "format_"),
    [("a.seq", "StreamPix"), ("a.mraw", "Photron"), ("a.lif", "Leica"), ("a.sif", "Andor")],
)
def test_formats_that_are_refused_by_name(tmp_path, name, format_):
    (tmp_path / name).write_bytes(b"whatever")
    with pytest.raises(InputError, match=format_):
        Clip(tmp_path / name)


@pytest.mark.parametrize(
    "suffix", [".tif", ".png", ".mp4", ".nd2", ".czi", ".jpg", ".avi", ".cine"]
)
@pytest.mark.parametrize("content", [b"", b"II*\0", b"\x89PNG\r\n", b"no film" * 300])
def test_damaged_files_are_refused(tmp_path, suffix, content, capfd):
    for module in ("nd2", "czifile"):
        pytest.importorskip(module)
    path = tmp_path / f"a{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError):
        read(path)
    assert capfd.readouterr() == ("", "")


def test_a_damaged_picture_is_no_folder(tmp_path):
    (tmp_path / "a.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match="must be a readable picture; got "):
        Clip(tmp_path / "a.png")


def test_absurd_sizes_are_refused(tmp_path, refused):
    tifffile.imwrite(tmp_path / "a.tif", np.zeros((16, 16), np.uint8))
    with tifffile.TiffFile(tmp_path / "a.tif", mode="r+") as file:
        for tag in ("ImageWidth", "ImageLength"):
            file.pages[0].tags[tag].overwrite(60000)
    refused(str(tmp_path / "a.tif"), Clip, tmp_path / "a.tif")
    cv2.imwrite(str(tmp_path / "b.png"), np.zeros((1, 1), np.uint8))
    refused(str(tmp_path / "b.png"), Clip, tmp_path / "b.png")


# Scale and rate


def test_scale_from_options_or_file(tmp_path):
    path = tmp_path / "a.tif"
    metadata = {"axes": "TYX", "finterval": 0.002, "unit": "um"}
    tifffile.imwrite(path, stack(), imagej=True, metadata=metadata, resolution=(0.5, 0.5))
    silent = VideoSettings()
    known, notes = scaled(clip_of(path, silent), silent)
    assert (known.pixel_size_um, notes) == (2.0, [])
    given = VideoSettings(pixel_size_um=2.5, fps=400)
    known, notes = scaled(clip_of(path, given), given)
    assert known.pixel_size_um == 2.5
    assert notes == [
        "the file says 2 µm a pixel: 2.5 is used, as given",
        "the file says 500 frames/s: 400 is used, as given",
    ]
    (line,) = described({"a": path}, silent)
    assert line == (
        "a: 5 frames of 64 × 48 pixels, 500 frames/s as the file says, 2 µm a pixel as the file "
        "says, 0.128 × 0.096 mm in view"
    )


def test_scale_that_nobody_says(tmp_path, refused):
    tifffile.imwrite(tmp_path / "a.tif", stack(), photometric="minisblack")
    silent = VideoSettings()
    refused("pixel_size", scaled, clip_of(tmp_path / "a.tif", silent), silent)
    given = VideoSettings(pixel_size_um=2.5)
    _, notes = scaled(clip_of(tmp_path / "a.tif", given), given)
    assert notes == ["the file says no frame rate: 60/s is assumed; give fps"]


# Microscopes' own files


class _StandIn:
    """What `nd2.ND2File` offers of a film in two channels; no writer of such files exists."""

    sizes = MappingProxyType({"T": 5, "C": 2, "Y": HEIGHT, "X": WIDTH})
    is_rgb = False
    experiment = (
        SimpleNamespace(
            type="TimeLoop",
            parameters=SimpleNamespace(periodMs=5.0, periodDiff=SimpleNamespace(avg=4.0)),
        ),
    )
    metadata = SimpleNamespace(
        channels=[SimpleNamespace(channel=SimpleNamespace(name=n)) for n in ("dye", "bright")]
    )

    def __init__(self, path):
        assert path.suffix == ".nd2"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def voxel_size(self):
        return SimpleNamespace(x=0.65)

    def read_frame(self, number):
        return np.stack([stack(5, 4095, np.uint16)[number] // 2, stack(5, 4095, np.uint16)[number]])


def test_nikon_files(tmp_path, monkeypatch):
    nd2 = pytest.importorskip("nd2")
    monkeypatch.setattr(nd2, "ND2File", _StandIn)
    (tmp_path / "a.nd2").touch()
    clip, found = read(tmp_path / "a.nd2", channel="bright")
    assert clip.about.pixel_size_um == 0.65
    assert clip.about.fps == pytest.approx(250.0)  # as taken, not as asked for
    assert len(found) == 5
    assert all(map(shows_ramp, found))
    assert "the first is measured" in Clip(tmp_path / "a.nd2").about.notes[0]
    monkeypatch.setattr(_StandIn, "sizes", {"T": 5, "P": 3, "Y": HEIGHT, "X": WIDTH})
    with pytest.raises(InputError, match="frames of one plane in time; got 3 along P"):
        Clip(tmp_path / "a.nd2")


def test_zeiss_files(tmp_path):
    """Written by the maker's own library, where that is there."""
    pytest.importorskip("czifile")
    czi = pytest.importorskip("pylibCZIrw.czi")
    path = tmp_path / "a.czi"
    with czi.create_czi(str(path)) as file:
        for number, page in enumerate(stack(5, 4095, np.uint16)):
            for channel in (0, 1):
                plane = {"T": number, "C": channel, "Z": 0}
                file.write(data=page // (2 - channel), plane=plane)
        file.write_metadata(document_name="a", scale_x=0.65e-6, scale_y=0.65e-6)
    clip, found = read(path, channel="1")
    assert clip.about.pixel_size_um == pytest.approx(0.65)
    assert len(found) == 5
    assert all(map(shows_ramp, found))
