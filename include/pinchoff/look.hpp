// What is measured on droplets between blocks of steps, and what the detectors of events make of
// it. Nothing here changes a droplet.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "contact.hpp"

namespace pinchoff {

/// How far vertices may move before something could happen: in all, and relative to the drift of
/// their droplet.
struct Budget {
    double absolute = 1.0, relative = 1.0;

    void limit_to(const Budget& other) {
        absolute = std::min(absolute, other.absolute);
        relative = std::min(relative, other.relative);
    }
};

/// What a detector says of an instant: a guard that refuses what it sees, or that its event has
/// happened, or the budget below which it cannot.
struct Finding {
    Budget budget;
    bool happened = false;
    int droplet = -1;  // index of the droplet that it happened to, where it is one
    Guard guard = Guard::none;
    double value = 0;  // what the guard saw

    static Finding event(int droplet = -1) { return {{}, true, droplet, Guard::none, 0}; }
    static Finding alarm(Guard guard, double value, int droplet) {
        return {{}, false, droplet, guard, value};
    }

    /// Adds an alarm to a look that goes on, so that its lists are complete all the same.
    void refuse(Guard by, double measured, int which) {
        guard = by;
        value = measured;
        droplet = which;
    }
};

/// Whether a droplet is farther away than any may be, or has a vertex that is nowhere.
inline bool blown_up(const Ring& ring, const Survey& seen) {
    return !(seen.reach < limit_of(Guard::blow_up) * std::sqrt(ring.padded));
}

/// Whether its area is as far from what it should be as no droplet's may be, or no number.
inline bool out_of_area(const Ring& ring, const Survey& seen) {
    return !(std::fabs(seen.area / ring.rest_area - 1.0) <= limit_of(Guard::area));
}

/// Distances between one droplet and one obstacle.
struct Nearby {
    int droplet, obstacle;
    Obstacle seen;        // the obstacle, or its image
    double vertex, edge;  // from the obstacle's centre to the nearest vertex, the nearest edge
    bool through;         // whether that centre is inside the droplet
    std::size_t chunks;   // where Look::distance2 begins for this pair
};

/// How much of two droplets' outlines is within a vertex spacing of the other's: half of what each
/// side faces the other with.
struct Facing {
    int droplet, other;  // numbers, the lower one first
    double length;
};

/// Everything measured at one instant.
struct Look {
    std::vector<DropletLook> droplets;
    double neighbour_room = 0;  // how far vertices may move while the neighbours are known
    std::vector<Nearby> nearby;
    std::vector<double> distance2;  // squared distance of every chunk of vertices, by pairs
    ContactLists lists;             // complete up to the end of the coming block
    std::vector<Facing> facings;    // where contacts of droplets are followed
    std::vector<double> neck_work;  // room for a look at a neck
};

/// Measures one droplet against one obstacle; the distances of its chunks are added to the look.
inline Nearby look_nearby(Look& look, const Kernels& kernels, const Ring& ring, int droplet,
                          const Obstacle& o, int obstacle) {
    const std::size_t first = look.distance2.size();
    look.distance2.resize(first + ring.padded / kLanes);
    double* const chunks = look.distance2.data() + first;
    kernels.chunk_distance2(ring, o.x, o.y, chunks);
    const double vertex = std::sqrt(*std::min_element(chunks, chunks + ring.padded / kLanes));
    const double edge = std::sqrt(kernels.edge_distance2(ring, o.x, o.y));
    return {droplet, obstacle, o, vertex, edge, kernels.contains(ring, o.x, o.y), first};
}

/// How far an obstacle is in the droplet, in its radii: from its surface inwards, and on past the
/// centre once that is in the droplet.
inline double depth_of(const Nearby& pair) {
    return 1.0 - (pair.through ? -pair.edge : std::min(pair.vertex, pair.edge)) / pair.seen.radius;
}

/// How far a droplet is from first contact with an obstacle: from a vertex in the wall's range, or,
/// with front tracking, from an outline that touches.
inline double first_gap(const Nearby& pair, const Droplet& d) {
    if (tracks_front(d.ring))
        return std::min(pair.vertex, pair.edge) - pair.seen.radius - kFrontTouch;
    return pair.vertex - pair.seen.radius - 0.5 * d.ring.rest_length;
}

/// Whether a first contact begins.
inline bool begins(const Nearby& pair, const Droplet& d) {
    return !d.has_met(pair.obstacle) && first_gap(pair, d) < 0.0;
}

}  // namespace pinchoff
