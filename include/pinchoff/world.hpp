// What droplets move in: the model, the flow, obstacles, and how space repeats itself.
#pragma once

#include <utility>

#include "droplet.hpp"
#include "film.hpp"
#include "neighbours.hpp"
#include "split.hpp"
#include "types.hpp"

namespace pinchoff {

/// Where droplets are many, one is spaced anew when at its proper spacing it would have this many
/// times the vertices that it has, or that it has this many times those.
inline constexpr double kDrawnOut = 2.0, kDrawnIn = 1.6;

/// What droplets move in, the same for every island.
struct World {
    Model model;
    Flow flow;
    ObstacleGrid obstacles;
    const Kernels& kernels;
    Period period{};
    bool retires = false;          // a droplet that a guard refuses is taken out; or the run ends
    double smallest_breaking = 0;  // diameter below which a droplet's neck is not looked at, D0
    bool exhaustive = false;       // everybody is compared with everybody, for tests
    Coalescence coalescence{};
    Separation separation = model.neck_separation_in_diameters != 0.0
                                ? Separation{0.0, model.neck_separation}
                                : Separation{model.neck_separation, 0.0};

    bool fronts() const { return model.front_tracking != 0.0; }

    /// Vertices for a droplet of this perimeter: with many droplets and front tracking one that is
    /// drawn out gets more, so that no obstacle passes between two of them.
    int vertices_for(double diameter, double perimeter) const {
        const int round = vertex_count(model, diameter);
        const int drawn_out = vertex_count(model, diameter, perimeter);
        return retires && fronts() && drawn_out >= kDrawnOut * round ? drawn_out : round;
    }
};

}  // namespace pinchoff
