// Looks over the vertices of one droplet between blocks of steps: extents, speeds, distances.
//
// Reductions keep kLanes running values, which compilers vectorise without flags that would let
// them forget about numbers that are not finite.
#pragma once

#include <cmath>

#include "math.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

inline double larger(double a, double b) { return a > b ? a : b; }
inline double smaller(double a, double b) { return a < b ? a : b; }

inline void survey(const Ring& ring, Survey& out) {
    double area[kLanes] = {}, perimeter[kLanes] = {}, speed[kLanes] = {}, relative[kLanes] = {},
           reach[kLanes] = {};
    for (int i = 0; i < ring.padded; i += kLanes) {
        const double* x = ring.x + i;
        const double* y = ring.y + i;
        const double* vx = ring.vx + i;
        const double* vy = ring.vy + i;
        PINCHOFF_INDEPENDENT
        for (int l = 0; l < kLanes; ++l) {
            const double counts = i + l < ring.count ? 1.0 : 0.0;
            const Vec2 e{x[l + 1] - x[l], y[l + 1] - y[l]};
            const Vec2 rel{vx[l] - ring.drift_x, vy[l] - ring.drift_y};
            area[l] += counts * (x[l] * y[l + 1] - x[l + 1] * y[l]);
            perimeter[l] += counts * std::sqrt(dot(e, e));
            speed[l] = larger(speed[l], vx[l] * vx[l] + vy[l] * vy[l]);
            relative[l] = larger(relative[l], dot(rel, rel));
            reach[l] += std::fabs(x[l]) + std::fabs(y[l]);
        }
    }
    out = {0, 0, 0, 0, 0};
    for (int l = 0; l < kLanes; ++l) {
        out.area += 0.5 * area[l];
        out.perimeter += perimeter[l];
        out.speed = larger(out.speed, speed[l]);
        out.relative_speed = larger(out.relative_speed, relative[l]);
        out.reach += reach[l];
    }
    out.speed = std::sqrt(out.speed);
    out.relative_speed = std::sqrt(out.relative_speed);
}

/// Square of the distance from a point to the nearest vertex of every chunk: out (padded/kLanes).
inline void chunk_distance2(const Ring& ring, double px, double py, double* out) {
    for (int i = 0; i < ring.padded; i += kLanes) {
        const double* x = ring.x + i;
        const double* y = ring.y + i;
        double d2[kLanes];
        PINCHOFF_INDEPENDENT
        for (int l = 0; l < kLanes; ++l) d2[l] = (x[l] - px) * (x[l] - px) + (y[l] - py) * (y[l] - py);
        double least = d2[0];
        for (int l = 1; l < kLanes; ++l) least = smaller(least, d2[l]);
        out[i / kLanes] = least;
    }
}

/// Square of the distance from a point to the nearest edge.
inline double edge_distance2(const Ring& ring, double px, double py) {
    double least[kLanes];
    for (double& l : least) l = 1e300;
    for (int i = 0; i < ring.padded; i += kLanes) {
        const double* x = ring.x + i;
        const double* y = ring.y + i;
        PINCHOFF_INDEPENDENT
        for (int l = 0; l < kLanes; ++l) {
            const Vec2 a{x[l] - px, y[l] - py}, e{x[l + 1] - x[l], y[l + 1] - y[l]};
            const double along = -dot(a, e) / dot(e, e);
            const double t = smaller(larger(along, 0.0), 1.0);
            const Vec2 off = a + t * e;
            least[l] = smaller(dot(off, off), least[l]);
        }
    }
    double all = least[0];
    for (int l = 1; l < kLanes; ++l) all = smaller(all, least[l]);
    return all;
}

/// Largest Σ|v - v_drift|² of any vertex over the block, and its reset.
inline double largest_path(const Ring& ring) {
    double most = 0;
    for (int i = 0; i < ring.count; ++i) {
        // Not-a-number must win, so that the block is not taken for a safe one.
        if (!(ring.path[i] <= most)) most = ring.path[i];
    }
    return most;
}

/// Whether any two edges that do not share a vertex cross. x, y: (count + 1), the last repeats the
/// first. Touching does not count.
inline bool self_intersects(const double* x, const double* y, int count) {
    for (int i = 0; i + 2 < count; ++i) {
        const Vec2 a{x[i], y[i]}, b{x[i + 1], y[i + 1]}, e = b - a;
        const int last = i == 0 ? count - 1 : count;  // edge count-1 shares vertex 0 with edge 0
        int crossings = 0;
        PINCHOFF_INDEPENDENT
        for (int j = i + 2; j < last; ++j) {
            const Vec2 c{x[j], y[j]}, d{x[j + 1], y[j + 1]}, f = d - c;
            const double sides_of_ab = cross(e, c - a) * cross(e, d - a);
            const double sides_of_cd = cross(f, a - c) * cross(f, b - c);
            crossings += (sides_of_ab < 0.0) & (sides_of_cd < 0.0) ? 1 : 0;
        }
        if (crossings > 0) return true;
    }
    return false;
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
