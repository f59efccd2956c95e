// Looks over the vertices of one droplet between blocks of steps: extents, speeds, distances.
#pragma once

#include <cmath>

#include "math.hpp"
#include "polygon.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

inline void survey(const Ring& ring, Survey& out) {
    const double *x = ring.x, *y = ring.y, *vx = ring.vx, *vy = ring.vy;
    Lanes speed2{}, relative2{}, reach{};
    Lanes left = load(x), right = left, bottom = load(y), top = bottom;
    double perimeter = 0;
    for (int i = 0; i < ring.padded; i += kWidth) {
        const Lanes u = load(vx + i), v = load(vy + i), du = u - ring.drift_x,
                    dv = v - ring.drift_y;
        speed2 = larger(u * u + v * v, speed2);
        relative2 = larger(du * du + dv * dv, relative2);
        reach += load(x + i) * load(x + i) + load(y + i) * load(y + i);
        left = smaller(load(x + i), left);
        right = larger(load(x + i), right);
        bottom = smaller(load(y + i), bottom);
        top = larger(load(y + i), top);
    }
    for (int i = 0; i < ring.count; ++i) {
        const double ex = x[i + 1] - x[i], ey = y[i + 1] - y[i];
        perimeter += std::sqrt(ex * ex + ey * ey);
    }
    out = {signed_area(ring),       perimeter,
           std::sqrt(most(speed2)), std::sqrt(most(relative2)),
           std::sqrt(sum(reach)),   {least(left), most(right), least(bottom), most(top)}};
}

/// Square of the distance from a point to the nearest vertex of every chunk: out (padded/kLanes).
inline void chunk_distance2(const Ring& ring, double px, double py, double* out) {
    for (int first = 0; first < ring.padded; first += kLanes) {
        Lanes nearest2 = Lanes{} + 1e300;
        for (int i = first; i < first + kLanes; i += kWidth) {
            const Lanes dx = load(ring.x + i) - px, dy = load(ring.y + i) - py;
            nearest2 = smaller(dx * dx + dy * dy, nearest2);
        }
        out[first / kLanes] = least(nearest2);
    }
}

/// Square of the distance from a point to the nearest edge.
inline double edge_distance2(const Ring& ring, double px, double py) {
    Lanes nearest2 = Lanes{} + 1e300;
    for (int i = 0; i < ring.padded; i += kWidth) {
        const Lanes ax = load(ring.x + i), ay = load(ring.y + i);
        const Lanes ex = load(ring.x + i + 1) - ax, ey = load(ring.y + i + 1) - ay;
        const Lanes along = -((ax - px) * ex + (ay - py) * ey) / (ex * ex + ey * ey);
        const Lanes t = smaller(larger(along, Lanes{}), Lanes{} + 1.0);
        const Lanes dx = ax - px + t * ex, dy = ay - py + t * ey;
        nearest2 = smaller(dx * dx + dy * dy, nearest2);
    }
    return least(nearest2);
}

/// Whether a point is inside the ring: an odd number of edges crosses the ray from it along +x.
inline bool contains(const Ring& ring, double px, double py) {
    const double* x = ring.x;
    const double* y = ring.y;
    int crossings = 0;
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.count; ++i) {
        const int straddles = static_cast<int>(y[i] > py) ^ static_cast<int>(y[i + 1] > py);
        const double ahead = (x[i] - px) * (y[i + 1] - y[i]) + (x[i + 1] - x[i]) * (py - y[i]);
        crossings += straddles & static_cast<int>((ahead > 0.0) == (y[i + 1] > y[i]));
    }
    return crossings % 2 == 1;
}

/// Largest Σ|v - v_drift|² of any vertex over the block.
inline double largest_path(const Ring& ring) {
    double longest = 0;
    for (int i = 0; i < ring.count; ++i) {
        // Not-a-number must win, so that the block is not taken for a safe one.
        if (!(ring.path[i] <= longest)) longest = ring.path[i];
    }
    return longest;
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
            crossings += static_cast<int>(sides_of_ab < 0.0) & static_cast<int>(sides_of_cd < 0.0);
        }
        if (crossings > 0) return true;
    }
    return false;
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
