// A droplet cut in two along its neck, and outlines re-spaced to a sound number of vertices.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "neck.hpp"
#include "polygon.hpp"

namespace pinchoff {

/// A chord between two vertices, first < second.
struct Neck {
    double thickness = std::numeric_limits<double>::infinity();
    int first = -1, second = -1;
};

/// The thinnest admissible chord. Among chords equally thin to one part in 10⁶ (a symmetric droplet
/// has them in mirrored pairs) the one with the longer shorter arc, then the first.
inline Neck find_neck(Outline r, Separation separation) {
    const std::size_t n = r.size();
    std::vector<double> arc(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 e = next_vertex(r, i) - r[i];
        arc[i + 1] = arc[i] + std::sqrt(dot(e, e));
    }
    const double perimeter = arc[n], least_arc = separation.fraction * perimeter + separation.length;
    const auto shorter_arc = [&](std::size_t i, std::size_t j) {
        const double s = arc[j] - arc[i];
        return std::min(s, perimeter - s);
    };
    const auto chord2 = [&](std::size_t i, std::size_t j) { return dot(r[j] - r[i], r[j] - r[i]); };

    double least2 = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            if (shorter_arc(i, j) > least_arc) least2 = std::min(least2, chord2(i, j));
    Neck neck;
    double longest = 0;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
            const double s = shorter_arc(i, j);
            if (s > least_arc && chord2(i, j) <= least2 * (1.0 + 2e-6) && s > longest * (1.0 + 1e-9)) {
                longest = s;
                neck = {std::sqrt(chord2(i, j)), static_cast<int>(i), static_cast<int>(j)};
            }
        }
    return neck;
}

/// Positions and velocities of one outline.
struct Shape {
    std::vector<Vec2> r, v;
};

/// The two sides of a chord; each keeps both of its ends, so that their areas add up exactly.
inline std::pair<Shape, Shape> cut(const Shape& s, const Neck& neck) {
    Shape one, two;
    const int n = static_cast<int>(s.r.size());
    for (int i = neck.first; i <= neck.second; ++i) {
        one.r.push_back(s.r[i]);
        one.v.push_back(s.v[i]);
    }
    for (int i = neck.second; i <= neck.first + n; ++i) {
        two.r.push_back(s.r[i % n]);
        two.v.push_back(s.v[i % n]);
    }
    return {one, two};
}

/// The same outline with `count` vertices evenly spaced along it, velocities interpolated; then
/// scaled and shifted by the little that the cut corners cost, so that area and centroid stay.
inline Shape respace(const Shape& s, int count) {
    const Outline old(s.r);
    const std::size_t n = old.size();
    const double spacing = perimeter(old) / count;
    Shape out;
    double walked = 0;
    std::size_t edge = 0;
    double length = std::sqrt(dot(next_vertex(old, 0) - old[0], next_vertex(old, 0) - old[0]));
    for (int k = 0; k < count; ++k) {
        while (edge + 1 < n && walked + length < k * spacing) {
            walked += length;
            ++edge;
            const Vec2 e = next_vertex(old, edge) - old[edge];
            length = std::sqrt(dot(e, e));
        }
        const double t = std::min((k * spacing - walked) / length, 1.0);
        const std::size_t next = edge + 1 == n ? 0 : edge + 1;
        out.r.push_back(old[edge] + t * (old[next] - old[edge]));
        out.v.push_back(s.v[edge] + t * (s.v[next] - s.v[edge]));
    }
    const double scale = std::sqrt(signed_area(old) / signed_area(out.r));
    const Vec2 from = centroid(out.r), to = centroid(old);
    for (Vec2& r : out.r) r = to + scale * (r - from);
    return out;
}

inline Vec2 mean(const std::vector<Vec2>& v) {
    Vec2 sum{0, 0};
    for (const Vec2& a : v) sum = sum + a;
    return (1.0 / v.size()) * sum;
}

}  // namespace pinchoff
