// Droplets and obstacles from the start to the outcome.
//
// Time advances in blocks of steps. Before a block every droplet is looked over, exactly: guards,
// first contact, the neck. The look also gives a displacement below which no event can happen and
// no contact list can become incomplete. The block is as long as the present speeds suggest; the
// vertices' path over it is summed as it runs, and a block on which the path went beyond the bound
// is undone and repeated at half the length, down to a single step. So every event is found at the
// very step at which it happens, though most steps are not looked at.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "contact.hpp"
#include "energy.hpp"
#include "split.hpp"
#include "stability.hpp"

namespace pinchoff {

/// First touch of one droplet with one obstacle.
///
/// The velocity is that of the centre of mass of the model, whose mass sits on the vertices: the
/// mean of theirs. The centroid of the area moves a little differently while the front edge stops.
struct ContactEvent {
    double time;
    int droplet, obstacle;
    double symmetry, impact_parameter, speed, area, shape_parameter;
    Vec2 centroid, velocity, centroid_velocity;
};

/// One droplet cut into two.
struct BreakupEvent {
    double time;
    int droplet, generation, daughters[2];
    double areas[2];
    double neck_thickness;
    Vec2 ends[2];
};

/// A droplet at the start: a regular polygon at rest.
struct Start {
    double x, y, diameter;
};

class Collision {
public:
    Collision(const Model& model, const Flow& flow, std::vector<Obstacle> obstacles,
              const std::vector<Start>& starts, const Kernels& kernels)
        : model_(model), flow_(flow), obstacles_(std::move(obstacles)), kernels_(kernels),
          separation_(model.neck_separation_in_diameters != 0.0
                          ? Separation{0.0, model.neck_separation}
                          : Separation{model.neck_separation, 0.0}),
          time_step_(model.time_step),
          sample_steps_(std::max(1L, std::lround(model.sample_interval / model.time_step))) {
        for (const Start& s : starts) place(s);
        renew_steps();
        list_contacts();
        retard_velocities();
    }

    Collision(const Collision&) = delete;
    Collision(Collision&&) = default;

    double time() const { return step_ * time_step_; }
    bool finished() const { return finished_; }
    const Alarm& alarm() const { return alarm_; }
    const std::vector<Droplet>& droplets() const { return droplets_; }
    const std::vector<Obstacle>& obstacles() const { return obstacles_; }
    const std::vector<ContactEvent>& contacts() const { return contacts_; }
    const std::vector<BreakupEvent>& breakups() const { return breakups_; }

    /// Run to the first sample at or after `until`, or to the end.
    void advance(double until) {
        const double samples = std::ceil(until / (sample_steps_ * time_step_) - 1e-9);
        while (!finished_ && step_ < samples * sample_steps_) run_block();
    }

    /// Velocities of one droplet at the time of its positions.
    std::vector<Vec2> synchronized_velocities(std::size_t droplet);

    /// Energies of all droplets, term by term.
    Energies energies() const;
    Result result() const;

private:
    Model model_;
    Flow flow_;
    std::vector<Obstacle> obstacles_;
    const Kernels& kernels_;
    Separation separation_;
    double time_step_;
    long sample_steps_;
    long step_ = 0;
    long total_steps_ = 0, vertex_updates_ = 0;
    bool finished_ = false;
    int next_id_ = 0;
    double minimum_neck_ = std::numeric_limits<double>::infinity();
    double maximum_shape_ = 0;
    Alarm alarm_;
    std::vector<Droplet> droplets_;
    std::vector<Ring> rings_;
    std::vector<double> distance2_;
    ContactLists lists_;
    std::vector<std::pair<int, int>> new_contact_;  // droplet and obstacle
    std::vector<ContactEvent> contacts_;
    std::vector<BreakupEvent> breakups_;

    /// How far vertices may move before something could happen: in all, and relative to the drift.
    struct Budget {
        double absolute = 1.0, relative = 1.0;
    };

    void place(const Start& s) {
        const double mass = s.diameter * s.diameter;
        const int count = vertex_count(s.diameter);
        const double area = kReferenceArea * mass;
        const double angle = 2.0 * kPi / count;
        const double radius = 0.5 * rest_length(area, count) / std::sin(0.5 * angle);
        std::vector<Vec2> r(count), v(count, Vec2{0, 0});
        // An edge, not a vertex, faces the obstacle.
        for (int i = 0; i < count; ++i)
            r[i] = {s.x + radius * std::cos((i + 0.5) * angle),
                    s.y + radius * std::sin((i + 0.5) * angle)};
        add({r, v}, area, 0, {});
    }

    /// Vertices for a droplet of this diameter at the spacing of the reference droplet.
    int vertex_count(double diameter) const {
        return std::max(kLeastVertices,
                        static_cast<int>(std::lround(model_.vertex_count * diameter)));
    }

