"""The figures of the paper: what each shows, and how ours is drawn."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from matplotlib.axes import Axes

from pinchoff.figures.appendix_c import appendix_c
from pinchoff.figures.breakup_probability import breakup_probability
from pinchoff.figures.constant_height import constant_height
from pinchoff.figures.construction import model_schematic, symmetry_construction
from pinchoff.figures.daughters import daughter_areas
from pinchoff.figures.neck_histograms import neck_histograms
from pinchoff.figures.phase_diagram import separated_outcomes, separating_line
from pinchoff.figures.sequences import collision_pairs
from pinchoff.figures.snapshots import snapshot_strip
from pinchoff.paper.study import Study
from pinchoff.studies.necks import median_history
from pinchoff.support.paper_constants import FRAME_RATE


class PaperFigure(NamedTuple):
    """A figure of the paper.

    Attributes
    ----------
    name, title, caption : str
        "1" to "10", "A", "B1", "B2" or "C"; and what it shows, in our words.
    how : str
        Where ours comes from.
    draw : callable
        Draws our version from a study, and returns its axes.
    experiment : bool
        Whether it shows the experiment, so that it is synthetic unless there is a real one.
    extra : str
        What must be installed beside the package itself: "chamber" or "video"; empty: nothing.
    """

    name: str
    title: str
    caption: str
    how: str
    draw: Callable[[Study], Axes]
    experiment: bool = False
    extra: str = ""


def _sequences(study: Study) -> Axes:
    return collision_pairs(study.sequences)[0]


def _neck_pictures(study: Study) -> Axes:
    """Draw the frames that a camera takes about the break-up, half a frame off it."""
    collision = study.median_collision
    outlines, scale = collision.outlines, collision.parameters.scale
    assert outlines is not None and scale is not None  # noqa: PT018
    interval = 1.0 / FRAME_RATE / scale.time_unit_s
    times = [collision.breakup_time + (k - 2.5) * interval for k in range(6)]
    return snapshot_strip(outlines, times)[0]


def _daughters(study: Study) -> Axes:
    table = study.collisions.table if study.measured else study.simulated
    return daughter_areas(table, curves=study.daughters)


def _necks(study: Study) -> Axes:
    table = study.collisions.table if study.measured else study.simulated
    return neck_histograms(table, median_history())[0]


def _device(_: Study) -> Axes:
    from pinchoff.chamber import Chamber
    from pinchoff.figures.chamber_design import chamber_design

    return chamber_design(Chamber())


def _filmed(figure: str) -> Callable[[Study], Axes]:
    def draw(study: Study) -> Axes:
        from pinchoff.figures.filmed_comparison import compared
        from pinchoff.paper.filming import filmed_comparison

        return compared(filmed_comparison(study.folder, figure, study.seed))[-1]

    return draw


FIGURES: tuple[PaperFigure, ...] = (
    PaperFigure(
        "1",
        "Collisions",
        "Pairs of images, v Δt = 400 µm apart: head-on and off-centre blows that break a large "
        "droplet, and one that does not break a small one. Speed and S are the paper's; the "
        "diameters, which it does not give, are 520, 540 and 260 µm.",
        "engine",
        _sequences,
    ),
    PaperFigure(
        "2",
        "The model",
        "A droplet as a polygon, one step before it breaks: vertices, the neck r_ij, and the "
        "shorter arc s_ij between its ends.",
        "engine",
        lambda study: model_schematic(study.median_collision),
    ),
    PaperFigure(
        "3",
        "The symmetry",
        "At first contact a line through the obstacle's centre along the droplet's velocity "
        "divides it into two areas.",
        "engine",
        lambda study: symmetry_construction(study.median_collision),
    ),
    PaperFigure(
        "4",
        "Who breaks",
        "Collisions that broke, all of them, and those that did not, with the separating line.",
        "law",
        lambda study: separated_outcomes(study.collisions.table, study.law.fit)[0],
        experiment=True,
    ),
    PaperFigure(
        "5",
        "Simulations and experiment",
        "Simulated collisions (stars) over those of the experiment, with the separating lines.",
        "engine",
        lambda study: separating_line(
            study.line, study.line.fit(), measured=study.collisions.table
        ),
        experiment=True,
    ),
    PaperFigure(
        "6",
        "One height",
        "Two droplets on the separating line whose smaller parts are nearly as high, and the "
        "exponent that one height gives.",
        "circular segments",
        lambda study: constant_height(study.law.fit)[0],
        experiment=True,
    ),
    PaperFigure(
        "7",
        "The probability of break-up",
        "The share of collisions that broke against the breakup number, with binomial intervals, "
        "the fitted law and a step.",
        "law",
        lambda study: breakup_probability(study.collisions.table, study.law.fit),
        experiment=True,
    ),
    PaperFigure(
        "8",
        "A neck that breaks",
        "Six moments 1/60 s apart about a break-up, as a camera of 60 frames/s would take them.",
        "engine",
        _neck_pictures,
    ),
    PaperFigure(
        "9",
        "Daughters",
        "The ratio of the daughters' areas against S. Dotted: without exchange between the sides. "
        "Lines: simulations of the median droplet, by Ca.",
        "engine",
        _daughters,
        experiment=True,
    ),
    PaperFigure(
        "10",
        "Necks",
        "The thinnest necks of droplets that break and that do not, and what cameras see in the "
        "last frame before the break-up of the median droplet (simulated to 0.167 D0, then an "
        "assumed 4.2 mm/s).",
        "engine",
        _necks,
        experiment=True,
    ),
    PaperFigure(
        "A",
        "The device",
        "The microfluidic chamber with its seven regions. Its length, thickness and obstacles are "
        "the paper's, the other lengths ours.",
        "chamber design",
        _device,
        extra="chamber",
    ),
    PaperFigure(
        "B1",
        "A small droplet",
        "A droplet of D0/R = 0.78: frames of a film with the simulation of the measured "
        "collision in red, its path and its shape. The film is not the paper's: it shows a "
        "simulated droplet, at 2.64 µm a pixel; what agrees is the measurement with what was "
        "filmed.",
        "film of the engine",
        _filmed("B1"),
        extra="video",
    ),
    PaperFigure(
        "B2",
        "A large droplet",
        "The same for D0/R = 2.5, at the paper's 5.28 µm a pixel.",
        "film of the engine",
        _filmed("B2"),
        extra="video",
    ),
    PaperFigure(
        "C",
        "Viscosity and line tension",
        "Critical symmetry against the viscosity for several line tensions, and all of it against "
        "their ratio.",
        "engine",
        lambda study: appendix_c(study.tensions)[0],
    ),
)
"""All of them, in the paper's order."""
