// One time step of the model without springs: an interface that is line tension alone, carried by
// the fluid, with its area fixed and its vertices kept even (front tracking).
//
// The paper's deformable particle in the limit that its inequalities point to: overdamped, area and
// wall as hard as can be, edges even at no cost. A vertex with the drag μ D0/N_v moves with
//
//   w = u + N_v/(μ D0) [γ (t₊ - t₋) + p ∇A],   t₊, t₋ the unit tangents of its two edges,
//
// which is the normal velocity u·n + P/(Ca_sim D0) (p - κ) of the continuous outline. p is the
// Lagrange multiplier of dA/dt = 0, walls are complementarity conditions on the same velocity, and
// the slide along the outline, which changes no shape, is the one that keeps all edges equal (Hou,
// Lowengrub and Shelley, J. Comput. Phys. 114, 312 (1994), here in its discrete form).
//
// Time: r' = r + Δt v(r + Δt/2 v₋), v₋ the velocity of the step before. One evaluation a step,
// second order, started by an evaluation at r.
#pragma once

#include <algorithm>
#include <cmath>

#include "flow.hpp"
#include "step.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Whether a ring follows this model.
inline bool tracks_front(const Ring& ring) { return ring.constants.front_tracking != 0.0; }

/// Whether a ring has walls near.
inline bool meets_walls(const Ring& ring) { return ring.first_wall < ring.last_wall; }

/// Half of the difference between the neighbours, turned outwards: the gradient of the area.
PINCHOFF_HD inline Vec2 area_gradient(Vec2 before, Vec2 after) {
    return {0.5 * (after.y - before.y), 0.5 * (before.x - after.x)};
}

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
    const int whole = ring.count / kWidth * kWidth;
    Lanes lanes{};
    for (int i = 0; i < whole; i += kWidth) lanes += load(length + i);
    double total = sum(lanes);
    for (int i = whole; i < ring.count; ++i) total += length[i];
    return total;
}

/// Sums over the vertices that the area multiplier follows from.
struct AreaSums {
    double rate;   // Σ ∇A·w, the rate at which the area changes
    double slope;  // Σ ∇A·∇A
};

/// Velocity by flow and line tension alone into push_x, push_y.
template <class FlowAt>
AreaSums carry_and_tighten(const Ring& ring, const FlowAt& flow, const double* x, const double* y) {
    const double* tx = ring.pull_x;
    const double* ty = ring.pull_y;
    double* wx = ring.push_x;
    double* wy = ring.push_y;
    const double* fluid_x = ring.fluid_x;
    const double* fluid_y = ring.fluid_y;
    const double mobility = ring.mobility * ring.constants.line_tension;
    if constexpr (FlowAt::kByRing) {
        Ring here = ring;
        here.x = const_cast<double*>(x);
        here.y = const_cast<double*>(y);
        flow.fill(here);
    }
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.padded; ++i) {
        Vec2 fluid;
        if constexpr (FlowAt::kByRing) fluid = {fluid_x[i], fluid_y[i]};
        else fluid = flow.at({x[i], y[i]});
        wx[i] = fluid.x + mobility * (tx[i] - tx[i - 1]);
        wy[i] = fluid.y + mobility * (ty[i] - ty[i - 1]);
    }
    const int whole = ring.count / kWidth * kWidth;
    Lanes rate{}, slope{};
    for (int i = 0; i < whole; i += kWidth) {
        const Lanes gx = 0.5 * (load(y + i + 1) - load(y + i - 1));
        const Lanes gy = 0.5 * (load(x + i - 1) - load(x + i + 1));
        rate += gx * load(wx + i) + gy * load(wy + i);
        slope += gx * gx + gy * gy;
    }
    AreaSums sums{sum(rate), sum(slope)};
    for (int i = whole; i < ring.count; ++i) {
        const Vec2 g = area_gradient({x[i - 1], y[i - 1]}, {x[i + 1], y[i + 1]});
        sums.rate += dot(g, {wx[i], wy[i]});
        sums.slope += dot(g, g);
    }
    return sums;
}

