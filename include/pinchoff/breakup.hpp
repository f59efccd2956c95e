// A droplet is cut into two along its neck. Included by island.hpp, which declares these functions.
#pragma once

namespace pinchoff {

/// A hair's breadth below a separation, so that round-off cannot disagree with the look that saw
/// it.
inline Separation slackened(Separation s) {
    constexpr double kSlack = 1.0 - 1e-9;
    return {kSlack * s.fraction, kSlack * s.length};
}

/// A droplet that takes the place of another, or of a part of it.
inline Droplet Island::heir(const Droplet& parent, Droplet droplet) {
    droplet.id = kNoNumber;
    droplet.generation = parent.generation + 1;
    droplet.contacted = parent.contacted;
    droplet.lag = parent.lag;
    droplet.place = parent.place;
    droplet.travel = parent.travel;
    droplet.travelled = parent.travelled;
    return droplet;
}

/// Cut one droplet along its neck.
inline void Island::break_up(const Finding& found) {
    list_contacts();
    if (stopped()) return;
    set_lags(0.0);
    const Droplet& parent = droplets_[found.droplet];
    const Shape whole{parent.positions(), parent.velocities()};
    const Separation& limit = world_->separation;
    const Neck neck =
        find_neck(whole.r, slackened({limit.fraction, limit.length * parent.ring.diameter}));
    const Cut line = place_cut(whole.r, neck);
    std::pair<Shape, Shape> halves = cut(whole, line);
    const double areas[2] = {signed_area(halves.first.r), signed_area(halves.second.r)};
    double value = 0;
    const Guard guard = refuses_cut(parent, areas, value);
    // Where droplets are many a daughter that is too small goes alone, and not her mother.
    const bool spills =
        world_->retires && guard == Guard::daughter_size && std::min(areas[0], areas[1]) > 0.0;
    if (guard != Guard::none && !spills) {
        if (!world_->retires) return stop(guard, value);
        set_lags(0.5 * time_step_);
        return mend(Finding::alarm(guard, value, found.droplet));
    }
    BreakupEvent event{time(),
                       parent.id,
                       parent.generation,
                       {0, 0},
                       {areas[0], areas[1]},
                       neck.thickness,
                       {point_on(whole.r, line.first), point_on(whole.r, line.second)},
                       look_.droplets[found.droplet]};
    std::vector<Droplet> daughters = daughters_of(parent, mean(whole.v), std::move(halves), areas);
    const std::vector<Film> films = end_films(parent.id);
    remove(found.droplet);
    for (int k = 0; k < 2; ++k) event.daughters[k] = add(std::move(daughters[k]));
    breakups_.push_back(event);
    if (world_->coalescence.follows) hand_films_down(event, films);
    if (spills) take_out(event.daughters[areas[0] < areas[1] ? 0 : 1], guard, value);
    settle_heirs();
}

/// Takes out a droplet that a guard refuses.
inline void Island::take_out(int id, Guard guard, double value) {
    const int index = index_of(id);
    const Droplet& d = droplets_[index];
    refusals_.push_back(
        {time(), id, guard, value, d.ring.rest_area, centroid(d.positions()), true});
    end_films(id);
    remove(index);
}

/// The guard that refuses to cut a droplet into such areas, with what it saw.
inline Guard Island::refuses_cut(const Droplet& parent, const double (&areas)[2],
                                 double& value) const {
    value = parent.ring.diameter * std::sqrt(std::min(areas[0], areas[1]) / (areas[0] + areas[1]));
    if (!(value >= limit_of(Guard::daughter_size))) return Guard::daughter_size;
    value = parent.generation + 1;
    return value > limit_of(Guard::generations) ? Guard::generations : Guard::none;
}

/// The two halves of a droplet that moves with a velocity. They share its rest area and its mass in
/// proportion to their areas, and together keep its momentum.
inline std::vector<Droplet> Island::daughters_of(const Droplet& parent, Vec2 velocity,
                                                 std::pair<Shape, Shape> halves,
                                                 const double (&areas)[2]) const {
    Shape* const shapes[2] = {&halves.first, &halves.second};
    double rest[2];
    Vec2 momentum{0, 0};
    for (int k = 0; k < 2; ++k) {
        rest[k] = parent.ring.rest_area * areas[k] / (areas[0] + areas[1]);
        const double diameter = std::sqrt(rest[k] / kReferenceArea);
        *shapes[k] = respace(*shapes[k], world_->vertices_for(diameter, perimeter(shapes[k]->r)));
        momentum = momentum + rest[k] / parent.ring.rest_area * mean(shapes[k]->v);
    }
    const Vec2 correction = velocity - momentum;
    std::vector<Droplet> daughters;
    for (int k = 0; k < 2; ++k) {
        for (Vec2& v : shapes[k]->v) v = v + correction;
        daughters.push_back(
            heir(parent, Droplet(world_->model, rest[k], shapes[k]->r, shapes[k]->v)));
        daughters[k].key = mixed(parent.key + k + 1);
    }
    return daughters;
}

/// The films of a droplet that broke are its daughters'; between these there is none until they
/// have parted.
inline void Island::hand_films_down(const BreakupEvent& event, const std::vector<Film>& films) {
    for (const int daughter : event.daughters) hand_down(films, event.droplet, daughter);
    const auto [low, high] = std::minmax(event.daughters[0], event.daughters[1]);
    handed_down_.push_back({.first = low, .second = high, .cut = true});
}

/// After outlines were cut or joined: steps, lists and velocities that suit the new droplets.
inline void Island::settle_heirs() {
    renew_steps();
    if (stopped()) return;
    look_.lists.clear();
    survey();
    if (world_->model.stop_at_breakup == 0.0) list_contacts();
    else if (world_->fronts()) look_at_obstacles(look_);
    mark_pushed();
    if (world_->fronts()) world_->kernels.settle_fronts(scene());
    set_lags(0.5 * time_step_);
}

}  // namespace pinchoff
