"""Pixel size and frame rate of a clip: from the options, or else from the file's own tags."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pinchoff.support.errors import InputError
from pinchoff.video.formats.selection import ALL_FRAMES, frame_range
from pinchoff.video.reading import DEFAULT_FPS, Clip
from pinchoff.video.settings import VideoSettings

_ALIKE = 0.01  # relative difference below which an option and a tag agree
_MOST_DESCRIBED = 12  # clips, each in a line


def clip_of(path: Path, settings: VideoSettings) -> Clip:
    """Return a clip with the part of it that is to be measured."""
    wanted = ALL_FRAMES if settings.frames is None else frame_range(settings.frames)
    return Clip(path, settings.fps, wanted, settings.crop, settings.channel)


def scaled(clip: Clip, settings: VideoSettings) -> tuple[VideoSettings, list[str]]:
    """Return the settings with the pixel's size known, and what the user should know of it all."""
    about, notes = clip.about, list(clip.about.notes)
    pixel_um, told = settings.pixel_size_um, about.pixel_size_um
    if pixel_um is None and told is None:
        rule, got = "given where the file does not say it", f"nothing for {clip.path}"
        raise InputError.of("pixel_size", rule, got, "write it like '5.28 um'")
    if pixel_um is not None and told is not None and abs(pixel_um / told - 1.0) > _ALIKE:
        notes.append(f"the file says {told:.4g} µm a pixel: {pixel_um:.4g} is used, as given")
    rated = about.fps is not None and not about.timed
    if rated and clip.fps and abs(clip.fps / (about.fps or 1.0) - 1.0) > _ALIKE:
        notes.append(f"the file says {about.fps:.6g} frames/s: {clip.fps:.6g} is used, as given")
    if _is_assumed(clip):
        notes.append(f"the file says no frame rate: {DEFAULT_FPS:g}/s is assumed; give fps")
    return settings.replace(pixel_size_um=pixel_um or told), notes


def overlay_fps(clip: Clip) -> float:
    """Return at how many frames a second an annotated clip is shown: no faster than one can see."""
    return min(clip.fps or clip.about.fps or DEFAULT_FPS, DEFAULT_FPS)


def _is_assumed(clip: Clip) -> bool:
    about = clip.about
    return not (clip.fps or about.fps or about.timed or about.count == 1)


def described(sources: Mapping[str, Path], settings: VideoSettings) -> list[str]:
    """Return a line for each clip: its frames, size, rate and scale, and where they come from."""
    lines = []
    for name, path in list(sources.items())[:_MOST_DESCRIBED]:
        try:
            clip = clip_of(path, settings)
            lines.append(f"{name}: {_in_words(clip, scaled(clip, settings)[0], settings)}")
        except Exception:
            continue  # whatever is wrong with it is told when its turn comes
    if len(sources) > _MOST_DESCRIBED:
        lines.append(f"and {len(sources) - _MOST_DESCRIBED} more clips")
    return lines


def _in_words(clip: Clip, known: VideoSettings, given: VideoSettings) -> str:
    about = clip.about
    count = "" if clip.frame_count is None else f"{clip.frame_count} frames of "
    width, height = clip.size
    if clip.fps:
        rate = f"{clip.fps:.6g} frames/s as given"
        if about.fps and abs(clip.fps / about.fps - 1.0) > _ALIKE:
            rate += f" (the file: {about.fps:.6g})"
    elif about.fps:
        rate = f"{about.fps:.6g} frames/s as the file says"
    else:
        rate = "times as in the file" if about.timed else f"{DEFAULT_FPS:g} frames/s assumed"
    pixel = known.pixel_size_um or 0.0
    origin = "as the file says" if given.pixel_size_um is None else "as given"
    view = f"{width * pixel * 1e-3:.3g} × {height * pixel * 1e-3:.3g} mm"
    return (
        f"{count}{width} × {height} pixels, {rate}, {pixel:.4g} µm a pixel {origin}, {view} in view"
    )
