// Outlines of droplets traced about their centres, in polar coordinates.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "pinchoff/rays.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// How outlines are traced.
struct PolarRule {
    int rays, steps;           // directions, and radii on each
    double nearest, farthest;  // of the radii, in those of the circle; a geometric series
    int window;                // steps inside and outside of an edge that are compared; odd
    int bend;                  // most steps between neighbouring rays
    float bending;             // contrast that a step of bend has to be worth
    float clear;               // contrast above which an edge is no better
    float dim;                 // grey levels below which brightening counts for less
};

/// One point of a traced outline.
struct PolarPoint {
    double reach;                  // from the centre, in radii of the circle
    float contrast, inner, outer;  // brightening over the sum of both sides; both sides
};

/// The closed path that collects the most contrast: of every ray one step, no more than `bend`
/// steps from that of the ray before.
///
/// It starts a quarter turn early and ends one late, so that the turn between is closed; of equal
/// paths the straighter is taken.
class ClosedPath {
public:
    explicit ClosedPath(const PolarRule& rule)
        : rule_(rule), early_(rule.rays / 4),
          best_(static_cast<std::size_t>(rule.steps + 2 * rule.bend)),
          total_(static_cast<std::size_t>(rule.steps)),
          from_(static_cast<std::size_t>((rule.rays + 2 * early_) * rule.steps)) {}

    /// `gain` holds the steps of one ray after the other; `path` one step for every ray.
    void find(const std::vector<float>& gain, std::vector<int>& path) {
        const int bend = rule_.bend, steps = rule_.steps, count = rule_.rays + 2 * early_;
        std::fill(best_.begin(), best_.end(), -std::numeric_limits<float>::infinity());
        std::fill_n(best_.begin() + bend, steps, 0.0f);
        for (int k = 0; k < count; ++k) pass(&gain[ray_of(k) * steps], &from_[k * steps]);
        const auto begin = best_.begin() + bend;
        int at = static_cast<int>(std::max_element(begin, begin + steps) - begin);
        for (int k = count - 1; k >= early_; --k) {
            path[ray_of(k)] = at;
            at += static_cast<int>(from_[k * steps + at]);
        }
    }

private:
    int ray_of(int k) const { return (k - early_ + rule_.rays) % rule_.rays; }

    void pass(const float* gain, float* from) {
        const int steps = rule_.steps;
        float *best = best_.data() + rule_.bend, *total = total_.data();
        std::copy_n(best, steps, total);
        std::fill_n(from, steps, 0.0f);
        for (int size = 1; size <= rule_.bend; ++size)
            for (const int bend : {-size, size}) {
                const float cost = rule_.bending * static_cast<float>(size);
                const auto bent = static_cast<float>(bend);
                const float* before = best + bend;
                PINCHOFF_INDEPENDENT
                for (int i = 0; i < steps; ++i) {
                    const float other = before[i] - cost;
                    from[i] = other > total[i] ? bent : from[i];
                    total[i] = other > total[i] ? other : total[i];
                }
            }
        for (int i = 0; i < steps; ++i) best[i] = total[i] + gain[i];
    }

    PolarRule rule_;
    int early_;
    std::vector<float> best_, total_, from_;
};

/// How far from the middle of three values their parabola is highest, at most half a step.
inline float peak_of(float before, float here, float after) {
    const float curvature = std::max(2.0f * here - before - after, 1e-3f);
    return std::clamp(0.5f * (after - before) / curvature, -0.5f, 0.5f);
}

/// Traces the closed outline with the most brightening outwards about one centre after the other.
class PolarTrace {
public:
    explicit PolarTrace(const PolarRule& rule)
        : rule_(rule), path_finder_(rule), path_(static_cast<std::size_t>(rule.rays)) {
        step_ = std::log(rule.farthest / rule.nearest) / (rule.steps - 1);
        const int samples = rule.steps + 2 * rule.window - 1;
        for (int k = 0; k < samples; ++k)
            ratios_.push_back(rule.nearest * std::exp(step_ * (k - (rule.window - 0.5))));
        const auto size = static_cast<std::size_t>(rule.rays * rule.steps);
        for (auto* each : {&inner_, &outer_, &contrast_, &gain_}) each->resize(size);
        values_.resize(ratios_.size());
    }

    /// One point a ray, the first to the right, clockwise as seen with y down.
    void trace(const Picture& picture, double x, double y, double radius, PolarPoint* points) {
        for (int ray = 0; ray < rule_.rays; ++ray) look(picture, x, y, radius, ray);
        path_finder_.find(gain_, path_);
        for (int ray = 0; ray < rule_.rays; ++ray) {
            const int at = path_[ray], base = ray * rule_.steps;
            const auto brightening = [&](int step) {
                const int k = base + std::clamp(step, 0, rule_.steps - 1);
                return outer_[k] - inner_[k];
            };
            const float off = peak_of(brightening(at - 1), brightening(at), brightening(at + 1));
            points[ray] = {rule_.nearest * std::exp(step_ * (at + static_cast<double>(off))),
                           contrast_[base + at], inner_[base + at], outer_[base + at]};
        }
    }

private:
    void look(const Picture& picture, double x, double y, double radius, int ray) {
        const double angle = ray * (2.0 * kPi / rule_.rays);
        const double across = radius * std::cos(angle), down = radius * std::sin(angle);
        for (std::size_t k = 0; k < ratios_.size(); ++k)
            values_[k] = picture.at(x + across * ratios_[k], y + down * ratios_[k]);
        const int window = rule_.window;
        const float share = 1.0f / static_cast<float>(window);
        for (int step = 0; step < rule_.steps; ++step) {
            float within = 0.0f, beyond = 0.0f;
            for (int k = 0; k < window; ++k) {
                within += values_[step + k];
                beyond += values_[step + window + k];
            }
            const int place = ray * rule_.steps + step;
            inner_[place] = share * within;
            outer_[place] = share * beyond;
            contrast_[place] = (outer_[place] - inner_[place]) /
                               (outer_[place] + inner_[place] + 2.0f * rule_.dim);
            gain_[place] = std::min(contrast_[place], rule_.clear);
        }
    }

    PolarRule rule_;
    ClosedPath path_finder_;
    std::vector<int> path_;
    double step_;
    std::vector<double> ratios_;
    std::vector<float> values_, inner_, outer_, contrast_, gain_;
};

}  // namespace pinchoff::inline PINCHOFF_ARCH
