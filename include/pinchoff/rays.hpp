// Rays across the border of a region in a picture, and where brightness changes along them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "pinchoff/math.hpp"
#include "pinchoff/polygon.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// How the border of a region becomes rays.
struct RaySpacing {
    double spacing;    // of the points, pixels
    int fewest, most;  // points
    double smoothing;  // standard deviation, points
    double margin;     // from the outermost pixels within which a region ends at the frame
};

/// Evenly spaced points round a region, clockwise as seen with y down, with outward normals.
struct RegionBorder {
    std::vector<Vec2> points, normals;
    std::vector<char> at_edge;
};

/// Points spaced evenly along a closed line of any vertices.
inline std::vector<Vec2> evenly_spaced(const std::vector<Vec2>& line, const RaySpacing& rule) {
    const std::size_t n = line.size();
    std::vector<double> along(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        along[i + 1] =
            along[i] + std::hypot(line[(i + 1) % n].x - line[i].x, line[(i + 1) % n].y - line[i].y);
    const double length = along[n];
    // In this order a length that is not a number gives the fewest.
    const auto count = static_cast<std::size_t>(
        std::min<double>(std::max<double>(rule.fewest, length / rule.spacing), rule.most));
    std::vector<Vec2> points(count);
    std::size_t side = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double place = static_cast<double>(k) * (length / static_cast<double>(count));
        while (side + 1 < n && along[side + 1] <= place) ++side;
        const Vec2 a = line[side], b = line[(side + 1) % n];
        const double step = along[side + 1] - along[side];
        const double share = step > 0.0 ? (place - along[side]) / step : 0.0;
        points[k] = {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)};
    }
    return points;
}

/// Points of a closed line, each the Gaussian mean of those about it, but for the `fixed` ones.
inline std::vector<Vec2> smoothed_points(const std::vector<Vec2>& points, double deviation,
                                         const std::vector<char>& fixed) {
    const int reach = static_cast<int>(std::lround(4.0 * deviation));
    std::vector<double> weights(reach + 1);
    double sum = 0.0;
    for (int k = 0; k <= reach; ++k) {
        weights[k] = std::exp(-0.5 * k * k / (deviation * deviation));
        sum += k > 0 ? 2.0 * weights[k] : weights[k];
    }
    const int n = static_cast<int>(points.size());
    std::vector<Vec2> smooth(points);
    for (int i = 0; i < n; ++i) {
        if (fixed[i]) continue;
        Vec2 total{0.0, 0.0};
        for (int k = -reach; k <= reach; ++k) {
            const Vec2 p = points[((i + k) % n + n) % n];
            const double weight = weights[std::abs(k)] / sum;
            total.x += weight * p.x;
            total.y += weight * p.y;
        }
        smooth[i] = total;
    }
    return smooth;
}

/// Rays outwards from the border of a region, (width, height) the frame's; without a frame 0.
inline RegionBorder region_border(const std::vector<Vec2>& line, const RaySpacing& rule,
                                  double width, double height) {
    RegionBorder border;
    std::vector<Vec2> points = evenly_spaced(line, rule);
    const std::size_t n = points.size();
    border.at_edge.assign(n, 0);
    if (width > 0.0)
        for (std::size_t i = 0; i < n; ++i)
            border.at_edge[i] = std::min(points[i].x, points[i].y) <= rule.margin ||
                                points[i].x >= width - 1.0 - rule.margin ||
                                points[i].y >= height - 1.0 - rule.margin;
    points = smoothed_points(points, rule.smoothing, border.at_edge);
    if (signed_area(points) < 0.0) {
        std::reverse(points.begin(), points.end());
        std::reverse(border.at_edge.begin(), border.at_edge.end());
    }
    border.normals.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 after = points[(i + 2) % n], before = points[(i + n - 2) % n];
        const double x = after.x - before.x, y = after.y - before.y;
        const double length = std::max(std::hypot(x, y), 1e-9);
        border.normals[i] = {y / length, -x / length};
    }
    border.points = std::move(points);
    return border;
}

/// Values round a closed line, each the median of those as far as `reach` on either side.
inline std::vector<double> running_median(const std::vector<double>& values, int reach) {
    const int n = static_cast<int>(values.size());
    std::vector<double> found(n), about(2 * reach + 1);
    for (int i = 0; i < n; ++i) {
        for (int k = -reach; k <= reach; ++k) about[k + reach] = values[((i + k) % n + n) % n];
        std::nth_element(about.begin(), about.begin() + reach, about.end());
        found[i] = about[reach];
    }
    return found;
}

/// Grey levels of a picture, row by row.
struct Picture {
    const float* values;
    std::ptrdiff_t height, width;

    /// The nearest place in a row or column of so many pixels; the first where it is no number.
    static double within(double place, std::ptrdiff_t count) {
        return place > 0.0 ? std::min(place, static_cast<double>(count - 1)) : 0.0;
    }

