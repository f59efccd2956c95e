// Droplets that may meet one another, advanced together among obstacles.
//
// Time advances in blocks of steps. Before a block every droplet is looked over, exactly, by a list
// of detectors (events.hpp): guards, necks, first contacts, touching outlines. Each also gives a
// displacement below which its event cannot happen and no contact list can become incomplete. The
// block is as long as the present speeds suggest; the vertices' path over it is summed as it runs,
// and a block on which the path went beyond that budget is undone and repeated at half the length,
// down to a single step. So every event is found at the very step at which it happens, though most
// steps are not looked at.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "look.hpp"
#include "split.hpp"
#include "stability.hpp"

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

/// One droplet cut into two.
struct BreakupEvent {
    double time;
    int droplet, generation, daughters[2];
    double areas[2];
    double neck_thickness;
    Vec2 ends[2];
    DropletLook seen;  // the parent, just before
};

class Island {
public:
    Island(const Model& model, const Flow& flow, std::vector<Obstacle> obstacles,
           const std::vector<Start>& starts, const Kernels& kernels)
        : model_(model), flow_(flow), obstacles_(std::move(obstacles)), kernels_(kernels),
          separation_(model.neck_separation_in_diameters != 0.0
                          ? Separation{0.0, model.neck_separation}
                          : Separation{model.neck_separation, 0.0}),
          time_step_(model.time_step),
          sample_steps_(
              std::max<std::int64_t>(1, std::llround(model.sample_interval / model.time_step))) {
        for (const Start& s : starts) add(undeformed(model_, s), 0, {});
        renew_steps();
        list_contacts();
        retard_velocities();
    }

    Island(const Island&) = delete;
    Island(Island&&) = default;

    double time() const { return step_ * time_step_; }
    std::int64_t step() const { return step_; }
    std::int64_t sample_steps() const { return sample_steps_; }
    bool at_sample() const { return step_ % sample_steps_ == 0; }
    double sample_interval() const { return sample_steps_ * time_step_; }
    std::int64_t steps_taken() const { return steps_taken_; }
    std::int64_t vertex_updates() const { return vertex_updates_; }
    bool stopped() const { return alarm_.guard != Guard::none; }
    const Alarm& alarm() const { return alarm_; }
    const Model& model() const { return model_; }
    const Look& seen() const { return look_; }
    const std::vector<Droplet>& droplets() const { return droplets_; }
    const std::vector<Obstacle>& obstacles() const { return obstacles_; }
    const std::vector<ContactEvent>& contacts() const { return contacts_; }
    const std::vector<BreakupEvent>& breakups() const { return breakups_; }

    /// Look, let happen what has happened, and look again, until nothing more happens at this
    /// instant. Returns how far the vertices may move before something else can.
    Budget settle();

    /// The next block: as many steps as the budget lets pass unseen, at most to the next sample.
    void run_block(const Budget& budget);

    /// Velocities of every droplet at the time of its positions.
    std::vector<std::vector<Vec2>> synchronized_velocities();

private:
    Model model_;
    Flow flow_;
    std::vector<Obstacle> obstacles_;
    const Kernels& kernels_;
    Separation separation_;
    double time_step_;
    std::int64_t sample_steps_;
    std::int64_t step_ = 0;
    std::int64_t steps_taken_ = 0, vertex_updates_ = 0;
    int next_id_ = 0;
    Alarm alarm_;
    std::vector<Droplet> droplets_;
    std::vector<Ring> rings_;
    Look look_;
    std::vector<ContactEvent> contacts_;
    std::vector<BreakupEvent> breakups_;

    int add(Droplet droplet, int generation, const std::vector<int>& contacted) {
        droplet.id = next_id_++;
        droplet.generation = generation;
        droplet.contacted = contacted;
        droplets_.push_back(std::move(droplet));
        look_.droplets.emplace_back();
        return droplets_.back().id;
    }

    Scene scene() {
        rings_.clear();
        for (const Droplet& d : droplets_) rings_.push_back(d.ring);
        return {rings_.data(),
                static_cast<int>(rings_.size()),
                flow_,
                look_.lists.walls.data(),
                static_cast<int>(look_.lists.walls.size()),
                look_.lists.touches.data(),
                static_cast<int>(look_.lists.touches.size())};
    }

    bool front_tracking() const { return model_.front_tracking != 0.0; }