    int add(const Shape& shape, double rest_area, int generation,
            const std::vector<int>& contacted) {
        droplets_.emplace_back(model_, rest_area, shape.r, shape.v);
        droplets_.back().id = next_id_++;
        droplets_.back().generation = generation;
        droplets_.back().contacted = contacted;
        return droplets_.back().id;
    }

    Scene scene() {
        rings_.clear();
        for (const Droplet& d : droplets_) rings_.push_back(d.ring);
        return {rings_.data(),
                static_cast<int>(rings_.size()),
                flow_,
                lists_.walls.data(),
                static_cast<int>(lists_.walls.size()),
                lists_.touches.data(),
                static_cast<int>(lists_.touches.size())};
    }

    bool front_tracking() const { return model_.front_tracking != 0.0; }

    /// Velocities from the time of the positions to that which the next step wants, and back.
    void retard_velocities() {
        if (front_tracking()) kernels_.front_velocities(scene(), time_step_);
        else kernels_.shift_velocities(scene(), -0.5 * time_step_);
    }
    void synchronize_velocities() {
        if (front_tracking()) kernels_.front_velocities(scene(), time_step_);
        else kernels_.shift_velocities(scene(), 0.5 * time_step_);
    }

    /// Divide the time step by the least whole number that makes it safe for droplets smaller than
    /// the model's, for which it was chosen; and set what depends on the step.
    void renew_steps() {
        if (front_tracking()) {
            for (Droplet& d : droplets_) {
                const double safe = safe_front_step(d.ring);
                d.ring.parts =
                    time_step_ > safe ? static_cast<int>(std::ceil(time_step_ / safe)) : 1;
            }
            return;
        }
        double safe = std::numeric_limits<double>::infinity();
        for (const Droplet& d : droplets_)
            if (d.ring.mass < 1.0 - 1e-9) safe = std::min(safe, safe_time_step(d.ring));
        if (safe < time_step_) {
            const long parts = static_cast<long>(std::ceil(time_step_ / safe));
            time_step_ /= parts;
            step_ *= parts;
            sample_steps_ *= parts;
        }
        for (Droplet& d : droplets_) {
            const Relaxation r = relaxation(d.ring.drag_rate, time_step_);
            d.ring.kept = r.kept;
            d.ring.replaced = r.replaced;
        }
    }

    void raise(Guard guard, double value) {
        if (alarm_.guard == Guard::none) alarm_ = {guard, value, time()};
        finished_ = true;
    }

    void run_block() {
        Budget budget = look();
        if (finished_) return;
        if (step_ % sample_steps_ == 0 && ended()) {
            finished_ = true;
            return;
        }
        const long to_sample = sample_steps_ - step_ % sample_steps_;
        long steps = std::clamp(suggested_steps(budget), 1L, to_sample);
        for (Droplet& d : droplets_) d.save();
        while (true) {
            for (Droplet& d : droplets_) std::fill_n(d.ring.path, d.ring.padded, 0.0);
            (front_tracking() ? kernels_.advance_fronts : kernels_.advance)(
                scene(), time_step_, static_cast<int>(steps));
            if (steps == 1 || within(budget, steps)) break;
            for (Droplet& d : droplets_) d.restore();
            steps /= 2;
        }
        step_ += steps;
        total_steps_ += steps;
        for (const Droplet& d : droplets_) vertex_updates_ += steps * d.ring.count;
    }

    long suggested_steps(const Budget& budget) {
        double rate = 1e-12;
        for (Droplet& d : droplets_) {
            Survey s;
            kernels_.survey(d.ring, s);
            rate = std::max({rate, s.speed / budget.absolute, s.relative_speed / budget.relative});
        }
        // A little less than the present speeds allow, so that a speeding droplet seldom costs a
        // redo.
        return static_cast<long>(std::min(0.7 / (rate * time_step_), 1e6));
    }

    /// Whether the path of every vertex over the last block stayed within the budget. The path is
    /// at most Δt √(n Σ|v|²) by Cauchy's inequality.
    bool within(const Budget& budget, long steps) const {
        for (const Droplet& d : droplets_) {
            const double relative = time_step_ * std::sqrt(steps * largest_path(d.ring));
            const double drift = time_step_ * steps * std::hypot(d.ring.drift_x, d.ring.drift_y);
            if (!(relative <= budget.relative && relative + drift <= budget.absolute)) return false;
        }
        return true;
    }

    Budget look();
    bool sound(Droplet& d, const Survey& s);
    double watch_neck(Droplet& d, const Survey& s);
    double list_contacts();
    double list_pairs();
    double list_own(Droplet& d, int index);
    void record_contacts();
    void break_up(std::size_t index);
    bool ended() const;
};

}  // namespace pinchoff

#include "events.hpp"
