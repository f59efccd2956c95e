"""The strip of snapshots and the film: the right moments, one scale, nothing cut off."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

import pinchoff as po
from pinchoff.figures import style
from pinchoff.figures.movie import _Stage, write_movie
from pinchoff.figures.snapshots import snapshot_strip, write_snapshots
from pinchoff.studies.moments import collision_moments
from pinchoff.support import palette

BREAKING = po.Parameters(simulation_capillary_number=25, offset=0.02)
INTERVAL = 0.02


@pytest.fixture(scope="module")
def broken():
    return po.simulate(BREAKING, outlines=INTERVAL)


@pytest.fixture(scope="module")
def slipped():
    return po.simulate(BREAKING.replace(offset=0.15), outlines=INTERVAL)


def time_of(outlines, name):
    frames = {moment.name: moment.frame for moment in collision_moments(outlines)}
    return outlines.times[frames[name]]


def lines_of(axes, color):
    return [line for line in axes.lines if to_hex(line.get_color()) == color]


def test_moments_are_those_of_the_engine(broken):
    """What is read off the outlines agrees with what the engine saw between two frames."""
    outlines = broken.outlines
    names = [moment.name for moment in collision_moments(outlines)]
    assert names == ["approach", "contact", "deformation", "neck", "break-up", "after"]
    assert 0 <= time_of(outlines, "contact") - broken.contact_time < 1.5 * INTERVAL
    assert 0 <= broken.breakup_time - time_of(outlines, "neck") < 1.5 * INTERVAL
    assert 0 <= time_of(outlines, "break-up") - broken.breakup_time < 1.5 * INTERVAL


def test_slipping_droplet_shows_its_greatest_deformation(slipped):
    assert slipped.outcome == "slipped"
    outlines = slipped.outlines
    names = [moment.name for moment in collision_moments(outlines)]
    assert names == ["approach", "contact", "deformation", "most deformed", "passing", "after"]
    shown = outlines.measure().set_index("time")["shape_parameter"]
    assert shown[time_of(outlines, "most deformed")] == pytest.approx(
        slipped.maximum_shape_parameter, rel=0.01
    )


def test_droplet_that_never_touches_is_shown_as_it_passes():
    missed = po.simulate(BREAKING.replace(offset=2.0), outlines=INTERVAL)
    moments = collision_moments(missed.outlines)
    assert [moment.name for moment in moments] == [""] * 6
    x = [missed.outlines[m.frame][0].vertices[:, 0].mean() for m in moments]
    assert np.all(np.diff(x) > 0)
    assert x[0] < 0 < x[-1]
    assert np.abs(x).max() < 1.3


def test_panels_share_one_window_that_holds_every_droplet(broken):
    panels = snapshot_strip(broken.outlines)
    assert len(panels) == 6
    assert len({(panel.get_xlim(), panel.get_ylim()) for panel in panels}) == 1
    assert {panel.get_aspect() for panel in panels} == {1.0}
    for panel, moment in zip(panels, collision_moments(broken.outlines), strict=True):
        (low_x, high_x), (low_y, high_y) = panel.get_xlim(), panel.get_ylim()
        for droplet in broken.outlines[moment.frame]:
            x, y = droplet.vertices.T
            assert low_x < x.min() < x.max() < high_x
            assert low_y < y.min() < y.max() < high_y


def test_neck_is_drawn_at_its_true_length_and_the_centreline_through_the_obstacle(broken):
    panels = snapshot_strip(broken.outlines)
    assert [len(lines_of(panel, palette.NECK)) for panel in panels] == [0, 0, 0, 1, 0, 0]
    assert [len(lines_of(panel, palette.CENTRELINE)) for panel in panels] == [0, 1, 0, 0, 0, 0]
    ends = lines_of(panels[3], palette.NECK)[0].get_xydata()
    assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(broken.breakup_neck, rel=0.1)
    line = lines_of(panels[1], palette.CENTRELINE)[0]
    assert line.get_xy1() == (0.0, 0.0)
    slope = np.subtract(line.get_xy2(), line.get_xy1())
    contact = broken.contacts[0]
    assert slope[1] / slope[0] == pytest.approx(
        contact["velocity_y"] / contact["velocity_x"], abs=0.02
    )


def test_daughters_are_drawn_after_the_breakup(broken):
    panels = snapshot_strip(broken.outlines)
    drawn = [
        sum(len(c.get_paths()) for c in panel.collections if isinstance(c, PolyCollection))
        for panel in panels
    ]
    assert drawn == [1, 1, 1, 1, 2, 2]


def times_on(panels):
    """Time and unit above each panel."""
    labels = [panel.get_title(loc="left").removeprefix("$t$ = ").split() for panel in panels]
    return [(float(time), unit) for time, unit in labels]


def test_labels_are_in_t0_or_in_physical_units(broken, experiment):
    shown = snapshot_strip(broken.outlines, times=[1.0, 2.5])
    assert [unit for _, unit in times_on(shown)] == ["$t_0$", "$t_0$"]
    assert [time for time, _ in times_on(shown)] == pytest.approx([1.0, 2.5], abs=INTERVAL)
    assert shown[0].texts[0].get_text() == "0.5 $D_0$"
    physical = po.simulate(po.Parameters.from_physical(**experiment), outlines=INTERVAL)
    panels = snapshot_strip(physical.outlines, times=[1.0, 2.5])
    assert [unit for _, unit in times_on(panels)] == ["ms", "ms"]
    assert [time for time, _ in times_on(panels)] == pytest.approx(
        [481, 1202.5], abs=481 * INTERVAL
    )
    length, unit = panels[0].texts[0].get_text().split()
    bar = panels[0].lines[0].get_xdata()
    assert unit == "µm"
    assert (bar[1] - bar[0]) * 481 == pytest.approx(float(length))


def test_no_text_is_cut_off(broken):
    figure = snapshot_strip(broken.outlines)[0].figure
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    for panel in figure.axes:
        title_left, title_right = panel._left_title, panel._right_title
        boxes = [
            text.get_window_extent(renderer) for text in (title_left, title_right, *panel.texts)
        ]
        assert not boxes[0].overlaps(boxes[1])
        for box in boxes:
            assert box.x0 >= 0
            assert box.y0 >= 0
            assert box.x1 <= figure.bbox.x1
            assert box.y1 <= figure.bbox.y1


def test_given_axes_are_drawn_into(broken):
    axes = Figure().subplots(1, 2)
    assert snapshot_strip(broken.outlines, times=[0.0, 3.0], axes=axes) == list(axes)


def test_streamlines_follow_the_flow_round_the_obstacle(broken):
    flow = po.flow.stokes(broken.parameters.obstacle_radius)
    (plain,) = snapshot_strip(broken.outlines, times=[2.0])
    (drawn,) = snapshot_strip(broken.outlines, times=[2.0], flow=flow)
    (lines,) = [c for c in drawn.collections if isinstance(c, LineCollection)]
    assert not [c for c in plain.collections if isinstance(c, LineCollection)]
    curves = [np.asarray(curve) for curve in lines.get_segments()]
    middles = np.concatenate([(curve[1:] + curve[:-1]) / 2 for curve in curves])
    steps = np.concatenate([np.diff(curve, axis=0) for curve in curves])
    outside = np.hypot(*middles.T) > 1.3 * broken.parameters.obstacle_radius
    outside &= np.hypot(*steps.T) > 1e-9
    along = flow.velocity(middles[outside])
    cosine = (along * steps[outside]).sum(axis=1) / (
        np.hypot(*along.T) * np.hypot(*steps[outside].T)
    )
    assert np.median(np.abs(cosine)) > 0.999
    assert (np.hypot(*middles.T) > 0.9 * broken.parameters.obstacle_radius).all()


def test_film_says_how_much_of_the_run_a_second_shows(broken):
    stage = _Stage(broken.outlines, fps=30)
    (pace,) = [t.get_text() for t in stage._axes.texts if "of film" in t.get_text()]
    step = float(np.median(np.diff(broken.outlines.times)))
    assert pace == f"1 s of film: {30 * step:.3g} $t_0$"


def test_player_needs_no_network(broken):
    page = broken.outlines[::20].animate().page
    assert "http" not in page
    assert '<i class="fa' not in page


def test_wrong_times_and_axes_are_refused(broken, refused):
    end = float(broken.outlines.times[-1])
    refused("times", snapshot_strip, broken.outlines, [end + 1])
    outlines = broken.outlines
    refused("times", snapshot_strip, outlines, times=[])
    refused("times", snapshot_strip, outlines, times=[0.0, np.nan])
    refused("axes", snapshot_strip, outlines, times=[0.0], axes=Figure().subplots(1, 2))
    empty = po.Outlines.from_frames([0.0], [[]], [[0, 0, 0.2]], {})
    refused("outlines", snapshot_strip, empty)


def test_picture_is_of_the_width_of_two_columns(broken, tmp_path):
    write_snapshots(tmp_path / "snapshots.png", broken.outlines)
    header = (tmp_path / "snapshots.png").read_bytes()[16:20]
    assert int.from_bytes(header) == pytest.approx(style.TWO_COLUMNS * style.DOTS_PER_INCH, abs=1)


def test_film_shows_a_pink_droplet_and_a_grey_obstacle(broken, tmp_path):
    av = pytest.importorskip("av")
    calls = []
    path = tmp_path / "movie.mp4"
    every_fourth = broken.outlines[::4]
    write_movie(path, every_fourth, fps=25, progress=lambda *args: calls.append(args))
    assert [file.name for file in tmp_path.iterdir()] == ["movie.mp4"]
    with av.open(str(path)) as film:
        stream = film.streams.video[0]
        assert stream.average_rate == 25
        frames = [frame.to_ndarray(format="rgb24").astype(int) for frame in film.decode(stream)]
    assert calls == [(k, len(frames)) for k in range(1, len(frames) + 1)]
    middle = frames[0][270, 480]
    assert np.ptp(middle) < 10  # grey
    assert middle.max() < 110  # and dark
    red, green, _ = np.moveaxis(frames[len(frames) // 2], -1, 0)
    pink = np.mean(red - green > 40)
    window_area = 960 * 540 / (960 / 5.5) ** 2  # the window is a little wider than 5 D0
    assert pink == pytest.approx(np.pi / 4 / window_area, rel=0.25)


def test_film_refuses_what_it_cannot_make(broken, tmp_path, refused):
    pytest.importorskip("av")
    refused("path", write_movie, tmp_path / "movie.avi", broken.outlines)
    refused("fps", write_movie, tmp_path / "movie.mp4", broken.outlines, fps=0)
    far = po.Outlines.from_frames(
        [0.0], [[(0, 0, [[50, 0], [51, 0], [51, 1]], np.zeros((3, 2)))]], [[0, 0, 0.2]], {}
    )
    refused("outlines", write_movie, tmp_path / "movie.mp4", far)
    assert list(tmp_path.iterdir()) == []
