// Where droplets come in, how many the fluid brings, and where one finds room.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "island.hpp"
#include "random.hpp"

namespace pinchoff {

/// Where droplets come in: centres on the line x between two y, such that they take up a fraction
/// of the area that flows in; their diameters are drawn from a list. No droplet comes in where
/// `fraction` is zero.
struct Inlet {
    double x = 0, bottom = 0, top = 0, fraction = 0;
    std::vector<double> diameters;
};

/// Whether a disc is clear of all droplets, at a distance.
inline bool has_room(const World& world, std::span<const Droplet> droplets, Vec2 centre,
                     double clear) {
    const Box disc = grown(box_of(centre), clear);
    for (const Droplet& d : droplets) {
        bool free = true;
        Survey s;
        world.kernels.survey(d.ring, s);
        for_overlapping_images(disc, s.box, world.period, [&](Vec2 image) {
            const Vec2 seen = displacement(image, centre);
            const double edge = std::sqrt(world.kernels.edge_distance2(d.ring, seen.x, seen.y));
            free = free && edge > clear && !world.kernels.contains(d.ring, seen.x, seen.y);
        });
        if (!free) return false;
    }
    return true;
}

/// The droplets to come: how much area is due, the diameter of the next one, and for how long it
/// has waited.
class Inflow {
public:
    Inflow(Inlet inlet, std::uint64_t seed) : random(seed), inlet_(std::move(inlet)) {
        draw_next();
    }

    /// What the fluid brings in a time.
    void flow_for(const World& world, double time) {
        if (!(inlet_.fraction > 0.0)) return;
        constexpr int kPlaces = 64;
        double x[kPlaces], y[kPlaces], u[kPlaces], v[kPlaces], speed = 0;
        for (int i = 0; i < kPlaces; ++i) {
            x[i] = inlet_.x;
            y[i] = inlet_.bottom + (i + 0.5) / kPlaces * (inlet_.top - inlet_.bottom);
        }
        world.kernels.flow_velocity(world.flow, x, y, u, v, kPlaces);
        for (const double forward : u) speed += std::max(forward, 0.0) / kPlaces;
        credit += inlet_.fraction * (inlet_.top - inlet_.bottom) * speed * time;
    }

    /// Whether a droplet is to come in.
    bool due() const {
        return inlet_.fraction > 0.0 && credit >= kReferenceArea * next_diameter * next_diameter;
    }

    /// A place for the next droplet among those present, if one is found.
    std::optional<Start> find_place(const World& world, std::span<const Droplet> droplets) {
        const double margin = world.period.y > 0.0 ? 0.0 : 0.5 * next_diameter;
        const double width = inlet_.top - inlet_.bottom;
        for (int t = 0; t < kTries; ++t) {
            const double y = inlet_.bottom + margin + random.uniform() * (width - 2.0 * margin);
            if (has_room(world, droplets, {inlet_.x, y}, 0.5 * next_diameter + kGap))
                return Start{inlet_.x, y, next_diameter};
        }
        return std::nullopt;
    }

    /// The next droplet has come in with this area; the one after it is drawn.
    void take(double area) {
        credit -= area;
        waited = 0;
        draw_next();
    }

    double credit = 0;         // area that has flowed in and not come as droplets
    double next_diameter = 0;  // of the droplet that comes in next
    double waited = 0;         // for how long it has found no room
    Random random;

private:
    Inlet inlet_;

    /// Least gap between a droplet that comes in and all others, D0.
    static constexpr double kGap = 0.05;
    /// Places that are tried in a window for the droplet that comes in next.
    static constexpr int kTries = 8;

    void draw_next() {
        const std::vector<double>& diameters = inlet_.diameters;
        if (diameters.empty()) return;
        const double at = random.uniform() * static_cast<double>(diameters.size());
        next_diameter = diameters[std::min(static_cast<std::size_t>(at), diameters.size() - 1)];
    }
};

}  // namespace pinchoff
