// What droplets move in: the model, the flow, obstacles, and how space repeats itself.
#pragma once

#include <utility>

#include "film.hpp"
#include "neighbours.hpp"
#include "split.hpp"
#include "types.hpp"

namespace pinchoff {

/// What droplets move in, the same for every island.
struct World {
    Model model;
    Flow flow;
    ObstacleGrid obstacles;
    const Kernels& kernels;
    Period period{};
    double sample_interval = model.sample_interval;  // t0
    bool retires = false;          // a droplet that a guard refuses is taken out; or the run ends
    double smallest_breaking = 0;  // diameter below which a droplet's neck is not looked at, D0
    bool exhaustive = false;       // everybody is compared with everybody, for tests
    Coalescence coalescence{};
    Separation separation = model.neck_separation_in_diameters != 0.0
                                ? Separation{0.0, model.neck_separation}
                                : Separation{model.neck_separation, 0.0};

    bool fronts() const { return model.front_tracking != 0.0; }
};

}  // namespace pinchoff
