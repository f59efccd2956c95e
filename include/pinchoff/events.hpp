// What a Collision looks for between blocks of steps, and what it does when it finds it.
// Included by collision.hpp, which declares these functions.
#pragma once

namespace pinchoff {

/// Look over every droplet at this instant. Handles what has happened; returns how far the vertices
/// may move before something else can.
inline Collision::Budget Collision::look() {
    Budget budget;
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        Ring& ring = droplets_[i].ring;
        ring.drift_x = mean(ring.vx, ring.count);
        ring.drift_y = mean(ring.vy, ring.count);
        Survey s;
        kernels_.survey(ring, s);
        if (!sound(droplets_[i], s)) return budget;
        const double chords = watch_neck(droplets_[i], s);
        budget.relative = std::min(budget.relative, std::max(chords, 0.0));
        if (chords >= 0.0) continue;
        break_up(i);
        if (finished_) return budget;
        // The daughters change everything: begin again.
        budget = {};
        i = static_cast<std::size_t>(-1);
    }
    budget.absolute = list_contacts();
    if (!finished_ && !new_contact_.empty()) {
        record_contacts();
        budget.absolute = list_contacts();
    }
    return budget;
}

/// The guards on one droplet alone. False, and the run over, when one fires.
inline bool Collision::sound(Droplet& d, const Survey& s) {
    if (!(s.reach < kReachLimit * std::sqrt(d.ring.padded)))
        return raise(Guard::blow_up, s.reach / std::sqrt(d.ring.padded)), false;
    const double area_error = s.area / d.ring.rest_area - 1.0;
    if (!(std::fabs(area_error) <= kAreaLimit)) return raise(Guard::area, area_error), false;
    if (flow_.kind == FlowKind::sampled) {
        const Box box = bounding_box(d.ring);
        const double outside =
            std::max({flow_.x0 - box.left, box.right - flow_.x0 - (flow_.nx - 1) * flow_.dx,
                      flow_.y0 - box.bottom, box.top - flow_.y0 - (flow_.ny - 1) * flow_.dy});
        if (outside > 0.0) return raise(Guard::flow_domain, outside), false;
    }
    if (step_ % (kCrossingSamples * sample_steps_) == 0 &&
        kernels_.self_intersects(d.ring.x, d.ring.y, d.ring.count))
        return raise(Guard::self_intersection, d.id), false;
    return true;
}

/// A hair's breadth below a separation, so that round-off cannot disagree with the look that saw
/// it.
inline Separation slackened(Separation s) {
    constexpr double kSlack = 1.0 - 1e-9;
    return {kSlack * s.fraction, kSlack * s.length};
}

/// How far vertices may move before this droplet's neck can pass the threshold; negative when it
/// has. From the first contact on, the neck and the shape of the droplet that touched are sampled.
inline double Collision::watch_neck(Droplet& d, const Survey& s) {
    const double threshold = model_.neck_thickness * d.ring.diameter;
    const Separation separation{separation_.fraction, separation_.length * d.ring.diameter};
    const NeckScan scan =
        kernels_.scan_neck(d.ring.x, d.ring.y, d.ring.count, separation, threshold, d.work());
    d.thinnest = std::sqrt(scan.nearest2);
    // That a chord leaves both ends inwards is seen by the scan, that it crosses no edge here.
    const bool breaks = scan.thickness2 < threshold * threshold &&
                        find_neck(d.positions(), slackened(separation)).thickness < threshold;
    // On the grid of samples only, so that it does not matter where else blocks end.
    const bool sampled = step_ % sample_steps_ == 0 || breaks;
    if (sampled && !contacts_.empty() && d.id == contacts_.front().droplet) {
        minimum_neck_ = std::min(minimum_neck_, std::sqrt(scan.thickness2));
        maximum_shape_ = std::max(maximum_shape_, s.perimeter * s.perimeter / (4.0 * kPi * s.area));
    }
    if (breaks) return -1.0;
    return std::max(scan.budget, 0.0);
}

