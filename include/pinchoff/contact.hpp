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
#include "neighbours.hpp"

namespace pinchoff {

struct ContactLists {
    std::vector<WallContact> walls;
    std::vector<DropletContact> touches;

    std::vector<Box> chunks;  // room for the boxes of an outline's stretches of kLanes edges
    std::vector<int> edges;   // room for the edges near one vertex

    void clear() {
        walls.clear();
        touches.clear();
    }
};

/// Margin, in D0, of the list of vertices near an obstacle; at most a quarter of its radius, so
/// that nothing passes through an obstacle between two looks.
inline double wall_margin(const Obstacle& o) { return std::min(0.03, 0.25 * o.radius); }

/// How far from a pillar's surface a ring adheres to it.
inline double adhesion_range(const Ring& ring) {
    return ring.constants.adhesion > 0.0 ? adhesion_start(ring) + adhesion_fade(ring) : 0.0;
}

/// How far from an obstacle's surface a vertex feels it. With front tracking it does so on the
/// surface, and next to an obstacle that an edge is to be kept out of.
inline double wall_range(const Ring& ring, const Obstacle& o) {
    const double adhesion = adhesion_range(ring);
    if (!tracks_front(ring)) return std::max(0.5 * ring.rest_length, adhesion);
    return std::max(edge_scale(ring) < kLongEdge * o.radius ? 0.0 : edge_scale(ring), adhesion);
}

/// No vertex feels an obstacle from further away, also when edges have grown a good deal longer.
inline double longest_wall_range(const Ring& ring) {
    const double wall = tracks_front(ring) ? 2.0 * edge_scale(ring) : 0.5 * ring.rest_length;
    return std::max(wall, adhesion_range(ring));
}

/// Lists the vertices of a droplet near an obstacle, which it has met or not; all of them where it
/// adheres, since an edge with one end in range pulls at both. Returns how far they may move while
/// the list stays complete. `distance2` is room for one value a chunk.
inline double list_wall(ContactLists& lists, const Droplet& d, int index, const Obstacle& o,
                        bool met, const double* distance2) {
    const double touch = o.radius + wall_range(d.ring, o), margin = wall_margin(o);
    const int chunks = d.ring.padded / kLanes;
    const double nearest = std::sqrt(*std::min_element(distance2, distance2 + chunks)) - touch;
    if (nearest > margin) return nearest;
    if (d.ring.constants.adhesion > 0.0) {
        lists.walls.push_back({index, 0, d.ring.padded, o, met});
        return margin;
    }
    const double listed = touch + margin;
    for (int c = 0; c < chunks; ++c) {
        if (distance2[c] >= listed * listed) continue;
        int run = 1;
        while (c + run < chunks && distance2[c + run] < listed * listed) ++run;
        lists.walls.push_back({index, c * kLanes, (c + run) * kLanes, o, met});
        c += run;
    }
    return margin;
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

/// The shortest stretch of the n edges round a ring that holds all the given ones, of which there
/// is at least one; they ascend. Of equally short ones the first after edges[some].
inline Run covering_run(int n, const std::vector<int>& edges, std::size_t some) {
    Run run{edges[some], n};
    int before = edges[some];
    for (std::size_t step = 1; step <= edges.size(); ++step) {
        const int edge = edges[(some + step) % edges.size()];
        const int hole = (edge - before - 1 + n) % n;
        if (n - hole < run.count) run = {edge, n - hole};
        before = edge;
    }
    return run;
}

/// Boxes of the stretches of kLanes edges of a ring.
inline void box_chunks(const Ring& ring, std::vector<Box>& out) {
    out.clear();
    for (int first = 0; first < ring.count; first += kLanes) {
        Box box = box_of({ring.x[first], ring.y[first]});
        for (int i = first + 1; i <= std::min(first + kLanes, ring.count); ++i)
            box = {std::min(box.left, ring.x[i]), std::max(box.right, ring.x[i]),
                   std::min(box.bottom, ring.y[i]), std::max(box.top, ring.y[i])};
        out.push_back(box);
    }
}

/// Edges of a ring within a distance of a point, ascending, into lists.edges; returns which of them
/// is the nearest. lists.chunks are the ring's.
inline std::size_t edges_near(ContactLists& lists, const Ring& ring, Vec2 r, double within) {
    lists.edges.clear();
    std::size_t nearest = 0;
    double least2 = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < lists.chunks.size(); ++c) {
        const Box& box = lists.chunks[c];
        const double x = std::max({0.0, box.left - r.x, r.x - box.right});
        const double y = std::max({0.0, box.bottom - r.y, r.y - box.top});
        if (x * x + y * y > within * within) continue;
        const int first = static_cast<int>(c) * kLanes;
        for (int k = first; k < std::min(first + kLanes, ring.count); ++k) {
            const double away2 = edge_distance2(ring, r, k);
            if (std::sqrt(away2) > within) continue;
            if (away2 < least2) {
                least2 = away2;
                nearest = lists.edges.size();
            }
            lists.edges.push_back(k);
        }
    }
    return nearest;
}

/// Lists the vertices of ring a near edges of ring b, whose image is shifted. Each is listed with
/// one stretch of edges round the nearest, since the nearest edge alone tells on which side of a
/// thin part it is. Returns how deep any of them is inside b.
inline double list_touches(ContactLists& lists, const Ring& a, int index_a, const Ring& b,
                           int index_b, const Box& box_b, Vec2 image, double within) {
    double deepest = 0;
    box_chunks(b, lists.chunks);
    const Box wide = grown(box_b, within);
    for (int i = 0; i < a.count; ++i) {
        const Vec2 r = displacement(image, {a.x[i], a.y[i]});
        if (r.x < wide.left || r.x > wide.right || r.y < wide.bottom || r.y > wide.top) continue;
        const std::size_t some = edges_near(lists, b, r, within);
        if (lists.edges.empty()) continue;
        const Nearest nearest = nearest_edge(b, r, lists.edges[some], 1);
        const Run run = covering_run(b.count, lists.edges, some);
        lists.touches.push_back({index_a, i, index_b, run.first, run.count, image.x, image.y});
        deepest = std::min(deepest, nearest.distance);
    }
    return -deepest;
}

/// Length of ring a's outline that is within a distance of ring b, whose image is shifted; along an
/// edge the distance is taken to change evenly. The list from `first` on is that of their touches,
/// just made.
inline double facing_length(ContactLists& lists, std::size_t first, const Ring& a, const Ring& b,
                            Vec2 image, double within) {
    const std::size_t end = lists.touches.size();
    const double far = 3.0 * within;
    const auto listed = [&](std::size_t t) {
        const DropletContact& touch = lists.touches[t];
        const Vec2 r = displacement(image, {a.x[touch.vertex], a.y[touch.vertex]});
        return std::fabs(nearest_edge(b, r, touch.first_edge, touch.edge_count).distance);
    };
    const auto unlisted = [&](int i) {
        const Vec2 r = displacement(image, {a.x[i], a.y[i]});
        const std::size_t some = edges_near(lists, b, r, far);
        return lists.edges.empty() ? far : std::sqrt(edge_distance2(b, r, lists.edges[some]));
    };
    const auto near_part = [&](int edge, double from, double to) {
        const double low = std::min(from, to), high = std::max(from, to);
        if (low >= within) return 0.0;
        const double share = high > within ? (within - low) / (high - low) : 1.0;
        return share * std::hypot(a.x[edge + 1] - a.x[edge], a.y[edge + 1] - a.y[edge]);
    };
    double length = 0;
    for (std::size_t t = first; t < end; ++t) {
        const int i = lists.touches[t].vertex;
        const int vertex_before = before(a, i), vertex_after = after(a, i);
        const std::size_t last = t == first ? end - 1 : t - 1, next = t + 1 == end ? first : t + 1;
        const double here = listed(t);
        if (lists.touches[last].vertex != vertex_before)
            length += near_part(vertex_before, unlisted(vertex_before), here);
        const bool follows = lists.touches[next].vertex == vertex_after;
        length += near_part(i, here, follows ? listed(next) : unlisted(vertex_after));
    }
    return length;
}

/// What a look at two droplets gives: how far vertices may move while the list is complete, and how
/// deep one is inside the other.
struct PairRoom {
    double allowed, depth;
};

/// Lists the vertices of ring a that may touch ring b, whose image is shifted.
inline PairRoom list_pair(ContactLists& lists, const Ring& a, int index_a, const Box& box_a,
                          const Ring& b, int index_b, const Box& box_b, Vec2 image) {
    // A list is built wider than the contact's range by what both sides may move.
    const double margin = 0.5 * touch_of(a, b).length, range = tracks_front(a) ? 0.0 : margin;
    const double apart = gap(box_a, shifted(box_b, image)) - range;
    if (apart > 2.0 * margin) return {0.5 * apart, 0.0};
    return {margin,
            list_touches(lists, a, index_a, b, index_b, box_b, image, range + 2.0 * margin)};
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
