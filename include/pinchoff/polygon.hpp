// Geometry of one closed outline: the only place where these quantities are computed, for
// simulated and filmed droplets alike. An outline is a list of vertices; the last joins the first.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "math.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

using Outline = std::span<const Vec2>;

inline Vec2 next_vertex(Outline r, std::size_t i) { return r[i + 1 == r.size() ? 0 : i + 1]; }

inline double mean(const double* values, int count) {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += values[i];
    return sum / count;
}

/// Area, positive when the vertices run counter-clockwise. Taken about the first vertex, so that it
/// keeps its digits far from the origin.
inline double signed_area(Outline r) {
    double twice = 0;
    for (std::size_t i = 1; i + 1 < r.size(); ++i) twice += cross(r[i] - r[0], r[i + 1] - r[0]);
    return 0.5 * twice;
}

/// The same of a ring as the time step has it, in whole registers; about the origin, which is near
/// enough for a step.
inline double signed_area(const Ring& ring) {
    const double *x = ring.x, *y = ring.y;
    const int whole = ring.count / kLanes * kLanes;
    Lanes lanes{};
    for (int i = 0; i < whole; i += kWidth)
        lanes += load(x + i) * load(y + i + 1) - load(x + i + 1) * load(y + i);
    double twice = sum(lanes);
    for (int i = whole; i < ring.count; ++i) twice += x[i] * y[i + 1] - x[i + 1] * y[i];
    return 0.5 * twice;
}

/// Least distance of the edges from a point.
inline double distance_to(Outline r, Vec2 point) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < r.size(); ++i) {
        const Vec2 from = r[i] - point, edge = next_vertex(r, i) - r[i];
        const double squared = dot(edge, edge);
        const double share = squared > 0.0 ? std::clamp(-dot(from, edge) / squared, 0.0, 1.0) : 0.0;
        const Vec2 nearest = from + share * edge;
        least = std::min(least, dot(nearest, nearest));
    }
    return std::sqrt(least);
}

inline double perimeter(Outline r) {
    double sum = 0;
    for (std::size_t i = 0; i < r.size(); ++i) {
        const Vec2 e = next_vertex(r, i) - r[i];
        sum += std::sqrt(dot(e, e));
    }
    return sum;
}

/// Centre of mass of the enclosed area [paper, eqs. of appendix B].
inline Vec2 centroid(Outline r) {
    Vec2 sum{0, 0};
    double twice = 0;
    for (std::size_t i = 1; i + 1 < r.size(); ++i) {
        const Vec2 a = r[i] - r[0], b = r[i + 1] - r[0];
        const double w = cross(a, b);
        twice += w;
        sum = sum + w * (a + b);
    }
    return r[0] + (1.0 / (3.0 * twice)) * sum;
}

/// Velocity of that centre of mass when the vertices move with `v`: its exact time derivative.
inline Vec2 centroid_velocity(Outline r, std::span<const Vec2> v) {
    Vec2 sum{0, 0}, rate{0, 0};
    double twice = 0, twice_rate = 0;
    for (std::size_t i = 1; i + 1 < r.size(); ++i) {
        const Vec2 a = r[i] - r[0], b = r[i + 1] - r[0];
        const Vec2 va = v[i] - v[0], vb = v[i + 1] - v[0];
        const double w = cross(a, b), w_rate = cross(va, b) + cross(a, vb);
        twice += w;
        twice_rate += w_rate;
        sum = sum + w * (a + b);
        rate = rate + w_rate * (a + b) + w * (va + vb);
    }
    const double scale = 1.0 / (3.0 * twice);
    return v[0] + scale * rate - (twice_rate / twice * scale) * sum;
}

/// Shape parameter 𝒜 = P²/(4πA), 1 for a circle [paper, appendix B].
inline double shape_parameter(double perimeter, double area) {
    return perimeter * perimeter / (4.0 * kPi * std::fabs(area));
}

inline double shape_parameter(Outline r) { return shape_parameter(perimeter(r), signed_area(r)); }

/// Signed area of the part on the left of the line through `point` along `direction`, by exact
/// clipping of every edge; right for outlines that the line cuts into any number of parts.
inline double area_left_of(Outline r, Vec2 point, Vec2 direction) {
    double twice = 0;
    for (std::size_t i = 0; i < r.size(); ++i) {
        // Coordinates relative to the line's point: the pieces of the line itself then add nothing.
        Vec2 a = r[i] - point, b = next_vertex(r, i) - point;
        const double ha = cross(direction, a), hb = cross(direction, b);
        if (ha <= 0.0 && hb <= 0.0) continue;
        if (ha < 0.0 || hb < 0.0) {
            const Vec2 on_line = a + (ha / (ha - hb)) * (b - a);
            if (ha < 0.0) a = on_line;
            else b = on_line;
        }
        twice += cross(a, b);
    }
    return 0.5 * twice;
}

/// Symmetry S = 1 - (A_large - A_small)/A about the line through the obstacle's centre along the
/// droplet's velocity [paper, eq. symdef]: 1 head-on, 0 when all of the droplet is on one side.
inline double symmetry(Outline r, Vec2 obstacle, Vec2 velocity) {
    const double left = area_left_of(r, obstacle, velocity) / signed_area(r);
    const double smaller_part = left < 0.5 ? left : 1.0 - left;
    return smaller_part > 0.0 ? 2.0 * smaller_part : 0.0;
}

/// Impact parameter b = |r_cc × v|/|v| [paper, eq. for b].
inline double impact_parameter(Outline r, Vec2 obstacle, Vec2 velocity) {
    return std::fabs(cross(centroid(r) - obstacle, velocity)) / std::sqrt(dot(velocity, velocity));
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
