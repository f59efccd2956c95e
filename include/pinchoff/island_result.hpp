// What becomes of droplets that advance together: contacts, break-ups, refusals, and themselves.
#pragma once

#include <cstdint>
#include <vector>

#include "droplet.hpp"
#include "film.hpp"

namespace pinchoff {

/// First touch of one droplet with one obstacle.
///
/// The velocity is that of the centre of mass of the model, whose mass sits on the vertices: the
/// mean of theirs. The centroid of the area moves a little differently while the front edge stops.
/// With front tracking, whose vertices are even marks without mass, it is that of the outline's own
/// centre, which does not depend on how they slide.
struct ContactEvent {
    double time;
    int droplet, obstacle;
    double symmetry, impact_parameter, speed, area, shape_parameter;
    Vec2 centroid, velocity, centroid_velocity;
};

/// A droplet that a guard refused where the run goes on without it: re-spaced, or taken out.
struct RefusalEvent {
    double time;
    int droplet;
    Guard guard;
    double value, area;
    Vec2 centroid;
    bool retired;
};

/// One droplet cut into two.
struct BreakupEvent {
    double time;
    int droplet, generation, daughters[2];
    double areas[2];
    double neck_thickness;
    Vec2 ends[2];
    DropletLook seen;  // the parent, just before
};

/// What became of an island: its droplets, and what has happened to them.
struct IslandResult {
    bool done = false;  // whether no droplet went further than its `travel`
    std::vector<Droplet> droplets;
    std::vector<Droplet> gone;  // that were there when the clock started and are no more
    std::vector<ContactEvent> contacts;
    std::vector<BreakupEvent> breakups;
    std::vector<RefusalEvent> refusals;
    std::vector<Film> films;  // contacts of droplets that go on
    std::vector<FilmEvent> film_events;
    std::int64_t steps = 0, vertex_updates = 0;
    int ids_given = 0;
};

}  // namespace pinchoff
