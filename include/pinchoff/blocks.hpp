// Time goes on in blocks of steps. Included by island.hpp, which declares these functions.
//
// A block is as long as the present speeds and the detectors' budget suggest; the vertices' path
// over it is summed as it runs, and a block on which the path went beyond the budget is undone and
// repeated at half the length, down to a single step. So no event is missed, though most steps are
// not looked at.
#pragma once

namespace pinchoff {

/// Part of the budget that a block is planned to use.
inline constexpr double kBlockSafety = 0.7;
/// Most steps of one block.
inline constexpr double kLongestBlock = 1e6;

inline void Island::begin(double time) {
    start_ = time;
    step_ = 0;
    time_step_ = world_->model.time_step;
    sample_steps_ =
        std::max<std::int64_t>(1, std::llround(world_->model.sample_interval / time_step_));
    strayed_ = false;
    renew_steps();
    const auto in_step = [&](const Droplet& d) { return d.lag == 0.5 * time_step_; };
    if (std::ranges::all_of(droplets_, in_step)) return;
    survey();
    list_contacts();
    set_lags(0.5 * time_step_);
}

/// Carries the velocities, with the forces of the present positions, to where they are a time
/// behind them.
inline void Island::set_lags(double lag) {
    bool any = false;
    for (Droplet& d : droplets_) {
        d.ring.shift = d.lag - lag;
        any = any || d.ring.shift != 0.0;
        d.lag = lag;
    }
    if (any) carry_velocities();
}

/// Carries the velocities over the `shift` of each ring. A front has no memory of its velocity: it
/// follows from the positions.
inline void Island::carry_velocities() {
    if (world_->fronts()) world_->kernels.front_velocities(scene(), time_step_);
    else world_->kernels.shift_velocities(scene());
}

/// Divide the time step by the least whole number that makes it safe for droplets smaller than the
/// model's, for which it was chosen; and set what depends on the step.
inline void Island::renew_steps() {
    if (world_->fronts()) return divide_steps();
    double safe = std::numeric_limits<double>::infinity();
    for (const Droplet& d : droplets_)
        if (d.ring.mass < 1.0 - 1e-9) safe = std::min(safe, safe_time_step(d.ring));
    if (safe < time_step_) {
        double parts = std::ceil(time_step_ / safe);
        const double so_far = world_->model.time_step / time_step_;
        if (!(so_far * parts <= limit_of(Guard::time_step))) {
            if (!world_->retires) return stop(Guard::time_step, so_far * parts);
            // The droplet that wants more is then refused by the guards on itself.
            parts = std::max(1.0, std::floor(limit_of(Guard::time_step) / so_far));
        }
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
inline void Island::divide_steps() {
    for (Droplet& d : droplets_) {
        const double parts = std::max(1.0, std::ceil(time_step_ / safe_front_step(d.ring)));
        if (!(parts <= limit_of(Guard::time_step)) && !world_->retires)
            return stop(Guard::time_step, parts);
        d.ring.parts = static_cast<int>(std::min(parts, limit_of(Guard::time_step)));
    }
}

inline std::int64_t Island::suggested_steps(const Budget& budget) const {
    double rate = 1e-12;
    for (const DropletLook& d : look_.droplets)
        rate = std::max(
            {rate, d.survey.speed / budget.absolute, d.survey.relative_speed / budget.relative});
    // A little less than the present speeds allow, so that a speeding droplet seldom costs a redo.
    return static_cast<std::int64_t>(std::min(kBlockSafety / (rate * time_step_), kLongestBlock));
}

/// Whether the path of every vertex over the last block stayed within the budget; notes the paths.
/// A path is at most Δt √(n Σ|v|²) by Cauchy's inequality.
inline bool Island::within(const Budget& budget, std::int64_t steps) {
    bool all = true;
    const auto count = static_cast<double>(steps);
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        const Ring& ring = droplets_[i].ring;
        DropletLook& seen = look_.droplets[i];
        seen.relative = time_step_ * std::sqrt(count * largest_path(ring));
        seen.drift = time_step_ * count * std::hypot(ring.drift_x, ring.drift_y);
        all = all && seen.relative <= budget.relative &&
              seen.relative + seen.drift <= budget.absolute;
    }
    return all;
}

inline void Island::run_block(const Budget& budget) {
    const std::int64_t most = std::min(steps_to_sample(), steps_to_merge());
    std::int64_t steps = std::clamp<std::int64_t>(suggested_steps(budget), 1, most);
    for (Droplet& d : droplets_) d.save();
    while (true) {
        for (Droplet& d : droplets_) std::fill_n(d.ring.path, d.ring.padded, 0.0);
        (world_->fronts() ? world_->kernels.advance_fronts : world_->kernels.advance)(
            scene(), time_step_, static_cast<int>(steps));
        if (within(budget, steps) || steps == 1) break;
        for (Droplet& d : droplets_) d.restore();
        steps /= 2;
    }
    step_ += steps;
    steps_taken_ += steps;
    run_clocks(steps);
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        Droplet& d = droplets_[i];
        DropletLook& seen = look_.droplets[i];
        vertex_updates_ += steps * d.ring.parts * d.ring.count;
        seen.neck_room -= seen.relative;
        seen.thinnest -= 2.0 * seen.relative;
        d.travelled += seen.relative + seen.drift;
        strayed_ = strayed_ || d.travelled > d.travel;
    }
}

inline std::vector<std::vector<Vec2>> Island::synchronized_velocities() {
    for (Droplet& d : droplets_) {
        d.save();
        d.ring.shift = d.lag;
    }
    carry_velocities();
    std::vector<std::vector<Vec2>> velocities;
    for (const Droplet& d : droplets_) velocities.push_back(d.velocities());
    for (Droplet& d : droplets_) d.restore();
    return velocities;
}

}  // namespace pinchoff
