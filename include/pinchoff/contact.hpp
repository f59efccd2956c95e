// Which vertices may feel an obstacle or another droplet during the next block of steps.
//
// As with the neighbour lists of molecular dynamics, a list is built with a margin and is complete
// as long as no vertex has moved further than that margin.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "droplet.hpp"
#include "front.hpp"

namespace pinchoff {

struct ContactLists {
    std::vector<WallContact> walls;
    std::vector<DropletContact> touches;

    void clear() {
        walls.clear();
        touches.clear();
    }
};

/// Margin, in D0, of the list of vertices near an obstacle; at most a quarter of its radius, so
/// that nothing passes through an obstacle between two looks.
inline double wall_margin(const Obstacle& o) { return std::min(0.03, 0.25 * o.radius); }

/// How far from an obstacle's surface a vertex feels it. With front tracking it does so on the
/// surface, and next to an obstacle that an edge is to be kept out of.
inline double wall_range(const Ring& ring, const Obstacle& o) {
    if (!tracks_front(ring)) return 0.5 * ring.rest_length;
    return edge_scale(ring) < kLongEdge * o.radius ? 0.0 : edge_scale(ring);
}

/// Lists the vertices of a droplet near an obstacle. Returns how far they may move while the list
/// stays complete. `distance2` is room for one value a chunk.
inline double list_wall(ContactLists& lists, const Droplet& d, int index, const Obstacle& o,
                        const double* distance2) {
    const double touch = o.radius + wall_range(d.ring, o), margin = wall_margin(o);
    const int chunks = d.ring.padded / kLanes;
    const double nearest = std::sqrt(*std::min_element(distance2, distance2 + chunks)) - touch;
    if (nearest > margin) return nearest;
    const double listed = touch + margin;
    for (int c = 0; c < chunks; ++c) {
        if (distance2[c] >= listed * listed) continue;
        int run = 1;
        while (c + run < chunks && distance2[c + run] < listed * listed) ++run;
        lists.walls.push_back({index, c * kLanes, (c + run) * kLanes, o});
        c += run;
    }
    return margin;
}

struct Box {
    double left, right, bottom, top;
};

inline Box bounding_box(const Ring& r) {
    const auto [left, right] = std::minmax_element(r.x, r.x + r.count);
    const auto [bottom, top] = std::minmax_element(r.y, r.y + r.count);
    return {*left, *right, *bottom, *top};
}

/// Distance between two boxes, zero where they overlap.
inline double gap(const Box& a, const Box& b) {
    const double x = std::max({0.0, a.left - b.right, b.left - a.right});
    const double y = std::max({0.0, a.bottom - b.top, b.bottom - a.top});
    return std::hypot(x, y);
}

/// Whether an edge is too near a vertex along the outline to count as its far side.
inline bool adjacent(const Ring& ring, int vertex, int edge) {
    const int ahead =
        (edge - vertex + ring.count) % ring.count;  // edges from the vertex to this one
    return ahead < kApart || ahead >= ring.count - kApart;
}

/// A stretch of consecutive edges of a closed outline.
struct Run {
    int first, count;
};

/// The shortest stretch of n edges round a ring that holds every edge for which near(k); `some` is
/// one.
template <class Near>
Run covering_run(int n, int some, const Near& near) {
    Run run{some, n};
    for (int step = 1, gap = 0; step <= n; ++step) {
        const int k = (some + step) % n;
        if (!near(k)) {
            ++gap;
            continue;
        }
        if (n - gap < run.count) run = {k, n - gap};
        gap = 0;
    }
    return run;
}

/// Lists the vertices of ring a near edges of ring b. Each is listed with one stretch of edges
/// round the nearest, since the nearest edge alone tells on which side of a thin part it is.
/// Returns how deep any of them is inside b.
inline double list_touches(ContactLists& lists, const Kernels& kernels, const Ring& a, int index_a,
                           const Ring& b, int index_b, double within) {
    const Box box = bounding_box(b);
    double deepest = 0;
    for (int i = 0; i < a.count; ++i) {
        const Vec2 r = displacement({0.0, 0.0}, {a.x[i], a.y[i]});
        if (gap({r.x, r.x, r.y, r.y}, box) > within) continue;
        if (kernels.edge_distance2(b, r.x, r.y) > within * within) continue;
        const Nearest nearest = nearest_edge(b, r, 0, b.count);
        const Run run = covering_run(b.count, nearest.edge, [&](int k) {
            return std::fabs(nearest_edge(b, r, k, 1).distance) <= within;
        });
        lists.touches.push_back({index_a, i, index_b, run.first, run.count});
        deepest = std::min(deepest, nearest.distance);
    }
    return -deepest;
}

/// What a look at two droplets gives: how far vertices may move while the list is complete, and how
/// deep one is inside the other.
struct PairRoom {
    double allowed, depth;
};

/// Lists the vertices of ring a that may touch ring b.
inline PairRoom list_pair(ContactLists& lists, const Kernels& kernels, const Ring& a, int index_a,
                          const Ring& b, int index_b) {
    // A list is built wider than the contact's range by what both sides may move.
    const double margin = 0.5 * touch_of(a, b).length, range = tracks_front(a) ? 0.0 : margin;
    const double apart = gap(bounding_box(a), bounding_box(b)) - range;
    if (apart > 2.0 * margin) return {0.5 * apart, 0.0};
    return {margin, list_touches(lists, kernels, a, index_a, b, index_b, range + 2.0 * margin)};
}

/// Whether any vertex kApart or more edges away along the outline is within a distance.
inline bool near_far_side(const Ring& ring, int vertex, double within) {
    const double x = ring.x[vertex], y = ring.y[vertex], within2 = within * within;
    int near = 0;
    for (int k = 0; k < ring.count; ++k) {
        const double dx = ring.x[k] - x, dy = ring.y[k] - y;
        near += dx * dx + dy * dy < within2 && std::abs(k - vertex) >= kApart &&
                std::abs(k - vertex) <= ring.count - kApart;
    }
    return near > 0;
}

/// Lists the vertices of a droplet near the far side of its own outline, each stretch of edges by
/// itself: between two of them a vertex is pushed by both. `reach` is a distance from a vertex of
/// the far side that covers `within` of any edge.
inline void list_own_sides(ContactLists& lists, const Ring& ring, int index, double within,
                           double reach) {
    for (int i = 0; i < ring.count; ++i) {
        if (!near_far_side(ring, i, reach)) continue;
        const Vec2 r{ring.x[i], ring.y[i]};
        // The edges next to the vertex never count, so no stretch reaches round to where this
        // begins.
        for (int step = 0, run = 0; step <= ring.count; ++step) {
            const int k = (i + step) % ring.count;
            const bool near = step < ring.count && !adjacent(ring, i, k) &&
                              std::fabs(nearest_edge(ring, r, k, 1).distance) < within;
            if (near) {
                ++run;
            } else if (run > 0) {
                lists.touches.push_back(
                    {index, i, index, (k - run + ring.count) % ring.count, run});
                run = 0;
            }
        }
    }
}

/// List the parts of one droplet so thin that its sides repel; returns how far vertices may move
/// while the list is complete. `thinnest` is its shortest chord between vertices kApart or more
/// edges apart. A vertex within reach of an edge is within reach of a vertex half an edge on.
inline double list_own(ContactLists& lists, const Ring& ring, int index, double thinnest) {
    const double l = ring.rest_length, range = 0.5 * touch_of(ring, ring).length, margin = 0.25 * l;
    const double reach =
        std::hypot(range, l) + 2.0 * margin;  // longer edges are left to the guard on crossings
    if (thinnest > reach) return margin + 0.5 * (thinnest - reach);
    list_own_sides(lists, ring, index, range + 2.0 * margin, reach);
    return margin;
}

/// How far a box reaches beyond a sampled flow; negative where it is inside.
inline double outside(const Flow& flow, const Box& box) {
    double out = -std::numeric_limits<double>::infinity();
    if (!flow.periodic_x)
        out = std::max({out, flow.x0 - box.left, box.right - flow.x0 - (flow.nx - 1) * flow.dx});
    if (!flow.periodic_y)
        out = std::max({out, flow.y0 - box.bottom, box.top - flow.y0 - (flow.ny - 1) * flow.dy});
    return out;
}

}  // namespace pinchoff
