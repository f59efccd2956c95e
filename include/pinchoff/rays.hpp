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
    const auto count = static_cast<std::size_t>(
        std::clamp(length / rule.spacing, double(rule.fewest), double(rule.most)));
    std::vector<Vec2> points(count);
    std::size_t side = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double place = k * (length / count);
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

/// Where the dark rim of a region ends along a ray (samples from its first; NaN where it does
/// not), and its greatest darkness.
struct RimEnd {
    double place;
    float peak;
};

/// It ends where darkness has fallen by a share of what it falls by in all: the local mean, from
/// which darkness counts, depends on what else is near.
///
/// `level` is the least darkness of a rim, `inside` the first sample that is surely on it, `edge`
/// the share, `beyond` the samples within which it gets as bright as outside.
inline RimEnd rim_end(const float* profile, std::size_t samples, float level, float edge,
                      std::size_t inside, std::size_t beyond) {
    float darkest = level;
    std::size_t first = 0;
    for (std::size_t k = 0; k < samples && first == 0; ++k) {
        darkest = std::max(darkest, profile[k]);
        if (k > inside && profile[k] < edge * darkest) first = k;
    }
    if (first == 0) return {std::numeric_limits<double>::quiet_NaN(), darkest};
    float outside = profile[first];
    for (std::size_t k = first; k < std::min(first + beyond, samples); ++k)
        outside = std::min(outside, profile[k]);
    const float target = outside + edge * (darkest - outside);
    std::size_t before = first - 1;  // the last place before there at which it is as dark as that
    while (before > 0 && profile[before] < target) --before;
    const float last = profile[before], here = profile[before + 1];
    const float share = std::clamp((last - target) / std::max(last - here, 1e-6f), 0.0f, 1.0f);
    return {static_cast<double>(before) + share, darkest};
}

/// What a ray shows across the edge of a dark spot.
struct SpotEdge {
    double inner, outer;  // darkness within, and the least beyond the middle
    double steepest;      // change between two samples away from the ends
    double place;         // where it is halfway between both, samples; NaN where nowhere
};

/// `ends` samples at each end count as within and beyond; of several places that nearest to the
/// `middle` (samples from the first) is taken.
inline SpotEdge spot_edge(const float* profile, std::size_t samples, std::size_t ends,
                          double middle) {
    SpotEdge edge{0.0, 0.0, 0.0, std::numeric_limits<double>::quiet_NaN()};
    float sum = 0.0f;
    for (std::size_t k = 0; k < ends; ++k) sum += profile[k];
    const float inner = sum / static_cast<float>(ends);
    const float outer = *std::min_element(profile + samples / 2, profile + samples);
    const float half = 0.5f * (inner + outer);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k + 1 < samples; ++k) {
        const float here = profile[k], after = profile[k + 1];
        if (k >= ends && k + 1 < samples - ends)
            edge.steepest = std::max(edge.steepest, double(std::fabs(after - here)));
        const double away = std::fabs(static_cast<double>(k) + 0.5 - middle);
        if (here > half && !(after > half) && away < nearest) {
            nearest = away;
            const float share = (here - half) / std::max(here - after, 1e-6f);
            edge.place = static_cast<double>(k) + std::clamp(share, 0.0f, 1.0f);
        }
    }
    edge.inner = inner;
    edge.outer = outer;
    return edge;
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
