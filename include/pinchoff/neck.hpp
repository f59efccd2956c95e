// The neck: the thinnest chord between two vertices whose shorter arc exceeds a threshold
// [paper, section on break-up] and which leaves both of them inwards, so that a chord across a dent
// is none; and a bound on how far vertices may move before it can be crossed.
#pragma once

#include <cmath>
#include <limits>

#include "survey.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Writes an outline of `count` vertices over and over into arrays of `size`, with the arc length
/// from vertex 0; returns the perimeter.
inline double repeat_outline(const double* x, const double* y, int count, double* xx, double* yy,
                             double* arc, int size) {
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < count; ++i) {
        const double ex = x[i + 1] - x[i], ey = y[i + 1] - y[i];
        arc[i] = std::sqrt(ex * ex + ey * ey);
    }
    double perimeter = 0;
    for (int i = 0; i < count; ++i) {
        const double length = arc[i];
        arc[i] = perimeter;
        perimeter += length;
        xx[i] = x[i];
        yy[i] = y[i];
    }
    for (int i = count; i < size; ++i) {
        xx[i] = xx[i - count];
        yy[i] = yy[i - count];
        arc[i] = arc[i - count] + perimeter;
    }
    return perimeter;
}

/// The difference between the neighbours of every vertex, along the outline, again and again as
/// `repeat_outline`; returns the largest length of any.
inline double repeat_tangents(const double* xx, const double* yy, int count, double* mx, double* my,
                              int size) {
    Lanes most2{};
    for (int i = 0; i < count; ++i) {
        const int before = i == 0 ? count - 1 : i - 1;
        mx[i] = xx[i + 1] - xx[before];
        my[i] = yy[i + 1] - yy[before];
    }
    for (int i = count; i < size; ++i) {
        mx[i] = mx[i - count];
        my[i] = my[i - count];
    }
    for (int i = 0; i < count; i += kWidth)
        most2 = larger(load(mx + i) * load(mx + i) + load(my + i) * load(my + i), most2);
    return std::sqrt(most(most2));
}

/// Thinnest admissible chord of an outline, and how far every vertex may move, relative to any
/// common translation, before an admissible chord can be thinner than `threshold`.
///
/// Say every vertex moves by at most δ. A chord then shortens by at most 2δ. An arc of k edges out
/// of N, compared with a threshold f P + c, gains at most 2δ [k (1 - f) + (N - k) f]. A pair can
/// only become a neck when its chord has shortened to the threshold, both its arcs have grown past
/// theirs and it leaves both ends inwards, so its own budget is the largest of the δ that this
/// takes, and the outline's is the smallest budget of any pair. Square roots are avoided by the
/// secant of r(r²) below a cap, which lies below it. A chord c leaves a vertex inwards where m × c
/// is positive, m being the difference between the vertex's neighbours; the product changes by at
/// most 2δ(|m| + |c|) + 4δ², and so not its sign while δ < |m × c|/(3(|m| + |c|)).
///
/// x, y: (count + 1), the last repeats the first; work: room for neck_work_size(count) numbers.
inline NeckScan scan_neck(const double* x, const double* y, int count, Separation separation,
                          double threshold, double* work) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    // The outline and the arc length up to each vertex, written twice over so that no chord wraps.
    const int stride = 2 * count + 2 * kLanes;
    double *xx = work, *yy = xx + stride, *arc = yy + stride, *mx = arc + stride, *my = mx + stride;
    const double perimeter = repeat_outline(x, y, count, xx, yy, arc, stride);
    const double longest = repeat_tangents(xx, yy, count, mx, my, stride);
    double longest_edge = 0;
    for (int i = 0; i < count; ++i) longest_edge = larger(arc[i + 1] - arc[i], longest_edge);
    longest_edge *= 1.0 + 1e-12;  // rounding of the sums

    const double least_arc = separation.fraction * perimeter + separation.length;
    const double cap = 3.0 * threshold, cap2 = cap * cap, threshold2 = threshold * threshold;
    const double slope = 0.5 / (cap + threshold), f = separation.fraction;
    const double turn = -1.0 / (3.0 * (longest + cap));
    double thinnest2 = kNone, nearest2 = kNone, budget = 0.5 * (cap - threshold);
    for (int k = 1; k <= count / 2; ++k) {
        Lanes shortest2 = Lanes{} + kNone;
        for (int i = 0; i < count; i += kWidth) {  // past the last vertex it repeats
            const Lanes dx = load(xx + i + k) - load(xx + i), dy = load(yy + i + k) - load(yy + i);
            shortest2 = smaller(dx * dx + dy * dy, shortest2);
        }
        const double row2 = least(shortest2);
        if (k >= kApart) nearest2 = smaller(row2, nearest2);
        const double inverse_forward = 0.5 / (k * (1.0 - f) + (count - k) * f);
        const double inverse_backward = 0.5 / ((count - k) * (1.0 - f) + k * f);
        // What no pair of this row can be below decides whether its pairs are looked at.
        const double row_lack = least_arc - k * longest_edge;
        const double row_budget =
            larger(slope * (smaller(row2, cap2) - threshold2), row_lack * inverse_forward);
        if (row_budget >= budget && (row_lack >= 0.0 || row2 >= thinnest2)) continue;
        Lanes row_thinnest2 = Lanes{} + thinnest2, least_budget = Lanes{} + budget;
        for (int i = 0; i < count; i += kWidth) {
            const Lanes dx = load(xx + i + k) - load(xx + i), dy = load(yy + i + k) - load(yy + i);
            const Lanes r2 = dx * dx + dy * dy;
            const Lanes forward = load(arc + i + k) - load(arc + i);
            const Lanes lack_forward = least_arc - forward,
                        lack_backward = least_arc - (perimeter - forward);
            const Lanes lack = larger(lack_forward, lack_backward);
            const Lanes inwards = smaller(load(mx + i) * dy - load(my + i) * dx,
                                          load(my + i + k) * dx - load(mx + i + k) * dy);
            const Lanes chord2 = lack < 0.0 ? r2 : Lanes{} + kNone;
            row_thinnest2 = smaller(inwards > 0.0 ? chord2 : Lanes{} + kNone, row_thinnest2);
            const Lanes chord = slope * (smaller(r2, Lanes{} + cap2) - threshold2);
            const Lanes arcs =
                larger(lack_forward * inverse_forward, lack_backward * inverse_backward);
            least_budget = smaller(larger(larger(chord, arcs), turn * inwards), least_budget);
        }
        thinnest2 = least(row_thinnest2);
        budget = least(least_budget);
    }
    return {thinnest2, budget, nearest2};
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
