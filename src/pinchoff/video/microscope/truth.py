"""The truth behind a drawn clip, from the outlines it was drawn from."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.video.contact import first_contact, rest_begins
from pinchoff.video.encounters import (
    CLIP_ENDED,
    CONTACT_DISTANCE_UM,
    CUT_BY_FRAME,
    RELEASE,
    Encounter,
    gap_to_circle,
    thinnest_neck,
)
from pinchoff.video.microscope.appearance import Microscope
from pinchoff.video.microscope.scenes import Scene

Floats = NDArray[np.float64]

_SPACING_PX = 0.5  # between the points on which a neck is measured


def scene_encounters(
    scene: Scene,
    microscope: Microscope,
    frame_count: int,
    contact_distance_um: float | None = None,
) -> list[Encounter]:
    """Return every collision of a drawn clip, in the order of their contacts.

    Parameters
    ----------
    scene : Scene
    microscope : Microscope
    frame_count : int
        Frames of the clip.
    contact_distance_um : float, optional
        A droplet whose outline comes this near to an obstacle is in contact; by default it is so
        where the gap stops closing, as for droplets that are measured.

    Returns
    -------
    list of Encounter
        One for each passage whose droplet touched its obstacle between the first and the last
        frame. Not accepted are those that the frame cuts or that the clip's end cuts short.

    Examples
    --------
    >>> from pinchoff import Parameters
    >>> from pinchoff.video.encounters import Laboratory
    >>> from pinchoff.video.microscope import Microscope, lane_scene, passage_of
    >>> camera = Microscope(width=480, height=300)
    >>> laboratory = Laboratory(
    ...     obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
    ... )
    >>> run = passage_of(Parameters(simulation_capillary_number=25), camera, laboratory)
    >>> scene, frame_count = lane_scene([run], camera)
    >>> [each.outcome for each in scene_encounters(scene, camera, frame_count)]
    ['broke']
    """
    lookers = (_Looker(scene, number, microscope) for number in range(len(scene.passages)))
    seen = (looker.encounter(frame_count, contact_distance_um) for looker in lookers)
    found = [encounter for encounter in seen if encounter is not None]
    return sorted(found, key=lambda each: (each.contact_frame, each.track_id))


class _Looker:
    """Follow one passage through the frames."""

    def __init__(self, scene: Scene, number: int, look: Microscope) -> None:
        self._passage, self._number, self._look = scene.passages[number], number, look
        self._circle: Floats = self._passage.obstacles[0]
        self._obstacle_id = int(np.argmin(np.abs(scene.obstacles - self._circle).sum(axis=1)))

    def encounter(self, frame_count: int, distance_um: float | None) -> Encounter | None:
        fps, start = self._look.fps, self._passage.start_s
        end = start + float(self._passage.outlines.times[-1]) * self._passage.unit_s
        frames = range(max(0, math.floor(start * fps)), min(frame_count, math.ceil(end * fps) + 1))
        contact = self._contact(frames, distance_um)
        if not contact:  # none, or in contact when first seen
            return None
        return self._followed(contact, frames[-1], whole=frames[-1] < frame_count - 1)

    def _contact(self, frames: range, distance_um: float | None) -> int | None:
        """Return the frame of first contact; None if there is none."""
        bound = CONTACT_DISTANCE_UM if distance_um is None else distance_um
        bound /= self._look.pixel_size_um
        gaps: list[float] = []
        for frame in frames:
            droplets = self._droplets(frame)
            if len(droplets) != 1:
                break
            gaps.append(gap_to_circle(droplets[0], self._circle))
            if distance_um is not None and gaps[-1] <= bound:
                return frame
            if distance_um is None and rest_begins(gaps, bound) is not None:
                break
        if distance_um is not None or not gaps or min(gaps) > bound:
            return None
        return frames[first_contact(gaps, bound, 1.0)]

    def _droplets(self, frame: float) -> list[Floats]:
        return [r for _, r in self._passage.droplets_at(frame / self._look.fps)]

    def _followed(self, contact: int, last: int, whole: bool) -> Encounter:
        px, fps = self._look.pixel_size_um, self._look.fps
        neck = breakup_neck = breakup = math.nan
        daughters = (math.nan, math.nan)
        shape, end, cut = 1.0, contact, False
        for frame in range(contact, last + 1):
            droplets = self._droplets(frame)
            end = frame
            cut = cut or any(self._is_cut(outline) for outline in droplets)
            if len(droplets) > 1:
                breakup = frame
                daughters = (_core.area(droplets[0]) * px**2, _core.area(droplets[1]) * px**2)
                break
            shape = max(shape, _core.shape_parameter(droplets[0]))
            breakup_neck = thinnest_neck(densified(droplets[0], _SPACING_PX))[0] * px
            neck = float(np.fmin(neck, breakup_neck))
            if gap_to_circle(droplets[0], self._circle) > RELEASE * self._circle[2]:
                break
        broke = not math.isnan(breakup)
        ended = not broke and not whole and end == last
        return Encounter(
            obstacle=tuple((self._circle * px).tolist()),
            outline=self._droplets(contact)[0] * px,
            velocity=self._velocity(contact),
            contact_frame=contact,
            end_frame=end,
            contact_time_s=contact / fps,
            outcome="broke" if broke else "captured" if ended else "slipped",
            breakup_frame=breakup,
            breakup_time_s=breakup / fps,
            daughter_areas=daughters,
            neck=neck,
            breakup_neck=breakup_neck if broke else math.nan,
            maximum_shape_parameter=shape,
            reject_reason=CUT_BY_FRAME if cut else CLIP_ENDED if ended else "",
            track_id=self._number,
            obstacle_id=self._obstacle_id,
        )

    def _velocity(self, frame: int) -> tuple[float, float]:
        """Return the velocity of the centre of mass as the run has it, mm/s."""
        step = 0.05  # frames
        before, after = (
            np.array(_core.centroid(self._droplets(frame + shift)[0])) for shift in (-step, step)
        )
        scale = self._look.fps / (2.0 * step) * self._look.pixel_size_um * 1e-3
        vx, vy = ((after - before) * scale).tolist()
        return vx, vy

    def _is_cut(self, outline: Floats) -> bool:
        low, high = outline.min(axis=0), outline.max(axis=0)
        return bool(np.any(low < -0.5) or np.any(high > np.array(self._look.size) - 0.5))


def densified(outline: Floats, spacing: float) -> Floats:
    """Return the same polygon, (n, 2), with points on its edges no farther apart than a spacing."""
    closed = np.vstack([outline, outline[:1]])
    steps = np.diff(closed, axis=0)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))])
    count = max(3, math.ceil(arc[-1] / spacing))
    where = np.linspace(0.0, arc[-1], count, endpoint=False)
    return np.column_stack([np.interp(where, arc, closed[:, axis]) for axis in (0, 1)])
