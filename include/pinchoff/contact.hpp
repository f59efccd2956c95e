// Which vertices may feel an obstacle or another droplet during the next block of steps.
//
// As with the neighbour lists of molecular dynamics, a list is built with a margin and is complete
// as long as no vertex has moved further than that margin.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "droplet.hpp"

namespace pinchoff {

struct ContactLists {
    std::vector<WallContact> walls;
    std::vector<DropletContact> touches;

    void clear() {
        walls.clear();
        touches.clear();
    }
};

/// Margin, in D0, of the list of vertices near an obstacle; at most a quarter of its radius, so that
/// nothing passes through an obstacle between two looks.
inline double wall_margin(const Obstacle& o) { return std::min(0.03, 0.25 * o.radius); }

/// Lists the vertices of a droplet near an obstacle. Returns how far they may move while the list
/// stays complete. `distance2` is room for one value a chunk.
inline double list_wall(ContactLists& lists, Droplet& d, int index, const Obstacle& o,
                        const double* distance2) {
    const double touch = o.radius + 0.5 * d.ring.rest_length, margin = wall_margin(o);
    const int chunks = d.ring.padded / kLanes;
    const double nearest = std::sqrt(*std::min_element(distance2, distance2 + chunks)) - touch;
    if (nearest > margin) return nearest;
    const double listed = touch + margin;
    for (int c = 0; c < chunks; ++c)
        if (distance2[c] < listed * listed) lists.walls.push_back({index, c, o});
    d.ring.pushed = true;
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

/// Lists the vertices of droplet a near edges of droplet b, edges in runs without gaps. Returns the
/// deepest that any of them is inside b.
inline double list_touches(ContactLists& lists, const Kernels& kernels, Droplet& a, int index_a,
                           Droplet& b, int index_b, double within) {
    const Box box = bounding_box(b.ring);
    double deepest = 0;
    for (int i = 0; i < a.ring.count; ++i) {
        const double x = a.ring.x[i], y = a.ring.y[i];
        if (gap({x, x, y, y}, box) > within) continue;
        if (kernels.edge_distance2(b.ring, x, y) > within * within) continue;
        const int n = b.ring.count;
        const auto near = [&](int k) { return std::fabs(nearest_edge(b.ring, {x, y}, k, 1).distance) < within; };
        int start = 0;  // begin the walk between two runs, where there is such a place
        while (start < n && near(start)) ++start;
        for (int k = start, seen = 0; seen < n;) {
            int run = 0;
            while (seen + run < n && near((k + run) % n)) ++run;
            if (run > 0) {
                lists.touches.push_back({index_a, i, index_b, k % n, run});
                deepest = std::min(deepest, nearest_edge(b.ring, {x, y}, k % n, run).distance);
            }
            k += run + 1;
            seen += run + 1;
        }
        a.ring.pushed = b.ring.pushed = true;
    }
    return -deepest;
}

}  // namespace pinchoff