/// Add the velocity by adhesion to push_x, push_y, and what it does to the area to the sums.
inline void adhere(const Ring& ring, const Scene& scene, const double* x, const double* y,
                   AreaSums& sums) {
    double* fx = ring.slide;  // free at this point of a step
    double* fy = ring.fluid_x;
    std::fill_n(fx, ring.padded, 0.0);
    std::fill_n(fy, ring.padded, 0.0);
    for (int c = ring.first_wall; c < ring.last_wall; ++c)
        if (scene.walls[c].met)
            pull_to_wall(ring, scene.walls[c].obstacle, x, y, ring.mobility, fx, fy);
    for (int i = 0; i < ring.count; ++i) {
        ring.push_x[i] += fx[i];
        ring.push_y[i] += fy[i];
        sums.rate += dot(area_gradient({x[i - 1], y[i - 1]}, {x[i + 1], y[i + 1]}), {fx[i], fy[i]});
    }
}

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
    wrap(wx, ring.count, ring.padded);
    wrap(wy, ring.count, ring.padded);
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
    const int whole = count / kWidth * kWidth;
    Lanes total{};
    for (int i = 0; i < whole; i += kWidth) total += load(slide + i);
    double mean_slide = sum(total);
    for (int i = whole; i < count; ++i) mean_slide += slide[i];
    return {mean_slide / count - 0.5 * rise * (count - 1), rise};
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
    for (int i = ring.count; i < ring.padded; ++i) {
        vx[i] = vx[i - ring.count];
        vy[i] = vy[i - ring.count];
    }
}

/// Velocity of one ring with its vertices at x, y, for a step that begins at its own positions.
template <bool Track, class FlowAt>
void front_velocity(const Ring& ring, const Scene& scene, const FlowAt& flow, const double* x,
                    const double* y, double time_step) {
    const double perimeter = measure_edges(ring, x, y);
    AreaSums sums = carry_and_tighten(ring, flow, x, y);
    if (ring.constants.adhesion > 0.0 && meets_walls(ring)) adhere(ring, scene, x, y, sums);
    double q = -sums.rate / sums.slope;
    if (approach_walls(ring, scene, x, y, time_step)) {
        q = held_multiplier(ring, sums);
        hold_at_walls(ring, q);
    }
    hold_area(ring, x, y, q);
    finish_velocity<Track>(ring, even_out(ring, perimeter));
}

/// Vertices at most this much nearer to a wall than allowed count as outside; they are put so far
/// outside that round-off cannot bring them in.
inline constexpr double kWallRoundOff = 4e-16;

/// Put every listed vertex that is inside an obstacle back on its surface.
inline void keep_out(const Ring& ring, const Scene& scene, double* x, double* y) {
    for (int c = ring.first_wall; c < ring.last_wall; ++c) {
        const WallContact& contact = scene.walls[c];
        const Obstacle o = contact.obstacle;
        PINCHOFF_INDEPENDENT
        for (int i = contact.first; i < contact.last; ++i) {
            const Vec2 from{x[i] - o.x, y[i] - o.y};
            const double distance = std::sqrt(dot(from, from));
            const double scale =
                distance < o.radius ? (1.0 + kWallRoundOff) * o.radius / distance : 1.0;
            if (scale != 1.0) {
                x[i] = o.x + scale * from.x;
                y[i] = o.y + scale * from.y;
            }
        }
    }
    wrap(x, ring.count, ring.padded);
    wrap(y, ring.count, ring.padded);
}

/// Edges longer than this times the radius of an obstacle are kept out of it too; shorter ones dip
/// in by less than kEdgeDepth of it when both of their ends are outside.
inline constexpr double kLongEdge = 0.85;
inline constexpr double kEdgeDepth = 0.1;

/// Length of the edges of a ring, which are about equal.
inline double edge_scale(const Ring& ring) { return larger(ring.length[0], ring.rest_length); }