    /// Velocities from the time of the positions to that which the next step wants, and back. A
    /// front has no memory of its velocity: they follow from its positions.
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
        if (front_tracking()) return divide_steps();
        double safe = std::numeric_limits<double>::infinity();
        for (const Droplet& d : droplets_)
            if (d.ring.mass < 1.0 - 1e-9) safe = std::min(safe, safe_time_step(d.ring));
        if (safe < time_step_) {
            const double parts = std::ceil(time_step_ / safe);
            if (!(model_.time_step / time_step_ * parts <= limit_of(Guard::time_step)))
                return stop(Guard::time_step, model_.time_step / time_step_ * parts);
            time_step_ /= parts;
            step_ *= static_cast<std::int64_t>(parts);
            sample_steps_ *= static_cast<std::int64_t>(parts);
        }
        for (Droplet& d : droplets_) {
            const Relaxation r = relaxation(d.ring.drag_rate, time_step_);
            d.ring.kept = r.kept;
            d.ring.replaced = r.replaced;
        }
    }

    /// Front tracking: the same ring by ring, so that a small droplet shortens no other's step.
    void divide_steps() {
        for (Droplet& d : droplets_) {
            const double parts = std::max(1.0, std::ceil(time_step_ / safe_front_step(d.ring)));
            if (!(parts <= limit_of(Guard::time_step))) return stop(Guard::time_step, parts);
            d.ring.parts = static_cast<int>(parts);
        }
    }

    void stop(Guard guard, double value) {
        if (!stopped()) alarm_ = {guard, value, time()};
    }

    std::int64_t suggested_steps(const Budget& budget) const;
    bool within(const Budget& budget, std::int64_t steps) const;
    void survey();

    // The detectors' looks and what follows from them; see events.hpp.
    struct Detector {
        Finding (Island::*look)(Look&) const;
        void (Island::*happen)(const Finding&);
        bool renews;  // whether the event leaves other droplets behind: then look at all again
    };
    static const Detector kDetectors[];
    Finding look_at_soundness(Look& look) const;
    Finding look_at_necks(Look& look) const;
    Finding look_at_obstacles(Look& look) const;
    Finding look_at_touches(Look& look) const;
    void break_up(const Finding& found);
    void record_contacts(const Finding& found);
    void never(const Finding&) {}

    Guard unsound(const Droplet& d, const Survey& s, double& value) const;
    void list_contacts();
    void mark_pushed();
    void list_obstacle(Look& look, const Droplet& d, const Nearby& pair, Budget& budget) const;
};

/// Most steps of one block.
inline constexpr double kLongestBlock = 1e6;

inline std::int64_t Island::suggested_steps(const Budget& budget) const {
    double rate = 1e-12;
    for (const DropletLook& d : look_.droplets)
        rate = std::max(
            {rate, d.survey.speed / budget.absolute, d.survey.relative_speed / budget.relative});
    // A little less than the present speeds allow, so that a speeding droplet seldom costs a redo.
    return static_cast<std::int64_t>(std::min(0.7 / (rate * time_step_), kLongestBlock));
}

/// Whether the path of every vertex over the last block stayed within the budget. The path is at
/// most Δt √(n Σ|v|²) by Cauchy's inequality.
inline bool Island::within(const Budget& budget, std::int64_t steps) const {
    for (const Droplet& d : droplets_) {
        const double relative = time_step_ * std::sqrt(steps * largest_path(d.ring));
        const double drift = time_step_ * steps * std::hypot(d.ring.drift_x, d.ring.drift_y);
        if (!(relative <= budget.relative && relative + drift <= budget.absolute)) return false;
    }
    return true;
}

inline void Island::run_block(const Budget& budget) {
    const std::int64_t to_sample = sample_steps_ - step_ % sample_steps_;
    std::int64_t steps = std::clamp<std::int64_t>(suggested_steps(budget), 1, to_sample);
    for (Droplet& d : droplets_) d.save();
    while (true) {
        for (Droplet& d : droplets_) std::fill_n(d.ring.path, d.ring.padded, 0.0);
        (front_tracking() ? kernels_.advance_fronts : kernels_.advance)(scene(), time_step_,
                                                                        static_cast<int>(steps));
        if (steps == 1 || within(budget, steps)) break;
        for (Droplet& d : droplets_) d.restore();
        steps /= 2;
    }
    step_ += steps;
    steps_taken_ += steps;
    for (const Droplet& d : droplets_) vertex_updates_ += steps * d.ring.parts * d.ring.count;
}

inline std::vector<std::vector<Vec2>> Island::synchronized_velocities() {
    for (Droplet& d : droplets_) d.save();
    synchronize_velocities();
    std::vector<std::vector<Vec2>> velocities;
    for (const Droplet& d : droplets_) velocities.push_back(d.velocities());
    for (Droplet& d : droplets_) d.restore();
    return velocities;
}

}  // namespace pinchoff

#include "events.hpp"
