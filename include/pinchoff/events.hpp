// The detectors: what an Island looks for between blocks of steps, and what it does when it finds
// it. Included by island.hpp, which declares these functions.
//
// A new event is a look, which measures and gives a budget, a function for what happens, and a line
// in kDetectors. A look writes into the Look alone; droplets change only where an event happens.
#pragma once

namespace pinchoff {

/// A droplet re-spaced less than this long ago, t0, is not re-spaced again.
inline constexpr double kMendingInterval = 1.0;
/// Loops with less than this share of a droplet's area are no more than a thread drawn too thin.
inline constexpr double kSmallLoop = 0.02;
/// The box of a droplet that is compared with everybody, D0; and the margin where space repeats.
inline constexpr double kEverywhere = 1e9;
inline constexpr double kExhaustiveMargin = 4.0;

inline const Island::Detector Island::kDetectors[] = {
    {&Island::look_at_soundness, &Island::never, false},
    {&Island::look_at_necks, &Island::break_up, true},
    {&Island::look_at_obstacles, &Island::record_contacts, false},
    {&Island::look_at_touches, &Island::never, false},
    {&Island::look_at_films, &Island::tend_films, true},
};

inline Budget Island::settle() {
    Budget budget;
    open_bridges();
    survey();
    for (const Detector* d = std::begin(kDetectors); d != std::end(kDetectors);) {
        const Finding found = (this->*d->look)(look_);
        if (found.guard != Guard::none && !world_->retires) stop(found.guard, found.value);
        if (stopped()) return budget;
        const bool refused = found.guard != Guard::none;
        if (!refused && !found.happened) {
            budget.limit_to(found.budget);
            ++d;
            continue;
        }
        if (refused) mend(found);
        else (this->*d->happen)(found);
        if (stopped()) return budget;
        if (!refused && !d->renews) continue;
        if (world_->model.stop_at_breakup != 0.0 && !refused) return budget;
        budget = {};
        survey();
        d = std::begin(kDetectors);
    }
    mark_pushed();
    measure_films();
    return budget;
}

/// Extents and speeds of every droplet, the drift that the coming paths are taken relative to, and
/// who is near whom.
inline void Island::survey() {
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        Ring& ring = droplets_[i].ring;
        ring.drift_x = mean(ring.vx, ring.count);
        ring.drift_y = mean(ring.vy, ring.count);
        world_->kernels.survey(ring, look_.droplets[i].survey);
        look_.droplets[i].scanned = false;
    }
    seek_neighbours();
}

inline bool Island::looks_at_all() const {
    const std::size_t bodies = world_->obstacles.obstacles().size() + droplets_.size();
    return world_->exhaustive || (bodies <= kFewBodies && !world_->period.any());
}

/// Keeps the lists of neighbours complete: sought anew for a droplet that comes near the side of
/// the box that it is kept in.
inline void Island::seek_neighbours() {
    look_.neighbour_room = std::numeric_limits<double>::infinity();
    bool changed = boxes_.size() != droplets_.size();
    boxes_.resize(droplets_.size());
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        Droplet& d = droplets_[i];
        const Box& box = look_.droplets[i].survey.box;
        if (!d.sought || !(room_in(d.kept, box) > 0.25 * kKeptMargin)) {
            seek_obstacles(d, box);
        }
        changed = changed || d.kept.left != boxes_[i].left || d.kept.top != boxes_[i].top ||
                  d.kept.right != boxes_[i].right || d.kept.bottom != boxes_[i].bottom;
        boxes_[i] = d.kept;
        look_.neighbour_room = std::min(look_.neighbour_room, room_in(d.kept, box));
    }
    if (changed) finder_.find(boxes_, world_->period, pairs_);
}

/// Draws a new box round a droplet and finds the obstacles near it.
inline void Island::seek_obstacles(Droplet& d, const Box& box) const {
    d.sought = true;
    const ObstacleGrid& grid = world_->obstacles;
    if (!looks_at_all() || world_->period.any()) {
        d.kept = grown(box, world_->exhaustive ? kExhaustiveMargin : kKeptMargin);
        return grid.find(d.kept, longest_wall_range(d.ring), d.near);
    }
    d.kept = {-kEverywhere, kEverywhere, -kEverywhere, kEverywhere};
    d.near.clear();
    for (int o = 0; o < static_cast<int>(grid.obstacles().size()); ++o)
        d.near.push_back({o, {0, 0}});
}

