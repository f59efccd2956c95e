// What is seen across an outline in a picture: whether something happens there, all round.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "pinchoff/rays.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// What an outline's rays show.
struct Across {
    double closed;    // share of them on which something happens, the same as on most
    double strength;  // how much, grey levels
    double undone;    // share on which it is soon undone
    double placed;    // how much of what happens near the outline happens on it, from 0 to 1
    bool halo;        // whether it is the light about a droplet in phase contrast that ends here
};

/// How a halo is told: a dark rim, within it, is the droplet's own.
struct HaloRule {
    double reach;       // inwards, pixels, in which the rim is
    double dark, core;  // how much darker it is than outside, and than the middle, halos
};

/// How it is told; lengths in pixels.
struct AcrossRule {
    int reach;      // to either side
    double far;     // outwards, to where a change may be undone
    int near;       // half of these to either side an edge may be
    double faint;   // share of the median below which nothing happens
    double ended;   // least share of a rim that ends outside
    double undone;  // share of a change
    double noise;   // grey levels below which nothing happens
    HaloRule halo;
};

inline double median_of(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (values.size() % 2 == 1) return *middle;
    return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

inline double share_of(const std::vector<double>& values, const std::vector<double>& least) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < values.size(); ++k) count += values[k] >= least[k];
    return static_cast<double>(count) / static_cast<double>(values.size());
}

/// One ray in pixels' steps: the extremes of what it shows within and outside.
struct AcrossRay {
    double edge;             // brightening from within to outside
    double lowest, highest;  // of the rim, just within
    double least, most;      // outside, with the outline
    double fall, rise;       // greatest fall after a maximum outside, and rise after a minimum
    double inmost, outmost;  // least and most within
};

inline AcrossRay across_ray(const std::vector<float>& profile, std::size_t reach) {
    const auto begin = profile.begin();
    const auto outline = begin + static_cast<std::ptrdiff_t>(reach);
    AcrossRay ray{};
    double within = 0.0, beyond = 0.0;
    for (std::size_t k = 0; k < reach; ++k) {
        within += profile[k];
        beyond += profile[reach + 1 + k];
    }
    ray.edge = (beyond - within) / static_cast<double>(reach);
    const auto rim = std::minmax_element(begin, outline + 2);
    ray.lowest = *rim.first;
    ray.highest = *rim.second;
    const auto inside = std::minmax_element(begin, outline + 1);
    ray.inmost = *inside.first;
    ray.outmost = *inside.second;
    ray.least = ray.most = *outline;
    for (auto value = outline; value != profile.end(); ++value) {
        ray.most = std::max(ray.most, static_cast<double>(*value));
        ray.least = std::min(ray.least, static_cast<double>(*value));
        ray.fall = std::max(ray.fall, ray.most - *value);
        ray.rise = std::max(ray.rise, *value - ray.least);
    }
    return ray;
}

/// How much darker a rim is than what it encloses, on each ray, or how much darker all is within.
///
/// A rim ends outside, but for places at a wall or at another droplet; what ends nowhere is the
/// surroundings of something smaller. `sign` is -1 in the negative.
inline std::vector<double> happening(const std::vector<AcrossRay>& rays, double core, double sign,
                                     const AcrossRule& rule) {
    std::vector<double> depth, ended;
    for (const AcrossRay& ray : rays) {
        const double darkest = sign > 0.0 ? ray.lowest : -ray.highest;
        const double brightest = sign > 0.0 ? ray.most : -ray.least;
        depth.push_back(sign * core - darkest);
        ended.push_back(std::min(sign * core, brightest) - darkest);
    }
    const double least = rule.faint * std::max(median_of(depth), 0.0);
    const bool ends = share_of(ended, std::vector<double>(ended.size(), least)) >= rule.ended;
    std::vector<double> happens = ends ? depth : ended;
    for (std::size_t k = 0; k < rays.size(); ++k)
        happens[k] = std::max(happens[k], sign * rays[k].edge);
    return happens;
}