/// Push both ends of every listed edge that is too deep in an obstacle, which may lie between them.
inline void keep_edges_out(const Ring& ring, const Scene& scene) {
    double* x = ring.x;
    double* y = ring.y;
    for (int c = ring.first_wall; c < ring.last_wall; ++c) {
        const WallContact& contact = scene.walls[c];
        const Obstacle o = contact.obstacle;
        if (edge_scale(ring) < kLongEdge * o.radius) continue;
        const double least = (1.0 - kEdgeDepth) * o.radius;
        for (int k = contact.first - 1; k < std::min(contact.last, ring.count); ++k) {
            const int i = k < 0 ? ring.count - 1 : k, next = i + 1 == ring.count ? 0 : i + 1;
            const Vec2 a{x[i] - o.x, y[i] - o.y}, e{x[next] - x[i], y[next] - y[i]};
            const double f = smaller(larger(-dot(a, e) / dot(e, e), 0.0), 1.0);
            const Vec2 from = a + f * e;
            // Outside is on the right of the edge; on the left, its middle has passed the centre.
            const double side = cross(e, from) < 0.0 ? -1.0 : 1.0;
            const double distance = side * std::sqrt(dot(from, from));
            if (std::fabs(distance) >= least) continue;
            const Vec2 normal = 1.0 / std::sqrt(dot(e, e)) * Vec2{-e.y, e.x};
            const double push = (least - distance) / (f * f + (1.0 - f) * (1.0 - f));
            x[i] += push * (1.0 - f) * normal.x;
            y[i] += push * (1.0 - f) * normal.y;
            x[next] += push * f * normal.x;
            y[next] += push * f * normal.y;
        }
    }
    wrap(x, ring.count, ring.padded);
    wrap(y, ring.count, ring.padded);
}

/// Take back what a step of finite length has changed of the area, by a shift along its gradient of
/// the vertices that are clear of walls. Returns the relative error that it found; what is left is
/// of the order of the square of that.
inline double shift_to_area(const Ring& ring, const Scene& scene) {
    constexpr double kRoundOff = 1e-12;
    double* x = ring.x;
    double* y = ring.y;
    const double lack = ring.rest_area - signed_area(ring),
                 error = std::fabs(lack) / ring.rest_area;
    if (error < kRoundOff) return error;
    double* share = ring.slide;  // 1 for a vertex that takes part
    std::fill_n(share, ring.count, 1.0);
    std::fill_n(share + ring.count, ring.padded - ring.count, 0.0);
    const double clear = 0.02 * ring.rest_length;  // far more than a shift
    for (int c = ring.first_wall; c < ring.last_wall; ++c) {
        const WallContact& contact = scene.walls[c];
        const Obstacle o = contact.obstacle;
        const double clear2 = (o.radius + clear) * (o.radius + clear);
        for (int i = contact.first; i < contact.last; ++i) {
            const Vec2 from{x[i] - o.x, y[i] - o.y};
            share[i] = dot(from, from) < clear2 ? 0.0 : share[i];
        }
    }
    // Into the edges' arrays first: a vertex's gradient needs its neighbours where they were.
    double* dx = ring.pull_x;
    double* dy = ring.pull_y;
    Lanes slope{};
    for (int i = 0; i < ring.padded; i += kWidth) {
        const Lanes gx = 0.5 * load(share + i) * (load(y + i + 1) - load(y + i - 1));
        const Lanes gy = 0.5 * load(share + i) * (load(x + i - 1) - load(x + i + 1));
        slope += gx * gx + gy * gy;
        store(dx + i, gx);
        store(dy + i, gy);
    }
    const double shift = lack / sum(slope);
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.padded; ++i) {
        x[i] += shift * dx[i];
        y[i] += shift * dy[i];
    }
    wrap(x, ring.count, ring.padded);
    wrap(y, ring.count, ring.padded);
    return error;
}

/// Put a ring out of its walls and give it its area.
inline void restore(const Ring& ring, const Scene& scene) {
    constexpr int kMostRounds = 6;
    constexpr double kNoNeedOfAnother = 1e-7;  // its square is round-off
    const bool walled = meets_walls(ring);
    if (walled) keep_edges_out(ring, scene);
    keep_out(ring, scene, ring.x, ring.y);
    for (int round = 0; round < kMostRounds; ++round)
        if (shift_to_area(ring, scene) < kNoNeedOfAnother) break;
    if (walled) keep_out(ring, scene, ring.x, ring.y);
}