/// The guards on each droplet alone.
inline Finding Island::look_at_soundness(Look& look) const {
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        double value = 0;
        const Guard guard = unsound(droplets_[i], look.droplets[i].survey, value);
        if (guard != Guard::none) return Finding::alarm(guard, value, static_cast<int>(i));
    }
    return {};
}

/// The guard that one droplet violates, with what it saw.
inline Guard Island::unsound(const Droplet& d, const Survey& s, double& value) const {
    value = s.reach / std::sqrt(d.ring.padded);
    if (!(s.reach < limit_of(Guard::blow_up) * std::sqrt(d.ring.padded))) return Guard::blow_up;
    value = s.area / d.ring.rest_area - 1.0;
    if (!(std::fabs(value) <= limit_of(Guard::area))) return Guard::area;
    if (world_->flow.kind == FlowKind::sampled) {
        value = outside(world_->flow, s.box);
        if (value > limit_of(Guard::flow_domain)) return Guard::flow_domain;
    }
    value = d.id;
    if (step_ % (kCrossingSamples * sample_steps_) == 0 &&
        world_->kernels.self_intersects(d.ring.x, d.ring.y, d.ring.count))
        return Guard::self_intersection;
    return Guard::none;
}

/// A hair's breadth below a separation, so that round-off cannot disagree with the look that saw
/// it.
inline Separation slackened(Separation s) {
    constexpr double kSlack = 1.0 - 1e-9;
    return {kSlack * s.fraction, kSlack * s.length};
}

/// Necks: how far vertices may move before the neck of any droplet can pass the threshold. An
/// earlier look still holds where it leaves room enough up to the next sample.
inline Finding Island::look_at_necks(Look& look) const {
    Finding found;
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        const Droplet& d = droplets_[i];
        const Ring& ring = d.ring;
        DropletLook& seen = look.droplets[i];
        const bool breaks = !(ring.diameter < world_->smallest_breaking);
        const double way = seen.survey.relative_speed * time_step_ * steps_to_sample();
        // One that does not break is looked at for its own sides alone, once they come near.
        const double room = breaks ? seen.neck_room : 0.5 * seen.thinnest - 3.0 * ring.rest_length;
        if (room > way / kBlockSafety && !(d.id == watched_ && at_sample())) {
            found.budget.relative = std::min(found.budget.relative, room);
            continue;
        }
        const double threshold = neck_threshold(world_->model, ring.diameter);
        const Separation& limit = world_->separation;
        const Separation separation{limit.fraction, limit.length * ring.diameter};
        look.neck_work.resize(
            std::max<std::size_t>(look.neck_work.size(), neck_work_size(ring.count)));
        seen.neck = world_->kernels.scan_neck(ring.x, ring.y, ring.count, separation, threshold,
                                              look.neck_work.data());
        seen.scanned = true;
        seen.neck_room = std::max(seen.neck.budget, 0.0);
        seen.thinnest = std::sqrt(seen.neck.nearest2);
        if (!breaks) continue;
        if (d.bridge > 0) {  // neither breaks nor merges before its bridge has opened
            seen.neck_room = 0.0;
            found.budget.relative = std::min(found.budget.relative, kBridgeRoom * ring.rest_length);
            continue;
        }
        // That a chord leaves both ends inwards is seen by the scan, that it crosses no edge here.
        if (seen.neck.thickness2 < threshold * threshold &&
            find_neck(d.positions(), slackened(separation)).thickness < threshold)
            return Finding::event(static_cast<int>(i));
        found.budget.relative = std::min(found.budget.relative, seen.neck_room);
    }
    return found;
}

/// Obstacles: first contacts, and the vertices that may feel a wall in the coming block. A contact
/// is not listed before it is recorded: it is measured before the wall first pushes. The budget
/// keeps the lists complete, lets no contact begin and no edge cross an obstacle unseen.
inline Finding Island::look_at_obstacles(Look& look) const {
    Finding found;
    found.budget.absolute = std::min(found.budget.absolute, look.neighbour_room);
    look.lists.walls.clear();
    look.nearby.clear();
    look.distance2.clear();
    for (int i = 0; i < static_cast<int>(droplets_.size()); ++i) {
        const Droplet& d = droplets_[i];
        for (const ObstacleImage& image : d.near) {
            const Obstacle o = world_->obstacles.seen(image);
            // What the boxes alone allow; no closer look can find less.
            const double least = gap(box_of({o.x, o.y}), look.droplets[i].survey.box) - o.radius -
                                 wall_range(d.ring, o);
            if (least > std::max(found.budget.absolute, wall_margin(o))) continue;
            const Nearby pair = look_nearby(look, world_->kernels, d.ring, i, o, image.index);
            const double depth = depth_of(pair);
            if (depth > limit_of(Guard::penetration) && found.guard == Guard::none)
                found.refuse(Guard::penetration, depth, i);
            const bool first = begins(pair, d);
            if (first) look.nearby.push_back(pair);
            // No front may enter a wall, measured or not: it does not push.
            if (!first || tracks_front(d.ring)) list_obstacle(look, d, pair, found.budget);
            found.happened |= first;
        }
    }
    return found;
}

