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

/// Margin, in D0, of the list of vertices near an obstacle; at most a quarter of its radius, so
/// that nothing passes through an obstacle between two looks.
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
    for (int c = 0; c < chunks; ++c) {
        if (distance2[c] >= listed * listed) continue;
        int run = 1;
        while (c + run < chunks && distance2[c + run] < listed * listed) ++run;
        lists.walls.push_back({index, c * kLanes, (c + run) * kLanes, o});
        c += run;
    }
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

/// Whether an edge is too near a vertex along the outline to count as its far side.
inline bool adjacent(const Ring& ring, int vertex, int edge) {
    const int ahead =
        (edge - vertex + ring.count) % ring.count;  // edges from the vertex to this one
    return ahead < kApart || ahead >= ring.count - kApart;
}

/// Lists one vertex of droplet a with the edges of droplet b within a distance, in runs without
/// gaps. Returns how deep it is inside b, or zero.
inline double list_vertex(ContactLists& lists, const Ring& a, int index_a, int vertex,
                          const Ring& b, int index_b, double within) {
    const Vec2 r{a.x[vertex], a.y[vertex]};
    const int n = b.count;
    const auto near = [&](int k) {
        return !(index_a == index_b && adjacent(a, vertex, k)) &&
               std::fabs(nearest_edge(b, r, k, 1).distance) < within;
    };
    double deepest = 0;
    int start = 0;  // begin the walk between two runs, where there is such a place
    while (start < n && near(start)) ++start;
    for (int seen = 0; seen < n;) {
        const int first = (start + seen) % n;
        int run = 0;
        while (seen + run < n && near((first + run) % n)) ++run;
        if (run > 0) {
            lists.touches.push_back({index_a, vertex, index_b, first, run});
            deepest = std::min(deepest, nearest_edge(b, r, first, run).distance);
        }
        seen += run + 1;
    }
    return -deepest;
}

/// Lists the vertices of droplet a near edges of droplet b. Returns how deep any of them is inside
/// b.
inline double list_touches(ContactLists& lists, const Kernels& kernels, Droplet& a, int index_a,
                           Droplet& b, int index_b, double within) {
    const Box box = bounding_box(b.ring);
    double deepest = 0;
    for (int i = 0; i < a.ring.count; ++i) {
        const double x = a.ring.x[i], y = a.ring.y[i];
        if (gap({x, x, y, y}, box) > within) continue;
        if (kernels.edge_distance2(b.ring, x, y) > within * within) continue;
        deepest =
            std::max(deepest, list_vertex(lists, a.ring, index_a, i, b.ring, index_b, within));
        a.ring.pushed = b.ring.pushed = true;
    }
    return deepest;
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

/// Lists the vertices of a droplet near the far side of its own outline. `reach` is a distance from
/// a vertex of the far side that covers `within` of any edge.
inline void list_own_sides(ContactLists& lists, Droplet& d, int index, double within,
                           double reach) {
    for (int i = 0; i < d.ring.count; ++i) {
        if (!near_far_side(d.ring, i, reach)) continue;
        list_vertex(lists, d.ring, index, i, d.ring, index, within);
        d.ring.pushed = true;
    }
}

}  // namespace pinchoff
