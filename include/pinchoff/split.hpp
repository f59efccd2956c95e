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

/// Whether the chord between two vertices of a counter-clockwise outline lies inside it: it leaves
/// both inwards, as in `scan_neck`, and crosses no edge.
inline bool chord_inside(Outline r, std::size_t i, std::size_t j) {
    const std::size_t n = r.size();
    const Vec2 chord = r[j] - r[i];
    const auto along = [&](std::size_t k) { return next_vertex(r, k) - r[k == 0 ? n - 1 : k - 1]; };
    if (!(cross(along(i), chord) > 0.0 && cross(chord, along(j)) > 0.0)) return false;
    for (std::size_t k = 0; k < n; ++k) {
        const Vec2 a = r[k] - r[i], b = next_vertex(r, k) - r[i], edge = b - a;
        const bool astride = cross(chord, a) * cross(chord, b) < 0.0;
        const bool between = cross(edge, Vec2{0, 0} - a) * cross(edge, chord - a) < 0.0;
        if (astride && between) return false;
    }
    return true;
}

/// The thinnest admissible chord of a counter-clockwise outline that lies inside it. Among chords
/// equally thin to one part in 10⁶ (a symmetric droplet has them in mirrored pairs) the one with
/// the longer shorter arc, then the first.
inline Neck find_neck(Outline r, Separation separation) {
    const std::size_t n = r.size();
    std::vector<double> arc(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 e = next_vertex(r, i) - r[i];
        arc[i + 1] = arc[i] + std::sqrt(dot(e, e));
    }
    const double perimeter = arc[n],
                 least_arc = separation.fraction * perimeter + separation.length;
    const auto shorter_arc = [&](std::size_t i, std::size_t j) {
        const double s = arc[j] - arc[i];
        return std::min(s, perimeter - s);
    };
    const auto chord2 = [&](std::size_t i, std::size_t j) { return dot(r[j] - r[i], r[j] - r[i]); };

    double least2 = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            if (shorter_arc(i, j) > least_arc && chord2(i, j) < least2 && chord_inside(r, i, j))
                least2 = chord2(i, j);
    Neck neck;
    double longest = 0;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
            const double s = shorter_arc(i, j);
            if (s > least_arc && chord2(i, j) <= least2 * (1.0 + 2e-6) &&
                s > longest * (1.0 + 1e-9) && chord_inside(r, i, j)) {
                longest = s;
                neck = {std::sqrt(chord2(i, j)), static_cast<int>(i), static_cast<int>(j)};
            }
        }
    return neck;
}

/// A point on the outline: `fraction` of the way along the edge that starts at vertex `edge`.
struct OutlinePoint {
    int edge;
    double fraction;
};

/// The line along which a droplet is cut.
struct Cut {
    OutlinePoint first, second;
};

template <class Values>
Vec2 point_on(const Values& at_vertices, OutlinePoint p) {
    const int next = (p.edge + 1) % static_cast<int>(at_vertices.size());
    return at_vertices[p.edge] + p.fraction * (at_vertices[next] - at_vertices[p.edge]);
}

/// Where between the vertices the neck is thinnest: the lowest point of a parabola through the
/// neck's chord and two neighbours, which move both of its ends along their arcs, or one of them,
/// whichever has the thinnest neighbour. Two equally thin chords, as a head-on collision has, so
/// give the line midway between them.
inline Cut place_cut(Outline r, const Neck& neck) {
    const int n = static_cast<int>(r.size());
    const auto thickness = [&](int first, int second) {
        const Vec2 chord = r[(neck.second + second + n) % n] - r[(neck.first + first + n) % n];
        return std::sqrt(dot(chord, chord));
    };
    constexpr int kDirections[3][2] = {{1, -1}, {1, 0}, {0, 1}};
    const double here = thickness(0, 0);
    double thinnest = std::numeric_limits<double>::infinity(), shifts[2] = {0.0, 0.0};
    for (const auto& [first, second] : kDirections) {
        const double before = thickness(-first, -second), after = thickness(first, second);
        const double curvature = before - 2.0 * here + after;
        // A neighbour thinner than the neck is one that is not admissible: then stay.
        const bool lowest = std::min(before, after) >= here * (1.0 - 1e-9) && curvature > 0.0;
        if (!lowest || std::min(before, after) >= thinnest) continue;
        thinnest = std::min(before, after);
        const double shift = std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
        shifts[0] = first * shift;
        shifts[1] = second * shift;
    }
    const auto moved = [&](int vertex, double shift) -> OutlinePoint {
        if (shift >= 0.0) return {vertex, shift};
        return {(vertex - 1 + n) % n, 1.0 + shift};
    };
    return {moved(neck.first, shifts[0]), moved(neck.second, shifts[1])};
}