    /// Between the four pixels about a place; beyond the edge as at the edge.
    float at(double x, double y) const {
        x = within(x, width);
        y = within(y, height);
        const auto left =
            std::min(static_cast<std::ptrdiff_t>(x), std::max<std::ptrdiff_t>(width - 2, 0));
        const auto top =
            std::min(static_cast<std::ptrdiff_t>(y), std::max<std::ptrdiff_t>(height - 2, 0));
        const std::ptrdiff_t right = width > 1 ? 1 : 0, below = height > 1 ? width : 0;
        const auto across = static_cast<float>(x - static_cast<double>(left));
        const auto down = static_cast<float>(y - static_cast<double>(top));
        const float* p = values + top * width + left;
        const float upper = p[0] + across * (p[right] - p[0]);
        const float lower = p[below] + across * (p[below + right] - p[below]);
        return upper + down * (lower - upper);
    }
};

/// A ray through a picture, sampled in even steps.
struct Ray {
    Vec2 from, along;  // the first sample, and from one to the next
    float at(const Picture& picture, std::size_t sample) const {
        const auto k = static_cast<double>(sample);
        return picture.at(from.x + k * along.x, from.y + k * along.y);
    }
};

/// What a ray shows across the dark rim of a region.
struct RimEnd {
    double place;       // where the rim ends, samples from the first; NaN where it does not
    float first, peak;  // darkness of the first sample, and the greatest of the rim
};

/// How the end of a rim is told.
struct RimRule {
    float level;  // least darkness of a rim
    float edge;   // share of what darkness falls by, at which it ends
    std::size_t inside, beyond,
        samples;  // surely on the rim; in which it gets as bright as outside
};

/// It ends where darkness has fallen by a share of what it falls by in all: the local mean, from
/// which darkness counts, depends on what else is near.
inline RimEnd rim_end(const Picture& dark, const Ray& ray, const RimRule& rule,
                      std::vector<float>& profile) {
    float darkest = rule.level;
    std::size_t end = 0;
    profile.resize(rule.samples);
    for (std::size_t k = 0; k < rule.samples && end == 0; ++k) {
        profile[k] = ray.at(dark, k);
        darkest = std::max(darkest, profile[k]);
        if (k > rule.inside && profile[k] < rule.edge * darkest) end = k;
    }
    if (end == 0) return {std::numeric_limits<double>::quiet_NaN(), profile[0], darkest};
    float outside = profile[end];
    for (std::size_t k = end + 1; k < std::min(end + rule.beyond, rule.samples); ++k)
        outside = std::min(outside, ray.at(dark, k));
    const float target = outside + rule.edge * (darkest - outside);
    std::size_t before = end - 1;  // the last place before there at which it is as dark as that
    while (before > 0 && profile[before] < target) --before;
    const float last = profile[before], here = profile[before + 1];
    const float share = std::clamp((last - target) / std::max(last - here, 1e-6f), 0.0f, 1.0f);
    return {static_cast<double>(before) + static_cast<double>(share), profile[0], darkest};
}

/// What a ray shows across the edge of a dark spot.
struct SpotEdge {
    double inner, outer;  // darkness within, and the least beyond the middle
    double beyond;        // at a place beyond
    double steepest;      // change between two samples away from the ends
    double place;         // where it is halfway between both, samples; NaN where nowhere
};

/// Where along a ray across the edge of a spot things are, samples from the first.
struct SpotRule {
    std::size_t samples, ends, beyond;  // in all; at each end; where another part may go on
    double middle;                      // of several edges the nearest to it is taken
};

inline SpotEdge spot_edge(const Picture& dark, const Ray& ray, const SpotRule& rule,
                          std::vector<float>& profile) {
    SpotEdge edge{0.0, 0.0, 0.0, 0.0, std::numeric_limits<double>::quiet_NaN()};
    profile.resize(rule.samples);
    for (std::size_t k = 0; k < rule.samples; ++k) profile[k] = ray.at(dark, k);
    float sum = 0.0f;
    for (std::size_t k = 0; k < rule.ends; ++k) sum += profile[k];
    const float inner = sum / static_cast<float>(rule.ends);
    const auto half_way = static_cast<std::ptrdiff_t>(rule.samples / 2);
    const float outer = *std::min_element(profile.begin() + half_way, profile.end());
    const float half = 0.5f * (inner + outer);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k + 1 < rule.samples; ++k) {
        const float here = profile[k], after = profile[k + 1];
        if (k >= rule.ends && k + 1 < rule.samples - rule.ends)
            edge.steepest = std::max(edge.steepest, static_cast<double>(std::fabs(after - here)));
        const double away = std::fabs(static_cast<double>(k) + 0.5 - rule.middle);
        if (here > half && !(after > half) && away < nearest) {
            nearest = away;
            const float share =
                std::clamp((here - half) / std::max(here - after, 1e-6f), 0.0f, 1.0f);
            edge.place = static_cast<double>(k) + static_cast<double>(share);
        }
    }
    edge.inner = inner;
    edge.outer = outer;
    edge.beyond = profile[std::min(rule.beyond, rule.samples - 1)];
    return edge;
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
