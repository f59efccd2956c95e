// What a step of finite length leaves of fronts is put right: out of walls, out of each other, and
// each with its own area.
#pragma once

#include <algorithm>
#include <cmath>

#include "front_area.hpp"
#include "step.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Whether a ring has walls near.
inline bool meets_walls(const Ring& ring) { return ring.first_wall < ring.last_wall; }

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
    wrap(ring, x, y);
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
            const int i = k < 0 ? ring.count - 1 : k, next = after(ring, i);
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
    wrap(ring, x, y);
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
    wrap(ring, x, y);
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
        const int next = after(b, near.edge);
        a.x[touch.vertex] += shift.x;
        a.y[touch.vertex] += shift.y;
        b.x[near.edge] -= (1.0 - f) * shift.x;
        b.y[near.edge] -= (1.0 - f) * shift.y;
        b.x[next] -= f * shift.x;
        b.y[next] -= f * shift.y;
        wrap(a, a.x, a.y);
        wrap(b, b.x, b.y);
    }
    if (scene.touch_count == 0) return;
    for (int r = 0; r < scene.ring_count; ++r) {
        const Ring& ring = scene.rings[r];
        if (ring.pushed) restore(ring, scene);
    }
}

/// Outlines that a cut has just made: out of walls and each other, with their areas.
inline void settle_fronts(const Scene& scene) {
    part_fronts(scene);
    for (int r = 0; r < scene.ring_count; ++r) restore(scene.rings[r], scene);
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
