// The detectors: what an Island looks for between blocks of steps, and what it does when it finds
// it. Included by island.hpp, which declares these functions.
//
// A new event is a look, which measures and gives a budget, a function for what happens, and a line
// in kDetectors. A look writes into the Look alone; droplets change only where an event happens.
#pragma once

namespace pinchoff {

inline const Island::Detector Island::kDetectors[] = {
    {&Island::look_at_soundness, &Island::never, false},
    {&Island::look_at_necks, &Island::break_up, true},
    {&Island::look_at_obstacles, &Island::record_contacts, false},
    {&Island::look_at_touches, &Island::never, false},
};

inline Budget Island::settle() {
    Budget budget;
    survey();
    for (const Detector* d = std::begin(kDetectors); d != std::end(kDetectors);) {
        const Finding found = (this->*d->look)(look_);
        if (found.guard != Guard::none) stop(found.guard, found.value);
        if (stopped()) return budget;
        if (!found.happened) {
            budget.limit_to(found.budget);
            ++d;
            continue;
        }
        (this->*d->happen)(found);
        if (stopped()) return budget;
        if (!d->renews) continue;
        if (model_.stop_at_breakup != 0.0) return budget;
        budget = {};
        survey();
        d = std::begin(kDetectors);
    }
    mark_pushed();
    return budget;
}

/// Extents and speeds of every droplet, and the drift that the coming paths are taken relative to.
inline void Island::survey() {
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        Ring& ring = droplets_[i].ring;
        ring.drift_x = mean(ring.vx, ring.count);
        ring.drift_y = mean(ring.vy, ring.count);
        kernels_.survey(ring, look_.droplets[i].survey);
        look_.droplets[i].scanned = false;
    }
}

/// The guards on each droplet alone.
inline Finding Island::look_at_soundness(Look& look) const {
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        double value = 0;
        const Guard guard = unsound(droplets_[i], look.droplets[i].survey, value);
        if (guard != Guard::none) return Finding::alarm(guard, value);
    }
    return {};
}

/// The guard that one droplet violates, with what it saw.
inline Guard Island::unsound(const Droplet& d, const Survey& s, double& value) const {
    value = s.reach / std::sqrt(d.ring.padded);
    if (!(s.reach < limit_of(Guard::blow_up) * std::sqrt(d.ring.padded))) return Guard::blow_up;
    value = s.area / d.ring.rest_area - 1.0;
    if (!(std::fabs(value) <= limit_of(Guard::area))) return Guard::area;
    if (flow_.kind == FlowKind::sampled) {
        value = outside(flow_, bounding_box(d.ring));
        if (value > limit_of(Guard::flow_domain)) return Guard::flow_domain;
    }
    value = d.id;
    if (step_ % (kCrossingSamples * sample_steps_) == 0 &&
        kernels_.self_intersects(d.ring.x, d.ring.y, d.ring.count))
        return Guard::self_intersection;
    return Guard::none;
}

/// A hair's breadth below a separation, so that round-off cannot disagree with the look that saw
/// it.
inline Separation slackened(Separation s) {
    constexpr double kSlack = 1.0 - 1e-9;
    return {kSlack * s.fraction, kSlack * s.length};
}

/// Necks: how far vertices may move before the neck of any droplet can pass the threshold.
inline Finding Island::look_at_necks(Look& look) const {
    Finding found;
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        const Ring& ring = droplets_[i].ring;
        DropletLook& seen = look.droplets[i];
        const double threshold = model_.neck_thickness * ring.diameter;
        const Separation separation{separation_.fraction, separation_.length * ring.diameter};
        look.neck_work.resize(
            std::max<std::size_t>(look.neck_work.size(), neck_work_size(ring.count)));
        seen.neck = kernels_.scan_neck(ring.x, ring.y, ring.count, separation, threshold,
                                       look.neck_work.data());
        seen.scanned = true;
        // That a chord leaves both ends inwards is seen by the scan, that it crosses no edge here.
        if (seen.neck.thickness2 < threshold * threshold &&
            find_neck(droplets_[i].positions(), slackened(separation)).thickness < threshold)
            return Finding::event(static_cast<int>(i));
        found.budget.relative = std::min(found.budget.relative, std::max(seen.neck.budget, 0.0));
    }
    return found;
}

