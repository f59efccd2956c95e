// The edges of a front: their tangents, and the slide of the vertices along the outline that keeps
// all of them equal and changes no shape (Hou, Lowengrub and Shelley, J. Comput. Phys. 114, 312
// (1994), here in its discrete form).
#pragma once

#include <cmath>

#include "step.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Unit tangents and lengths of all edges of an outline; returns the perimeter.
inline double measure_edges(const Ring& ring, const double* x, const double* y) {
    double* tx = ring.pull_x;
    double* ty = ring.pull_y;
    double* length = ring.length;
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.padded; ++i) {
        const Vec2 e = Vec2{x[i + 1], y[i + 1]} - Vec2{x[i], y[i]};
        const double squared = dot(e, e);
        const double inverse = 1.0 / std::sqrt(squared);
        tx[i] = inverse * e.x;
        ty[i] = inverse * e.y;
        length[i] = inverse * squared;
    }
    tx[-1] = tx[ring.count - 1];
    ty[-1] = ty[ring.count - 1];
    return sum(length, ring.count);
}

/// A line over the vertex numbers, to be taken off the sums in `slide`.
struct Slope {
    double start, rise;
};

/// The slide of every vertex along the outline, times the cosine of half the angle between its
/// edges: with it all edges lengthen at one common rate, but for a slow return to equal lengths. It
/// is the sum of what the edges before it lack of lengthening; into `slide` without the share of
/// all edges alike, which is returned. Its mean is zero, so that a droplet carried without
/// deformation does not turn its vertices round.
inline Slope even_out(const Ring& ring, double perimeter) {
    const double* tx = ring.pull_x;
    const double* ty = ring.pull_y;
    const double* wx = ring.push_x;
    const double* wy = ring.push_y;
    const double* length = ring.length;
    double* slide = ring.slide;
    const int count = ring.count;
    const double evening = ring.constants.evening_rate, mean_length = perimeter / count;
    Lanes reached{};
    slide[0] = 0.0;
    for (int i = 0; i < ring.padded; i += kWidth) {
        const Lanes stretch = load(tx + i) * (load(wx + i + 1) - load(wx + i)) +
                              load(ty + i) * (load(wy + i + 1) - load(wy + i));
        const Lanes lack = evening * (mean_length - load(length + i)) - stretch;
        const Lanes sums = reached + running_sum(lack);
        store(slide + i + 1, sums);
        reached = Lanes{} + sums[kWidth - 1];
    }
    const double rise = slide[count] / count;
    return {sum(slide, count) / count - 0.5 * rise * (count - 1), rise};
}

/// Velocity of all vertices with their slide into vx, vy. Track: add to the path of each vertex.
template <bool Track>
void finish_velocity(const Ring& ring, Slope line) {
    const double* tx = ring.pull_x;
    const double* ty = ring.pull_y;
    const double* wx = ring.push_x;
    const double* wy = ring.push_y;
    const double* slide = ring.slide;
    double* vx = ring.vx;
    double* vy = ring.vy;
    double* path = ring.path;
    const double drift_x = ring.drift_x, drift_y = ring.drift_y;
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.padded; ++i) {
        const double turn = 1.0 + tx[i] * tx[i - 1] + ty[i] * ty[i - 1];
        const double along = (slide[i] - (line.start + line.rise * i)) / larger(turn, 0.1);
        const Vec2 v{wx[i] + along * (tx[i] + tx[i - 1]), wy[i] + along * (ty[i] + ty[i - 1])};
        vx[i] = v.x;
        vy[i] = v.y;
        if constexpr (Track) {
            const Vec2 relative = v - Vec2{drift_x, drift_y};
            path[i] += dot(relative, relative);
        }
    }
    repeat_first(ring, vx, vy);
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