/// Build the contact lists of the coming block and note first contacts, which are not listed before
/// they are recorded: they are measured before the wall first pushes. Returns how far vertices may
/// move while the lists stay complete, no new contact begins and no edge crosses an obstacle
/// unseen.
inline double Collision::list_contacts() {
    double allowed = 1.0;
    lists_.clear();
    new_contact_.clear();
    for (Droplet& d : droplets_) d.ring.pushed = false;
    for (int i = 0; i < static_cast<int>(droplets_.size()); ++i) {
        Droplet& d = droplets_[i];
        distance2_.resize(d.ring.padded / kLanes);
        for (int o = 0; o < static_cast<int>(obstacles_.size()); ++o) {
            const Obstacle& obstacle = obstacles_[o];
            kernels_.chunk_distance2(d.ring, obstacle.x, obstacle.y, distance2_.data());
            const double vertex =
                std::sqrt(*std::min_element(distance2_.begin(), distance2_.end()));
            const double edge = std::sqrt(kernels_.edge_distance2(d.ring, obstacle.x, obstacle.y));
            // From its surface inwards, and on past the centre once that is in the droplet.
            const bool through = kernels_.contains(d.ring, obstacle.x, obstacle.y);
            const double depth = 1.0 - (through ? -edge : std::min(vertex, edge)) / obstacle.radius;
            if (depth > kPenetrationLimit) {
                raise(Guard::penetration, depth);
                return allowed;
            }
            const double gap = front_tracking()
                                   ? std::min(vertex, edge) - obstacle.radius - kFrontTouch
                                   : vertex - obstacle.radius - 0.5 * d.ring.rest_length;
            if (!d.has_met(o) && gap < 0.0) {
                new_contact_.push_back({i, o});
                if (!front_tracking()) continue;
            }
            const double range =
                front_tracking() ? front_range(d.ring, obstacle) : 0.5 * d.ring.rest_length;
            double room = gap;
            if (d.has_met(o) || front_tracking())
                room = list_wall(lists_, d, i, obstacle, distance2_.data(), range);
            if (!d.has_met(o)) room = std::min(room, std::max(gap, 0.0));
            const double edge_room = std::max(edge - obstacle.radius, wall_margin(obstacle));
            allowed = std::min({allowed, room, edge_room});
        }
    }
    return std::min(allowed, list_pairs());
}

/// List the contacts of droplets with each other and with themselves; returns how far vertices may
/// move while they are complete.
inline double Collision::list_pairs() {
    double allowed = 1.0;
    for (int i = 0; i < static_cast<int>(droplets_.size()); ++i) {
        for (int j = 0; j < static_cast<int>(droplets_.size()); ++j) {
            Droplet &a = droplets_[i], &b = droplets_[j];
            if (i == j) {
                allowed = std::min(allowed, list_own(a, i));
                continue;
            }
            const double margin = 0.5 * touch_of(a.ring, b.ring).length;
            const double range = front_tracking() ? 0.0 : margin;
            const double apart = gap(bounding_box(a.ring), bounding_box(b.ring)) - range;
            if (apart > 2.0 * margin) {
                allowed = std::min(allowed, 0.5 * apart);
                continue;
            }
            const double depth = list_touches(lists_, kernels_, a, i, b, j, range + 2.0 * margin);
            if (depth > range + margin) raise(Guard::overlap, depth);
            allowed = std::min(allowed, margin);
        }
    }
    return allowed;
}

/// List the parts of one droplet so thin that its sides repel; returns how far vertices may move
/// while the list is complete. A vertex within reach of an edge is within reach of a vertex half an
/// edge on.
inline double Collision::list_own(Droplet& d, int index) {
    const double l = d.ring.rest_length, range = 0.5 * touch_of(d.ring, d.ring).length,
                 margin = 0.25 * l;
    const double reach =
        std::hypot(range, l) + 2.0 * margin;  // longer edges are left to the guard on crossings
    if (d.thinnest > reach) return margin + 0.5 * (d.thinnest - reach);
    list_own_sides(lists_, d, index, range + 2.0 * margin, reach);
    return margin;
}

/// Measure the droplets that have just touched an obstacle, on their outlines.
inline void Collision::record_contacts() {
    for (const auto& [i, o] : new_contact_) {
        Droplet& d = droplets_[i];
        const std::vector<Vec2> r = d.positions(), v = synchronized_velocities(i);
        const Vec2 velocity = mean(v), centre{obstacles_[o].x, obstacles_[o].y};
        contacts_.push_back({time(), d.id, o, symmetry(r, centre, velocity),
                             impact_parameter(r, centre, velocity),
                             std::sqrt(dot(velocity, velocity)), signed_area(r), shape_parameter(r),
                             centroid(r), velocity, centroid_velocity(r, v)});
        d.meet(o);
        if (kernels_.self_intersects(d.ring.x, d.ring.y, d.ring.count))
            raise(Guard::self_intersection, d.id);
    }
}

/// Velocities of one droplet at the time of its positions.
inline std::vector<Vec2> Collision::synchronized_velocities(std::size_t droplet) {
    for (Droplet& each : droplets_) each.save();
    synchronize_velocities();
    std::vector<Vec2> v = droplets_[droplet].velocities();
    for (Droplet& each : droplets_) each.restore();
    return v;
}