/// Obstacles: first contacts, and the vertices that may feel a wall in the coming block. A contact
/// is not listed before it is recorded: it is measured before the wall first pushes. The budget
/// keeps the lists complete, lets no contact begin and no edge cross an obstacle unseen.
inline Finding Island::look_at_obstacles(Look& look) const {
    Finding found;
    look.lists.walls.clear();
    look.nearby.clear();
    look.distance2.clear();
    for (int i = 0; i < static_cast<int>(droplets_.size()); ++i) {
        const Droplet& d = droplets_[i];
        for (int o = 0; o < static_cast<int>(obstacles_.size()); ++o) {
            const Nearby pair = look_nearby(look, kernels_, d.ring, i, obstacles_[o], o);
            const double depth = depth_of(pair, obstacles_[o]);
            if (depth > limit_of(Guard::penetration))
                return Finding::alarm(Guard::penetration, depth);
            const bool first = begins(pair, d, obstacles_[o]);
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
    const Obstacle& o = obstacles_[pair.obstacle];
    const bool met = d.has_met(pair.obstacle);
    if (!met) budget.absolute = std::min(budget.absolute, std::max(first_gap(pair, d, o), 0.0));
    if (met || tracks_front(d.ring)) {
        const double* chunks = look.distance2.data() + pair.chunks;
        budget.absolute =
            std::min(budget.absolute, list_wall(look.lists, d, pair.droplet, o, chunks));
    }
    budget.absolute = std::min(budget.absolute, std::max(pair.edge - o.radius, wall_margin(o)));
}

/// Droplets against each other and against themselves: the vertices that may touch in the coming
/// block, and how far they may move while the list is complete.
inline Finding Island::look_at_touches(Look& look) const {
    Finding found;
    double& allowed = found.budget.absolute;
    look.lists.touches.clear();
    for (int i = 0; i < static_cast<int>(droplets_.size()); ++i) {
        for (int j = 0; j < static_cast<int>(droplets_.size()); ++j) {
            const Ring &a = droplets_[i].ring, &b = droplets_[j].ring;
            if (i == j) {
                const double thinnest = std::sqrt(look.droplets[i].neck.nearest2);
                allowed = std::min(allowed, list_own(look.lists, a, i, thinnest));
                continue;
            }
            const PairRoom room = list_pair(look.lists, kernels_, a, i, b, j);
            if (room.depth > limit_of(Guard::overlap) * touch_of(a, b).length)
                return Finding::alarm(Guard::overlap, room.depth);
            allowed = std::min(allowed, room.allowed);
        }
    }
    return found;
}

/// Lists of the present positions, whatever happens there; a guard may stop the run.
inline void Island::list_contacts() {
    for (const auto look : {&Island::look_at_obstacles, &Island::look_at_touches}) {
        const Finding found = (this->*look)(look_);
        if (found.guard != Guard::none) stop(found.guard, found.value);
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
        const Obstacle& o = obstacles_[pair.obstacle];
        const std::vector<Vec2> r = d.positions(), &v = velocities[pair.droplet];
        const Vec2 velocity = mean(v), centre{o.x, o.y};
        contacts_.push_back({time(), d.id, pair.obstacle, symmetry(r, centre, velocity),
                             impact_parameter(r, centre, velocity),
                             std::sqrt(dot(velocity, velocity)), signed_area(r), shape_parameter(r),
                             centroid(r), velocity, centroid_velocity(r, v)});
        d.meet(pair.obstacle);
        if (kernels_.self_intersects(d.ring.x, d.ring.y, d.ring.count))
            stop(Guard::self_intersection, d.id);
    }
}

/// Cut one droplet along its neck. The daughters share its rest area and its mass in proportion to
/// their areas, and together keep its momentum.
inline void Island::break_up(const Finding& found) {
    list_contacts();
    if (stopped()) return;
    synchronize_velocities();
    const Droplet& parent = droplets_[found.droplet];
    const Shape whole{parent.positions(), parent.velocities()};
    const Neck neck = find_neck(
        whole.r, slackened({separation_.fraction, separation_.length * parent.ring.diameter}));
    const Cut line = place_cut(whole.r, neck);
    const auto [one, two] = cut(whole, line);
    const double areas[2] = {signed_area(one.r), signed_area(two.r)};

    Shape daughters[2] = {one, two};
    double rest[2];
    Vec2 momentum{0, 0};
    for (int k = 0; k < 2; ++k) {
        rest[k] = parent.ring.rest_area * areas[k] / (areas[0] + areas[1]);
        const double diameter = std::sqrt(rest[k] / kReferenceArea);
        if (!(diameter >= limit_of(Guard::daughter_size)))
            return stop(Guard::daughter_size, diameter);
        daughters[k] = respace(daughters[k], vertex_count(model_, diameter));
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
    const int generation = parent.generation + 1;
    const std::vector<int> contacted = parent.contacted;
    droplets_.erase(droplets_.begin() + found.droplet);
    look_.droplets.erase(look_.droplets.begin() + found.droplet);
    for (int k = 0; k < 2; ++k) {
        for (Vec2& v : daughters[k].v) v = v + correction;
        event.daughters[k] =
            add(Droplet(model_, rest[k], daughters[k].r, daughters[k].v), generation, contacted);
    }
    breakups_.push_back(event);
    if (generation > limit_of(Guard::generations)) return stop(Guard::generations, generation);
    renew_steps();
    if (stopped()) return;
    look_.lists.clear();
    if (model_.stop_at_breakup == 0.0) list_contacts();
    else if (front_tracking()) look_at_obstacles(look_);
    mark_pushed();
    if (front_tracking()) kernels_.settle_fronts(scene());
    retard_velocities();
}

}  // namespace pinchoff