/// The share of what differs within `near` of the outline that differs closely about it.
inline double placed(const Picture& picture, const Ray& outwards, int near) {
    // In half pixels.
    const Ray ray{
        {outwards.from.x - near * outwards.along.x, outwards.from.y - near * outwards.along.y},
        {0.5 * outwards.along.x, 0.5 * outwards.along.y}};
    const auto middle = static_cast<std::size_t>(2 * near);
    float low = ray.at(picture, 0), high = low;
    for (std::size_t k = 1; k <= 2 * middle; ++k) {
        const float value = ray.at(picture, k);
        low = std::min(low, value);
        high = std::max(high, value);
    }
    const float change = std::fabs(ray.at(picture, middle + 3) - ray.at(picture, middle - 3));
    return change / std::max(high - low, 1.0f);
}

/// Whether a bright rim lies about a dark one, as phase contrast shows the edge of a droplet.
///
/// `rays` begin outside and go inwards in pixels' steps; `core` is the grey level of the middle.
inline bool is_halo(const Picture& picture, const std::vector<Ray>& rays, double core,
                    std::size_t samples, const HaloRule& rule) {
    std::vector<double> profile, values;
    for (std::size_t k = 0; k < samples; ++k) {
        values.clear();
        for (const Ray& ray : rays) values.push_back(ray.at(picture, k));
        profile.push_back(median_of(values));
    }
    const auto brightest = std::max_element(profile.begin(), profile.end());
    const double outside = profile.front(), halo = *brightest - outside;
    const double darkest = *std::min_element(brightest, profile.end());
    return halo > 0.0 && outside - darkest >= rule.dark * halo &&
           core - darkest >= rule.core * halo;
}

/// `normals` are outward unit vectors at `points`.
inline Across across(const Picture& picture, const std::vector<Vec2>& points,
                     const std::vector<Vec2>& normals, const AcrossRule& rule) {
    const auto reach = static_cast<std::size_t>(rule.reach);
    std::vector<float> profile(
        static_cast<std::size_t>(std::ceil(rule.far + static_cast<double>(rule.reach))));
    Vec2 centre{0.0, 0.0};
    for (const Vec2& p : points) centre = centre + p;
    centre = {centre.x / static_cast<double>(points.size()),
              centre.y / static_cast<double>(points.size())};
    std::vector<AcrossRay> rays;
    std::vector<Ray> inwards;
    std::vector<double> inner, on_it;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec2 p = points[i], n = normals[i];
        inner.push_back(picture.at(0.5 * (p.x + centre.x), 0.5 * (p.y + centre.y)));
        if (!(p.x > 1.0 && p.y > 1.0 && p.x < static_cast<double>(picture.width) - 2.0 &&
              p.y < static_cast<double>(picture.height) - 2.0))
            continue;
        const Ray ray{{p.x - rule.reach * n.x, p.y - rule.reach * n.y}, n};
        for (std::size_t k = 0; k < profile.size(); ++k) profile[k] = ray.at(picture, k);
        rays.push_back(across_ray(profile, reach));
        inwards.push_back({{p.x + rule.reach * n.x, p.y + rule.reach * n.y}, {-n.x, -n.y}});
        on_it.push_back(placed(picture, {p, n}, rule.near));
    }
    if (rays.empty()) return {0.0, 0.0, 0.0, 0.0, false};
    const double core = median_of(inner);
    const std::vector<double> dark = happening(rays, core, 1.0, rule);
    const std::vector<double> bright = happening(rays, core, -1.0, rule);
    const bool is_dark = median_of(dark) >= median_of(bright);
    const std::vector<double>& happens = is_dark ? dark : bright;
    const double strength = median_of(happens);
    std::vector<double> changes, undone;
    for (const AcrossRay& ray : rays) {
        changes.push_back(rule.undone *
                          (is_dark ? ray.most - ray.inmost : ray.outmost - ray.least));
        undone.push_back(is_dark ? ray.fall : ray.rise);
    }
    const double least = std::max(rule.faint * strength, rule.noise);
    const auto samples = static_cast<std::size_t>(std::ceil(rule.reach + rule.halo.reach));
    const bool halo = !is_dark && is_halo(picture, inwards, core, samples, rule.halo);
    return {share_of(happens, std::vector<double>(happens.size(), least)), strength,
            share_of(undone, changes), median_of(on_it), halo};
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