/// Positions and velocities of one outline.
struct Shape {
    std::vector<Vec2> r, v;

    void add(Vec2 position, Vec2 velocity) {
        r.push_back(position);
        v.push_back(velocity);
    }
};

/// The vertices from one point of the outline to another, both points included.
inline Shape part_between(const Shape& s, OutlinePoint from, OutlinePoint to) {
    const int n = static_cast<int>(s.r.size());
    Shape part;
    part.add(point_on(s.r, from), point_on(s.v, from));
    for (int i = (from.edge + 1) % n;; i = (i + 1) % n) {
        // A cut through a vertex must not leave that vertex there twice.
        const bool doubled = (i == (from.edge + 1) % n && from.fraction == 1.0) ||
                             (i == to.edge && to.fraction == 0.0);
        if (!doubled) part.add(s.r[i], s.v[i]);
        if (i == to.edge) break;
    }
    part.add(point_on(s.r, to), point_on(s.v, to));
    return part;
}

/// The two sides of a cut; each keeps both of its ends, so that their areas add up exactly.
inline std::pair<Shape, Shape> cut(const Shape& s, const Cut& line) {
    return {part_between(s, line.first, line.second), part_between(s, line.second, line.first)};
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

/// Where the edges from two vertices on, first < second, cross.
struct Crossing {
    int first = -1, second = -1;
    Vec2 place{0, 0};
};

inline Crossing find_crossing(Outline r) {
    const int n = static_cast<int>(r.size());
    for (int i = 0; i + 2 < n; ++i) {
        const Vec2 a = r[i], e = r[i + 1] - a;
        for (int j = i + 2; j < (i == 0 ? n - 1 : n); ++j) {
            const Vec2 c = r[j], f = next_vertex(r, j) - c;
            const double turn = cross(e, f);
            if (turn == 0.0) continue;
            const double s = cross(c - a, f) / turn, t = cross(c - a, e) / turn;
            if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) return {i, j, a + s * e};
        }
    }
    return {};
}

/// An outline without the small loops in which it crosses itself: of the two parts at a crossing
/// the larger one stays.
inline Shape untangled(Shape s) {
    constexpr int kMostLoops = 8;
    for (int loop = 0; loop < kMostLoops; ++loop) {
        const Crossing at = find_crossing(s.r);
        if (at.first < 0) break;
        const int n = static_cast<int>(s.r.size());
        Shape inner, outer;
        inner.add(at.place, s.v[at.first]);
        for (int i = at.first + 1; i <= at.second; ++i) inner.add(s.r[i], s.v[i]);
        outer.add(at.place, s.v[at.first]);
        for (int i = at.second + 1; i <= n + at.first; ++i) outer.add(s.r[i % n], s.v[i % n]);
        s = signed_area(inner.r) > signed_area(outer.r) ? std::move(inner) : std::move(outer);
    }
    return s;
}

/// Scales an outline about its centroid.
inline void scale_to_area(Shape& s, double area) {
    const double scale = std::sqrt(area / signed_area(s.r));
    const Vec2 middle = centroid(s.r);
    for (Vec2& p : s.r) p = middle + scale * (p - middle);
}

inline Vec2 mean(const std::vector<Vec2>& v) {
    Vec2 sum{0, 0};
    for (const Vec2& a : v) sum = sum + a;
    return (1.0 / static_cast<double>(v.size())) * sum;
}

}  // namespace pinchoff