/// Lists one pair that is not in first contact, and limits the budget to what keeps it complete.
inline void Island::list_obstacle(Look& look, const Droplet& d, const Nearby& pair,
                                  Budget& budget) const {
    const Obstacle& o = pair.seen;
    const bool met = d.has_met(pair.obstacle);
    if (!met) budget.absolute = std::min(budget.absolute, std::max(first_gap(pair, d), 0.0));
    if (met || tracks_front(d.ring)) {
        const double* chunks = look.distance2.data() + pair.chunks;
        budget.absolute =
            std::min(budget.absolute, list_wall(look.lists, d, pair.droplet, o, met, chunks));
    }
    budget.absolute = std::min(budget.absolute, std::max(pair.edge - o.radius, wall_margin(o)));
}

/// Droplets against each other and against themselves: the vertices that may touch in the coming
/// block, and how far they may move while the list is complete.
inline Finding Island::look_at_touches(Look& look) const {
    Finding found;
    double& allowed = found.budget.absolute;
    look.lists.touches.clear();
    look.facings.clear();
    for (const DropletPair& pair : pairs_) {
        const int i = pair.first, j = pair.second;
        const Ring &a = droplets_[i].ring, &b = droplets_[j].ring;
        if (i == j && pair.image.x == 0.0 && pair.image.y == 0.0) {
            allowed = std::min(allowed, list_own(look.lists, a, i, look.droplets[i].thinnest));
            continue;
        }
        const std::size_t listed = look.lists.touches.size();
        const PairRoom room = list_pair(look.lists, a, i, look.droplets[i].survey.box, b, j,
                                        look.droplets[j].survey.box, pair.image);
        if (room.depth > limit_of(Guard::overlap) * touch_of(a, b).length &&
            found.guard == Guard::none)
            found.refuse(Guard::overlap, room.depth, a.mass <= b.mass ? i : j);
        if (world_->coalescence.follows && i != j) measure_facing(look, pair, listed);
        allowed = std::min(allowed, room.allowed);
    }
    return found;
}

/// Contact lists of the present positions, whatever happens there; a guard may stop the run.
inline void Island::list_contacts() {
    for (const auto look : {&Island::look_at_obstacles, &Island::look_at_touches}) {
        const Finding found = (this->*look)(look_);
        if (found.guard != Guard::none && !world_->retires) stop(found.guard, found.value);
    }
    mark_pushed();
}

/// Droplets that are on no list need no contact forces in the coming block.
inline void Island::mark_pushed() {
    for (Droplet& d : droplets_) d.ring.pushed = false;
    for (const WallContact& c : look_.lists.walls) droplets_[c.ring].ring.pushed = true;
    for (const DropletContact& c : look_.lists.touches)
        droplets_[c.ring].ring.pushed = droplets_[c.other].ring.pushed = true;
}

/// Measure the droplets that have just touched an obstacle, on their outlines.
inline void Island::record_contacts(const Finding&) {
    look_at_touches(look_);
    mark_pushed();
    const std::vector<std::vector<Vec2>> velocities = synchronized_velocities();
    for (const Nearby& pair : look_.nearby) {
        Droplet& d = droplets_[pair.droplet];
        const std::vector<Vec2> r = d.positions(), &v = velocities[pair.droplet];
        const Vec2 velocity = mean(v), centre{pair.seen.x, pair.seen.y};
        contacts_.push_back({time(), d.id, pair.obstacle, symmetry(r, centre, velocity),
                             impact_parameter(r, centre, velocity),
                             std::sqrt(dot(velocity, velocity)), signed_area(r), shape_parameter(r),
                             centroid(r), velocity, centroid_velocity(r, v)});
        d.meet(pair.obstacle);
        if (!world_->retires && world_->kernels.self_intersects(d.ring.x, d.ring.y, d.ring.count))
            stop(Guard::self_intersection, d.id);
    }
}

