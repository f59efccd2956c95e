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
    {&Island::look_at_films, &Island::tend_films, true},
};

inline Budget Island::settle() {
    Budget budget;
    open_bridges();
    Round round = Round::again;
    while (round == Round::again) {
        survey();
        budget = {};
        round = look_round(budget);
    }
    if (round == Round::ended) return budget;
    mark_pushed();
    measure_films();
    return budget;
}

/// Looks with one detector after the other. What happened may leave other droplets behind: then all
/// look again. A detector whose event leaves the droplets as they are looks again by itself.
inline Island::Round Island::look_round(Budget& budget) {
    for (const Detector& detector : kDetectors) {
        Finding found;
        do {
            found = (this->*detector.look)(look_);
            const bool refused = found.guard != Guard::none;
            if (refused && !world_->retires) stop(found.guard, found.value);
            if (stopped()) return Round::ended;
            if (refused) mend(found);
            else if (found.happened) (this->*detector.happen)(found);
            if (stopped()) return Round::ended;
            if (refused) return Round::again;
            if (found.happened && detector.renews)
                return world_->model.stop_at_breakup != 0.0 ? Round::ended : Round::again;
        } while (found.happened);
        budget.limit_to(found.budget);
    }
    return Round::quiet;
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
    if (blown_up(d.ring, s)) return Guard::blow_up;
    value = s.area / d.ring.rest_area - 1.0;
    if (out_of_area(d.ring, s)) return Guard::area;
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

/// A run that ends is looked at once more: crossing edges are sought now and then only, and not
/// among the daughters of a break-up that ends it.
inline void Island::look_for_crossings() {
    for (const Droplet& d : droplets_)
        if (world_->kernels.self_intersects(d.ring.x, d.ring.y, d.ring.count))
            return stop(Guard::self_intersection, d.id);
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
        const double way =
            seen.survey.relative_speed * time_step_ * static_cast<double>(steps_to_sample());
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

}  // namespace pinchoff