/// One step of one ring among walls.
template <class FlowAt>
void advance_front(const Ring& ring, const Scene& scene, const FlowAt& flow, double time_step) {
    double* x = ring.x;
    double* y = ring.y;
    double* mx = ring.mid_x;
    double* my = ring.mid_y;
    double* vx = ring.vx;
    double* vy = ring.vy;
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.padded; ++i) {
        mx[i] = x[i] + 0.5 * time_step * vx[i];
        my[i] = y[i] + 0.5 * time_step * vy[i];
    }
    keep_out(ring, scene, mx, my);
    front_velocity<true>(ring, scene, flow, mx, my, time_step);
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.padded; ++i) {
        x[i] += time_step * vx[i];
        y[i] += time_step * vy[i];
    }
    restore(ring, scene);
}

/// Front tracking: how near the two sides of one droplet may come, in vertex spacings.
inline constexpr double kThinnestPart = 0.5;

/// Put vertices that are inside another droplet back on its outline, which gives way as much, and
/// hold the far side of a thin part of one's own at a distance.
inline void part_fronts(const Scene& scene) {
    for (int c = 0; c < scene.touch_count; ++c) {
        const DropletContact& touch = scene.touches[c];
        const Ring& a = scene.rings[touch.ring];
        const Ring& b = scene.rings[touch.other];
        const Nearest near =
            nearest_edge(b, vertex_seen_by(scene, touch), touch.first_edge, touch.edge_count);
        const bool own = &a == &b;
        const double distance = own ? std::fabs(near.distance) : near.distance;
        const double lack = (own ? kThinnestPart * a.rest_length : 0.0) - distance;
        if (lack <= 0.0) continue;
        const double f = near.fraction, share = 1.0 / (1.0 + f * f + (1.0 - f) * (1.0 - f));
        const double side = own && near.distance < 0.0 ? -1.0 : 1.0;
        const Vec2 shift = (side * share * lack) * near.normal;
        const int next = near.edge + 1 == b.count ? 0 : near.edge + 1;
        a.x[touch.vertex] += shift.x;
        a.y[touch.vertex] += shift.y;
        b.x[near.edge] -= (1.0 - f) * shift.x;
        b.y[near.edge] -= (1.0 - f) * shift.y;
        b.x[next] -= f * shift.x;
        b.y[next] -= f * shift.y;
        wrap(a.x, a.count, a.padded);
        wrap(a.y, a.count, a.padded);
        wrap(b.x, b.count, b.padded);
        wrap(b.y, b.count, b.padded);
    }
    if (scene.touch_count == 0) return;
    for (int r = 0; r < scene.ring_count; ++r) {
        const Ring& ring = scene.rings[r];
        if (!ring.pushed) continue;
        restore(ring, scene);
    }
}

/// Outlines that a cut has just made: out of walls and each other, with their areas.
inline void settle_fronts(const Scene& scene) {
    part_fronts(scene);
    for (int r = 0; r < scene.ring_count; ++r) restore(scene.rings[r], scene);
}

/// `steps` steps of every ring, each in as many parts as it needs.
inline void advance_fronts(const Scene& scene, double time_step, int steps) {
    with_flow(scene.flow, [&](const auto& flow) {
        for (int n = 0; n < steps; ++n) {
            for (int r = 0; r < scene.ring_count; ++r) {
                const Ring& ring = scene.rings[r];
                for (int part = 0; part < ring.parts; ++part)
                    advance_front(ring, scene, flow, time_step / ring.parts);
            }
            part_fronts(scene);
        }
    });
}

/// Velocities of the present positions, which stay.
inline void front_velocities(const Scene& scene, double time_step) {
    with_flow(scene.flow, [&](const auto& flow) {
        for (int r = 0; r < scene.ring_count; ++r) {
            const Ring& ring = scene.rings[r];
            front_velocity<false>(ring, scene, flow, ring.x, ring.y, time_step);
        }
    });
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
