// The area of a front: its gradient, and the multiplier p of dA/dt = 0, alone and with walls.
//
// Walls are complementarity conditions on the velocity: a vertex that would enter one is held by a
// reaction along its normal, and the multiplier is the one at which the area stays all the same.
#pragma once

#include <algorithm>
#include <cmath>

#include "step.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Half of the difference between the neighbours, turned outwards: the gradient of the area.
PINCHOFF_HD inline Vec2 area_gradient(Vec2 before, Vec2 after) {
    return {0.5 * (after.y - before.y), 0.5 * (before.x - after.x)};
}

/// Sums over the vertices that the area multiplier follows from.
struct AreaSums {
    double rate;   // Σ ∇A·w, the rate at which the area changes
    double slope;  // Σ ∇A·∇A
};

/// How the vertices of a ring stand to the walls that they may meet in this step; for each vertex
/// the wall that it is to reach first. In arrays that are free at this point of a step.
struct Approach {
    double *normal_x, *normal_y;  // of the wall, towards the fluid; zero where there is none
    double* along;                // of the area's gradient along that normal
    double* excess;               // normal velocity, without the multiplier, less that at which the
                                  // vertex would just reach the wall by the end of the step
};

inline Approach approach_of(const Ring& ring) {
    return {ring.vx, ring.vy, ring.fluid_x, ring.slide};
}

/// Measures that; returns whether there are walls to meet.
inline bool approach_walls(const Ring& ring, const Scene& scene, const double* x, const double* y,
                           double time_step) {
    const Approach a = approach_of(ring);
    const double* wx = ring.push_x;
    const double* wy = ring.push_y;
    bool any = false;
    for (int c = ring.first_wall; c < ring.last_wall; ++c) {
        const WallContact& contact = scene.walls[c];
        if (!any) {
            for (double* values : {a.normal_x, a.normal_y, a.along})
                std::fill_n(values, ring.padded, 0.0);
            std::fill_n(a.excess, ring.padded, 1e300);
        }
        any = true;
        const Obstacle o = contact.obstacle;
        const double inverse_step = 1.0 / time_step;
        const int last = std::min(contact.last, ring.count);
        PINCHOFF_INDEPENDENT
        for (int i = contact.first; i < last; ++i) {
            const Vec2 from{x[i] - o.x, y[i] - o.y}, start{ring.x[i] - o.x, ring.y[i] - o.y};
            const Vec2 normal = (1.0 / std::sqrt(dot(from, from))) * from;
            const Vec2 gradient = area_gradient({x[i - 1], y[i - 1]}, {x[i + 1], y[i + 1]});
            const double gap = std::sqrt(dot(start, start)) - o.radius;
            const double excess = dot(Vec2{wx[i], wy[i]}, normal) + gap * inverse_step;
            const bool first = excess < a.excess[i];
            a.excess[i] = first ? excess : a.excess[i];
            a.along[i] = first ? dot(gradient, normal) : a.along[i];
            a.normal_x[i] = first ? normal.x : a.normal_x[i];
            a.normal_y[i] = first ? normal.y : a.normal_y[i];
        }
    }
    return any;
}

/// The multiplier q = p N_v/(μ D0) at which the area does not change, given that no vertex moves
/// into a wall: a vertex that would is held by a reaction along the wall's normal. The rate is a
/// rising, concave, piecewise linear function of q, so Newton's iteration ends with the exact set
/// of held vertices.
inline double held_multiplier(const Ring& ring, AreaSums all) {
    const Approach a = approach_of(ring);
    double q = -all.rate / all.slope, held_before = 0;
    constexpr int kMostSets = 20;
    for (int set = 0; set < kMostSets; ++set) {
        Lanes rate{}, slope{}, held{};
        for (int i = 0; i < ring.padded; i += kWidth) {
            const Lanes along = load(a.along + i), excess = load(a.excess + i) + q * along;
            const Lanes one = excess < 0.0 ? Lanes{} + 1.0 : Lanes{};
            const Lanes taken = one * along;
            rate += taken * (excess < 0.0 ? excess : Lanes{});
            slope += taken * along;
            held += one;
        }
        const double count = sum(held);
        if (count == held_before) break;  // the same vertices: the last q solved for them exactly
        held_before = count;
        q -= (all.rate + q * all.slope - sum(rate)) /
             larger(all.slope - sum(slope), 1e-3 * all.slope);
    }
    return q;
}

/// Add the walls' reactions to push_x, push_y.
inline void hold_at_walls(const Ring& ring, double q) {
    const Approach a = approach_of(ring);
    double* wx = ring.push_x;
    double* wy = ring.push_y;
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.padded; ++i) {
        const double excess = a.excess[i] + q * a.along[i];
        const double reaction = excess < 0.0 ? excess : 0.0;
        wx[i] -= reaction * a.normal_x[i];
        wy[i] -= reaction * a.normal_y[i];
    }
}

/// Add the area's multiplier to push_x, push_y, with ghosts.
inline void hold_area(const Ring& ring, const double* x, const double* y, double q) {
    double* wx = ring.push_x;
    double* wy = ring.push_y;
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.padded; ++i) {
        wx[i] += 0.5 * q * (y[i + 1] - y[i - 1]);
        wy[i] += 0.5 * q * (x[i - 1] - x[i + 1]);
    }
    wrap(ring, wx, wy);
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
