// The neck: the thinnest chord between two vertices whose shorter arc exceeds a threshold
// [paper, section on break-up], and a bound on how far vertices may move before it can be crossed.
#pragma once

#include <cmath>
#include <limits>

#include "survey.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Thinnest admissible chord of an outline, and how far every vertex may move, relative to any
/// common translation, before an admissible chord can be thinner than `threshold`.
///
/// Say every vertex moves by at most δ. A chord then shortens by at most 2δ. An arc of k edges out
/// of N, compared with a threshold f P + c, gains at most 2δ [k (1 - f) + (N - k) f]. A pair can only
/// become a neck when its chord has shortened to the threshold and both its arcs have grown past
/// theirs, so its own budget is the largest of the three δ that this takes, and the outline's is the
/// smallest budget of any pair. Square roots are avoided by the secant of r(r²) below a cap, which
/// lies below it.
///
/// x, y, arc: (2 count + kLanes), the outline, and the arc length from vertex 0, written twice over.
inline NeckScan scan_neck(const double* x, const double* y,
                          const double* arc, int count, double perimeter,
                          Separation separation, double threshold) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const double least_arc = separation.fraction * perimeter + separation.length;
    const double cap = 3.0 * threshold, cap2 = cap * cap, threshold2 = threshold * threshold;
    const double slope = 0.5 / (cap + threshold);
    double thinnest[kLanes], budget[kLanes];
    for (int l = 0; l < kLanes; ++l) {
        thinnest[l] = kNone;
        budget[l] = 0.5 * (cap - threshold);
    }
    for (int k = 1; k <= count / 2; ++k) {
        const double f = separation.fraction;
        const double inverse_forward = 0.5 / (k * (1.0 - f) + (count - k) * f);
        const double inverse_backward = 0.5 / ((count - k) * (1.0 - f) + k * f);
        for (int i = 0; i < count; i += kLanes) {
            PINCHOFF_INDEPENDENT
            for (int l = 0; l < kLanes; ++l) {
                const int a = i + l;  // up to kLanes - 1 past the last vertex: the outline repeats
                const double dx = x[a + k] - x[a], dy = y[a + k] - y[a];
                const double r2 = dx * dx + dy * dy;
                const double forward = arc[a + k] - arc[a], backward = perimeter - forward;
                const double lack_forward = least_arc - forward, lack_backward = least_arc - backward;
                const bool admissible = (lack_forward < 0.0) & (lack_backward < 0.0);
                const double candidate = admissible ? r2 : kNone;
                thinnest[l] = smaller(candidate, thinnest[l]);
                const double chord = slope * (smaller(r2, cap2) - threshold2);
                const double arcs = larger(lack_forward * inverse_forward, lack_backward * inverse_backward);
                budget[l] = smaller(larger(chord, arcs), budget[l]);
            }
        }
    }
    NeckScan out{thinnest[0], budget[0]};
    for (int l = 1; l < kLanes; ++l) {
        out.thickness2 = smaller(thinnest[l], out.thickness2);
        out.budget = smaller(budget[l], out.budget);
    }
    return out;
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
