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
// the slide along the outline, which changes no shape, is the one that keeps all edges equal.
//
// Time: r' = r + Δt v(r + Δt/2 v₋), v₋ the velocity of the step before. One evaluation a step,
// second order, started by an evaluation at r.
#pragma once

#include <algorithm>
#include <cmath>

#include "flow.hpp"
#include "front_area.hpp"
#include "front_edges.hpp"
#include "front_repair.hpp"
#include "step.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Whether a ring follows this model.
inline bool tracks_front(const Ring& ring) { return ring.constants.front_tracking != 0.0; }

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
    if constexpr (FlowAt::kByRing) flow.fill(ring, x, y);
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