/// Cut one droplet along its neck. The daughters share its rest area and its mass in proportion to
/// their areas, and together keep its momentum.
inline void Collision::break_up(std::size_t index) {
    list_contacts();
    if (finished_) return;
    synchronize_velocities();
    const Droplet parent = std::move(droplets_[index]);
    droplets_.erase(droplets_.begin() + static_cast<std::ptrdiff_t>(index));
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
        daughters[k] = respace(daughters[k], vertex_count(std::sqrt(rest[k] / kReferenceArea)));
        momentum = momentum + rest[k] / parent.ring.rest_area * mean(daughters[k].v);
    }
    const Vec2 correction = mean(whole.v) - momentum;
    BreakupEvent event{time(),
                       parent.id,
                       parent.generation,
                       {0, 0},
                       {areas[0], areas[1]},
                       neck.thickness,
                       {point_on(whole.r, line.first), point_on(whole.r, line.second)}};
    for (int k = 0; k < 2; ++k) {
        for (Vec2& v : daughters[k].v) v = v + correction;
        event.daughters[k] = add(daughters[k], rest[k], parent.generation + 1, parent.contacted);
    }
    breakups_.push_back(event);
    renew_steps();
    lists_.clear();
    finished_ = model_.stop_at_breakup != 0.0;
    if (!finished_) list_contacts();
    if (front_tracking()) kernels_.settle_fronts(scene());
    retard_velocities();
}

/// The contacts are those of the present block's lists, which are complete up to its end: a report
/// must neither build new ones nor fire a guard.
inline Energies Collision::energies() const {
    Energies sum;
    for (const Droplet& d : droplets_) add_energies(sum, d, obstacles_);
    for (const DropletContact& c : lists_.touches) {
        const Ring &a = droplets_[c.ring].ring, &b = droplets_[c.other].ring;
        const Nearest near =
            nearest_edge(b, {a.x[c.vertex], a.y[c.vertex]}, c.first_edge, c.edge_count);
        const Touch touch = touch_of(a, b);
        sum.touch += contact_energy(&a == &b ? std::fabs(near.distance) : near.distance,
                                    touch.length, touch.stiffness);
    }
    return sum;
}

/// Whether every droplet has left every obstacle behind, or the time is up.
inline bool Collision::ended() const {
    if (time() >= model_.time_limit) return true;
    if (obstacles_.empty()) return false;
    double rear = -std::numeric_limits<double>::infinity();
    for (const Obstacle& o : obstacles_) rear = std::max(rear, o.x + o.radius);
    for (const Droplet& d : droplets_)
        for (int i = 0; i < d.ring.count; ++i)
            if (d.ring.x[i] < rear + kDepartureDistance) return false;
    return true;
}

inline Result Collision::result() const {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    Result r;
    double* const fields = reinterpret_cast<double*>(&r);
    std::fill_n(fields, kResultFields, kNone);
    const bool timed_out = time() >= model_.time_limit && !obstacles_.empty();
    r.outcome = static_cast<double>(alarm_.guard != Guard::none ? Outcome::failed
                                    : !breakups_.empty()        ? Outcome::broke
                                    : timed_out                 ? Outcome::captured
                                                                : Outcome::slipped);
    r.guard = static_cast<double>(alarm_.guard);
    if (alarm_.guard != Guard::none) {
        r.guard_value = alarm_.value;
        r.guard_time = alarm_.time;
    }
    if (!contacts_.empty()) {
        const ContactEvent& c = contacts_.front();
        r.symmetry = c.symmetry;
        r.impact_parameter = c.impact_parameter;
        r.contact_time = c.time;
        r.contact_speed = c.speed;
        r.contact_area = c.area;
        r.contact_shape_parameter = c.shape_parameter;
        r.minimum_neck = minimum_neck_;
        r.maximum_shape_parameter = maximum_shape_;
    }
    if (!breakups_.empty()) {
        const BreakupEvent& b = breakups_.front();
        r.small_daughter_area = std::min(b.areas[0], b.areas[1]);
        r.large_daughter_area = std::max(b.areas[0], b.areas[1]);
        r.breakup_time = b.time;
        r.breakup_neck = b.neck_thickness;
    }
    r.breakup_count = static_cast<double>(breakups_.size());
    r.generations = 0;
    for (const BreakupEvent& b : breakups_)
        r.generations = std::max(r.generations, b.generation + 1.0);
    r.droplet_count = static_cast<double>(droplets_.size());
    r.end_time = time();
    r.steps = static_cast<double>(total_steps_);
    r.vertex_updates = static_cast<double>(vertex_updates_);
    return r;
}

}  // namespace pinchoff
