// Droplets and obstacles from the start to the outcome: one island, and what comes of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "energy.hpp"
#include "island.hpp"

namespace pinchoff {

class Collision {
public:
    Collision(const Model& model, const Flow& flow, std::vector<Obstacle> obstacles,
              const std::vector<Start>& starts, const Kernels& kernels)
        : world_(std::make_unique<const World>(
              World{model, flow, ObstacleGrid(std::move(obstacles), {}), kernels})),
          island_(*world_) {
        for (const Start& s : starts) island_.add(undeformed(model, s));
        island_.begin(0.0);
    }

    double time() const { return island_.time(); }
    bool finished() const { return finished_ || island_.stopped(); }
    const std::vector<Droplet>& droplets() const { return island_.droplets(); }
    const std::vector<Obstacle>& obstacles() const { return world_->obstacles.obstacles(); }
    const std::vector<ContactEvent>& contacts() const { return island_.contacts(); }
    const std::vector<BreakupEvent>& breakups() const { return island_.breakups(); }
    std::vector<std::vector<Vec2>> synchronized_velocities() {
        return island_.synchronized_velocities();
    }

    /// Run to the first sample at or after `until`, or to the end, or until stop() is true, which
    /// is asked before every block.
    template <class Stop>
    void advance(double until, const Stop& stop) {
        const double samples = std::ceil(until / island_.sample_interval() - 1e-9);
        while (!finished() &&
               static_cast<double>(island_.step()) <
                   samples * static_cast<double>(island_.sample_steps()) &&
               !stop())
            run_block();
    }

    /// Energies of all droplets, term by term.
    Energies energies() const;
    Result result() const;

private:
    std::unique_ptr<const World> world_;
    Island island_;
    bool finished_ = false;
    double minimum_neck_ = std::numeric_limits<double>::infinity();
    double maximum_shape_ = 0, maximum_perimeter_ = 0;

    void run_block() {
        const int watched = contacts().empty() ? -1 : contacts().front().droplet;
        const std::size_t before = breakups().size();
        island_.watch(watched);
        const Budget budget = island_.settle();
        sample_neck(watched, before);
        const bool broke = breakups().size() > before;
        if (island_.stopped()) return;
        finished_ =
            (broke && world_->model.stop_at_breakup != 0.0) || (island_.at_sample() && ended());
        if (finished_) island_.look_for_crossings();
        else island_.run_block(budget);
    }

    void sample_neck(int watched, std::size_t breakups_before);
    bool ended() const;
};

/// The neck and the shape of the droplet that touched first, from there to its break-up. On the
/// grid of samples only, so that it does not matter where else blocks end, and where it breaks.
inline void Collision::sample_neck(int watched, std::size_t breakups_before) {
    const auto sample = [&](const DropletLook& seen) {
        if (!seen.scanned) return;
        minimum_neck_ = std::min(minimum_neck_, std::sqrt(seen.neck.thickness2));
        maximum_shape_ =
            std::max(maximum_shape_, shape_parameter(seen.survey.perimeter, seen.survey.area));
        maximum_perimeter_ = std::max(maximum_perimeter_, seen.survey.perimeter);
    };
    for (std::size_t i = breakups_before; i < breakups().size(); ++i)
        if (breakups()[i].droplet == watched) sample(breakups()[i].seen);
    if (!island_.at_sample()) return;
    for (std::size_t i = 0; i < droplets().size(); ++i)
        if (droplets()[i].id == watched) sample(island_.seen().droplets[i]);
}

/// The contacts are those of the present block's lists, which are complete up to its end: a report
/// must neither build new ones nor fire a guard.
inline Energies Collision::energies() const {
    Energies sum;
    for (const Droplet& d : droplets()) add_energies(sum, d, obstacles());
    for (const DropletContact& c : island_.seen().lists.touches) {
        const Ring &a = droplets()[c.ring].ring, &b = droplets()[c.other].ring;
        const Nearest near =
            nearest_edge(b, {a.x[c.vertex], a.y[c.vertex]}, c.first_edge, c.edge_count);
        const Touch touch = touch_of(a, b);
        sum.contact += contact_energy(&a == &b ? std::fabs(near.distance) : near.distance,
                                      touch.length, touch.stiffness);
    }
    return sum;
}

/// Whether every droplet has left every obstacle behind, or the time is up.
inline bool Collision::ended() const {
    if (time() >= world_->model.time_limit) return true;
    if (obstacles().empty()) return false;
    double rear = -std::numeric_limits<double>::infinity();
    for (const Obstacle& o : obstacles()) rear = std::max(rear, o.x + o.radius);
    for (const Droplet& d : droplets())
        for (int i = 0; i < d.ring.count; ++i)
            if (d.ring.x[i] < rear + kDepartureDistance) return false;
    return true;
}

inline Result Collision::result() const {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    Result r;
    double* const fields = reinterpret_cast<double*>(&r);
    std::fill_n(fields, kResultFields, kNone);
    const Alarm& alarm = island_.alarm();
    const bool timed_out = time() >= world_->model.time_limit && !obstacles().empty();
    r.outcome = static_cast<double>(alarm.guard != Guard::none ? Outcome::failed
                                    : !breakups().empty()      ? Outcome::broke
                                    : timed_out                ? Outcome::captured
                                                               : Outcome::slipped);
    r.guard = static_cast<double>(alarm.guard);
    if (alarm.guard != Guard::none) {
        r.guard_value = alarm.value;
        r.guard_time = alarm.time;
    }
    if (!contacts().empty()) {
        const ContactEvent& c = contacts().front();
        r.symmetry = c.symmetry;
        r.impact_parameter = c.impact_parameter;
        r.contact_time = c.time;
        r.contact_speed = c.speed;
        r.contact_area = c.area;
        r.contact_shape_parameter = c.shape_parameter;
        r.minimum_neck = minimum_neck_;
        r.maximum_shape_parameter = maximum_shape_;
        r.maximum_perimeter = maximum_perimeter_;
    }
    if (!breakups().empty()) {
        const BreakupEvent& b = breakups().front();
        r.small_daughter_area = std::min(b.areas[0], b.areas[1]);
        r.large_daughter_area = std::max(b.areas[0], b.areas[1]);
        r.breakup_time = b.time;
        r.breakup_neck = b.neck_thickness;
    }
    r.breakup_count = static_cast<double>(breakups().size());
    r.generations = 0;
    for (const BreakupEvent& b : breakups())
        r.generations = std::max(r.generations, b.generation + 1.0);
    r.droplet_count = static_cast<double>(droplets().size());
    r.end_time = time();
    r.steps = static_cast<double>(island_.steps_taken());
    r.vertex_updates = static_cast<double>(island_.vertex_updates());
    return r;
}

}  // namespace pinchoff
