// Two outlines that face each other, opened there and joined to one.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "split.hpp"

namespace pinchoff {

/// Square of the distance from a point to the edge of an outline that starts at a vertex.
inline double edge_distance2(Outline r, std::size_t edge, Vec2 point) {
    const Vec2 e = next_vertex(r, edge) - r[edge], to = point - r[edge];
    const double t = std::clamp(dot(to, e) / dot(e, e), 0.0, 1.0);
    const Vec2 apart = to - t * e;
    return dot(apart, apart);
}

/// The edge of an outline that is nearest to a point, with the square of its distance.
struct NearEdge {
    int edge = 0;
    double distance2 = std::numeric_limits<double>::infinity();
};

inline NearEdge near_edge(Outline r, Vec2 point) {
    NearEdge near;
    for (std::size_t k = 0; k < r.size(); ++k) {
        const double distance2 = edge_distance2(r, k, point);
        if (distance2 < near.distance2) near = {static_cast<int>(k), distance2};
    }
    return near;
}

/// Consecutive vertices of a closed outline.
struct Stretch {
    int first = 0, count = 0;
};

/// The longest stretch of an outline whose vertices are within a distance of another; at most half
/// of the outline, about the stretch's middle.
inline Stretch facing_stretch(Outline r, Outline other, double within) {
    const int n = static_cast<int>(r.size());
    std::vector<char> near(n);
    for (int i = 0; i < n; ++i) near[i] = near_edge(other, r[i]).distance2 < within * within;
    Stretch longest;
    for (int start = 0; start < n; ++start) {
        if (!near[start] || (near[(start + n - 1) % n] && start > 0)) continue;
        int count = 0;
        while (count < n && near[(start + count) % n]) ++count;
        if (count > longest.count) longest = {start, count};
    }
    if (const int spare = longest.count - n / 2; spare > 0)
        longest = {(longest.first + spare / 2) % n, n / 2};
    return longest;
}

/// The vertex that is nearest to another outline.
inline int nearest_vertex(Outline r, Outline other) {
    int nearest = 0;
    double least2 = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < r.size(); ++i)
        if (const double d2 = near_edge(other, r[i]).distance2; d2 < least2) {
            least2 = d2;
            nearest = static_cast<int>(i);
        }
    return nearest;
}

/// What an outline has opposite a stretch of another: the vertices on both sides of the nearest
/// edge as far as they are within a distance, but no more than a quarter of the outline on each
/// side. An empty stretch opens that edge.
inline Stretch opposite_stretch(Outline r, Outline other, const Stretch& taken, double within) {
    const int n = static_cast<int>(r.size()), m = static_cast<int>(other.size());
    const int middle = (taken.first + taken.count / 2) % m;
    const int edge = near_edge(r, other[middle]).edge;
    const auto near = [&](int i) {
        for (int k = -1; k < taken.count; ++k)
            if (edge_distance2(other, (taken.first + k + m) % m, r[(i + n) % n]) < within * within)
                return true;
        return false;
    };
    int before = 0, after = 0;
    while (before < n / 4 && near(edge - before)) ++before;
    while (after < n / 4 && near(edge + 1 + after)) ++after;
    return {(edge + 1 - before + n) % n, before + after};
}

/// Adds the vertices of an outline that are not in a stretch, in order, from behind it on.
inline void add_rest(Shape& to, const Shape& from, const Stretch& opened) {
    const int n = static_cast<int>(from.r.size());
    for (int k = opened.count; k < n; ++k) {
        const int i = (opened.first + k) % n;
        to.add(from.r[i], from.v[i]);
    }
}

/// Two shapes as one: `bridge` is the number of the vertex opposite to the first one across the
/// place where they were joined.
struct Joined {
    Shape shape;
    int bridge;
};

/// Opens both outlines where they are within a distance of each other, or where they are nearest,
/// and joins what is left, with `count` even vertices round the sum of both areas.
inline Joined join(const Shape& a, const Shape& b, double within, int count) {
    Stretch of_a = facing_stretch(a.r, b.r, within), of_b;
    if (of_a.count > 0) {
        of_b = opposite_stretch(b.r, a.r, of_a, within);
    } else {
        of_b = facing_stretch(b.r, a.r, within);
        if (of_b.count == 0) of_b = {nearest_vertex(b.r, a.r), 1};
        of_a = opposite_stretch(a.r, b.r, of_b, within);
    }
    Shape whole;
    add_rest(whole, a, of_a);
    const std::size_t of_first = whole.r.size();
    add_rest(whole, b, of_b);
    const Outline r(whole.r);
    double arc = 0, to_bridge = 0;
    for (std::size_t k = 0; k < r.size(); ++k) {
        const Vec2 e = next_vertex(r, k) - r[k];
        arc += std::sqrt(dot(e, e));
        if (k + 2 == of_first) to_bridge = arc;
    }
    const int bridge = static_cast<int>(std::lround(to_bridge / arc * count));
    Joined joined{respace(whole, count), std::clamp(bridge, 1, count - 1)};
    scale_to_area(joined.shape, signed_area(a.r) + signed_area(b.r));
    return joined;
}

/// Whether a neck of an outline of n vertices is at its bridge, which is between vertex 0 and
/// another: its ends are no further from these than a quarter of the smaller side.
inline bool at_bridge(const Neck& neck, int bridge, int n) {
    const int reach = std::min(bridge, n - bridge) / 4;
    const auto away = [n](int i, int j) {
        const int steps = std::abs(i - j);
        return std::min(steps, n - steps);
    };
    return (away(neck.first, 0) <= reach && away(neck.second, bridge) <= reach) ||
           (away(neck.second, 0) <= reach && away(neck.first, bridge) <= reach);
}

}  // namespace pinchoff