/// Takes a droplet out; it is kept where the clock may be set back.
inline void Island::remove(int index) {
    if (droplets_[index].remembered()) gone_.push_back(std::move(droplets_[index]));
    droplets_.erase(droplets_.begin() + index);
    look_.droplets.erase(look_.droplets.begin() + index);
    boxes_.clear();
}

/// A droplet that a guard refuses is re-spaced at its proper area, without the loops in which it
/// crosses itself, or, where that does not serve or has just been tried, taken out.
inline void Island::mend(const Finding& found) {
    Droplet& d = droplets_[found.droplet];
    const Shape whole = untangled({d.positions(), d.velocities()});
    const std::vector<Vec2>& r = whole.r;
    const bool respaceable = found.guard == Guard::area || found.guard == Guard::self_intersection;
    // What small loops have been taken off may be mended again, but not at the same instant.
    const bool small = found.guard == Guard::self_intersection &&
                       signed_area(r) > (1.0 - kSmallLoop) * d.ring.rest_area;
    const bool retired = !respaceable || !(time() - d.mended > (small ? 0.0 : kMendingInterval)) ||
                         !(signed_area(r) > 0.5 * d.ring.rest_area);
    refusals_.push_back(
        {time(), d.id, found.guard, found.value, d.ring.rest_area, centroid(r), retired});
    if (retired) {
        end_films(d.id);
        return remove(found.droplet);
    }
    Shape even = respace(whole, d.ring.count);
    scale_to_area(even, d.ring.rest_area);
    Droplet mended = heir(d, Droplet(world_->model, d.ring.rest_area, even.r, even.v));
    mended.id = d.id;
    mended.generation = d.generation;
    mended.key = d.key;
    mended.meetings = d.meetings;
    mended.mended = time();
    remove(found.droplet);
    add(std::move(mended));
    renew_steps();
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

/// Cut one droplet along its neck. The daughters share its rest area and its mass in proportion to
/// their areas, and together keep its momentum.
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
    const auto [one, two] = cut(whole, line);
    const double areas[2] = {signed_area(one.r), signed_area(two.r)};
    const double smallest =
        parent.ring.diameter * std::sqrt(std::min(areas[0], areas[1]) / (areas[0] + areas[1]));
    Guard guard = Guard::none;
    if (!(smallest >= limit_of(Guard::daughter_size))) guard = Guard::daughter_size;
    else if (parent.generation + 1 > limit_of(Guard::generations)) guard = Guard::generations;
    if (guard != Guard::none) {
        const double value = guard == Guard::generations ? parent.generation + 1 : smallest;
        if (!world_->retires) return stop(guard, value);
        set_lags(0.5 * time_step_);
        return mend(Finding::alarm(guard, value, found.droplet));
    }

    Shape daughters[2] = {one, two};
    double rest[2];
    Vec2 momentum{0, 0};
    for (int k = 0; k < 2; ++k) {
        rest[k] = parent.ring.rest_area * areas[k] / (areas[0] + areas[1]);
        const double diameter = std::sqrt(rest[k] / kReferenceArea);
        daughters[k] =
            respace(daughters[k], world_->vertices_for(diameter, perimeter(daughters[k].r)));
        momentum = momentum + rest[k] / parent.ring.rest_area * mean(daughters[k].v);
    }
    const Vec2 correction = mean(whole.v) - momentum;
    BreakupEvent event{time(),
                       parent.id,
                       parent.generation,
                       {0, 0},
                       {areas[0], areas[1]},
                       neck.thickness,
                       {point_on(whole.r, line.first), point_on(whole.r, line.second)},
                       look_.droplets[found.droplet]};
    std::vector<Droplet> heirs;
    for (int k = 0; k < 2; ++k) {
        for (Vec2& v : daughters[k].v) v = v + correction;
        heirs.push_back(
            heir(parent, Droplet(world_->model, rest[k], daughters[k].r, daughters[k].v)));
        heirs[k].key = mixed(parent.key + k + 1);
    }
    const std::vector<Film> films = end_films(parent.id);
    remove(found.droplet);
    for (int k = 0; k < 2; ++k) event.daughters[k] = add(std::move(heirs[k]));
    breakups_.push_back(event);
    if (world_->coalescence.follows) {
        for (const int daughter : event.daughters) hand_down(films, event.droplet, daughter);
        const auto [low, high] = std::minmax(event.daughters[0], event.daughters[1]);
        handed_down_.push_back({.first = low, .second = high, .cut = true});
    }
    settle_heirs();
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
