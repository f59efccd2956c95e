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

#include "film.hpp"
#include "join.hpp"
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

/// Where droplets are many, one is spaced anew when at its proper spacing it would have this many
/// times the vertices that it has, or that it has this many times those.
inline constexpr double kDrawnOut = 2.0, kDrawnIn = 1.6;

/// What droplets move in, the same for every island.
struct World {
    Model model;
    Flow flow;
    ObstacleGrid obstacles;
    const Kernels& kernels;
    Period period{};
    double sample_interval = model.sample_interval;  // t0
    bool retires = false;          // a droplet that a guard refuses is taken out; or the run ends
    double smallest_breaking = 0;  // diameter below which a droplet's neck is not looked at, D0
    bool exhaustive = false;       // everybody is compared with everybody, for tests
    Coalescence coalescence{};
    Separation separation = model.neck_separation_in_diameters != 0.0
                                ? Separation{0.0, model.neck_separation}
                                : Separation{model.neck_separation, 0.0};

    bool fronts() const { return model.front_tracking != 0.0; }

    /// Vertices for a droplet of this perimeter: with many droplets and front tracking one that is
    /// drawn out gets more, so that no obstacle passes between two of them.
    int vertices_for(double diameter, double perimeter) const {
        const int round = vertex_count(model, diameter);
        const int drawn_out = vertex_count(model, diameter, perimeter);
        return retires && fronts() && drawn_out >= kDrawnOut * round ? drawn_out : round;
    }
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

class Island {
public:
    explicit Island(const World& world) : world_(&world) {}

    Island(const Island&) = delete;
    Island(Island&&) = default;

    /// Takes a droplet in; one that has no number yet is given one: 0, 1, ..., or, where an
    /// emulsion gives the final ones, -2, -3, .... Returns its number.
    int add(Droplet droplet);

    /// Takes in a contact of droplets, which begins no more.
    void add(const Film& film) { films_.push_back(film); }

    /// Empty, as if new, with its memory kept.
    void clear();

    /// Gives away its droplets and all that has happened to them.
    void hand_over(IslandResult& result);

    /// Starts the clock at a time, with the model's step or the part of it that is safe for all.
    void begin(double time);

    double time() const { return start_ + step_ * time_step_; }
    std::int64_t step() const { return step_; }
    std::int64_t sample_steps() const { return sample_steps_; }
    bool at_sample() const { return step_ % sample_steps_ == 0; }
    double sample_interval() const { return sample_steps_ * time_step_; }
    std::int64_t steps_taken() const { return steps_taken_; }
    std::int64_t vertex_updates() const { return vertex_updates_; }
    bool stopped() const { return alarm_.guard != Guard::none; }
    bool strayed() const { return strayed_; }
    const Alarm& alarm() const { return alarm_; }
    const World& world() const { return *world_; }
    const Look& seen() const { return look_; }
    const std::vector<Droplet>& droplets() const { return droplets_; }
    const std::vector<ContactEvent>& contacts() const { return contacts_; }
    const std::vector<BreakupEvent>& breakups() const { return breakups_; }

    /// The droplet whose neck is looked at at every sample; -1 for none.
    void watch(int droplet) { watched_ = droplet; }

    /// Look, let happen what has happened, and look again, until nothing more happens at this
    /// instant. Returns how far the vertices may move before something else can.
    Budget settle();

    /// The next block: as many steps as the budget lets pass unseen, at most to the next sample.
    void run_block(const Budget& budget);

    /// Velocities of every droplet at the time of its positions.
    std::vector<std::vector<Vec2>> synchronized_velocities();

    /// Contact lists of the present positions, whatever happens there; a guard may stop the run.
    void list_contacts();

private:
    const World* world_;
    double start_ = 0, time_step_ = 0;
    std::int64_t sample_steps_ = 1;
    std::int64_t step_ = 0;
    std::int64_t steps_taken_ = 0, vertex_updates_ = 0;
    int ids_given_ = 0;
    int watched_ = -1;
    bool strayed_ = false;  // whether a droplet went further than its `travel`
    Alarm alarm_;
    std::vector<Droplet> droplets_;
    std::vector<Droplet> gone_;
    std::vector<Ring> rings_;
    std::vector<Box> boxes_;
    std::vector<DropletPair> pairs_;
    PairFinder finder_;
    Look look_;
    std::vector<ContactEvent> contacts_;
    std::vector<BreakupEvent> breakups_;
    std::vector<RefusalEvent> refusals_;
    std::vector<Film> films_;        // by numbers
    std::vector<Film> handed_down_;  // to droplets that have just come of others, if they touch
    std::vector<FilmEvent> film_events_;

    Scene scene() {
        rings_.clear();
        for (const Droplet& d : droplets_) rings_.push_back(d.ring);
        const std::vector<WallContact>& walls = look_.lists.walls;  // by droplets
        for (int c = static_cast<int>(walls.size()) - 1; c >= 0; --c) {
            Ring& ring = rings_[walls[c].ring];
            ring.first_wall = c;
            if (ring.last_wall == 0) ring.last_wall = c + 1;
        }
        return {rings_.data(),
                static_cast<int>(rings_.size()),
                world_->flow,
                look_.lists.walls.data(),
                static_cast<int>(look_.lists.walls.size()),
                look_.lists.touches.data(),
                static_cast<int>(look_.lists.touches.size())};
    }

    void stop(Guard guard, double value) {
        if (!stopped()) alarm_ = {guard, value, time()};
    }

    void set_lags(double lag);
    void carry_velocities();
    void divide_steps();
    void renew_steps();
    void remove(int index);
    void mend(const Finding& found);
    static Droplet heir(const Droplet& parent, Droplet droplet);
    std::int64_t steps_to_sample() const { return sample_steps_ - step_ % sample_steps_; }
    std::int64_t suggested_steps(const Budget& budget) const;
    bool within(const Budget& budget, std::int64_t steps);
    void survey();
    bool looks_at_all() const;
    void seek_neighbours();
    void seek_obstacles(Droplet& d, const Box& box) const;

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
    Finding look_at_films(Look& look) const;
    void break_up(const Finding& found);
    void tend_films(const Finding& found);
    void record_contacts(const Finding& found);
    void never(const Finding&) {}

    Guard unsound(const Droplet& d, const Survey& s, double& value) const;
    void mark_pushed();
    void settle_heirs();

    // Coalescence; see coalescence.hpp.
    void open_bridges();
    void measure_facing(Look& look, const DropletPair& pair, std::size_t first) const;
    void measure_films();
    void run_clocks(std::int64_t steps);
    std::int64_t steps_to_merge() const;
    bool merges(const Film& film, double share) const;
    void begin_film(const Facing& f);
    bool merge(const Film& film);
    void replace_by_merged(const Film& film, Droplet merged);
    Vec2 nearest_image(int i, int j) const;
    Guard wrong_with(const Droplet& merged, double& value) const;
    std::vector<Film> end_films(int id);
    void hand_down(const std::vector<Film>& films, int from, int to);
    int index_of(int id) const;
    void note_film(FilmStage stage, const Film& film, Guard guard = Guard::none, double value = 0);
    void list_obstacle(Look& look, const Droplet& d, const Nearby& pair, Budget& budget) const;
};

/// Part of the budget that a block is planned to use.
inline constexpr double kBlockSafety = 0.7;
/// Most steps of one block.
inline constexpr double kLongestBlock = 1e6;
/// How much wider than a droplet the box is that it is kept in while its neighbours are known, D0.
inline constexpr double kKeptMargin = 0.25;
/// Up to so many bodies in all, comparing all of them is faster than knowing the neighbours.
inline constexpr int kFewBodies = 8;

inline int Island::add(Droplet droplet) {
    if (droplet.id == kNoNumber) {
        droplet.id = world_->retires ? -2 - ids_given_ : ids_given_;
        ++ids_given_;
    }
    look_.droplets.push_back(droplet.seen);
    droplets_.push_back(std::move(droplet));
    return droplets_.back().id;
}

inline void Island::clear() {
    droplets_.clear();
    gone_.clear();
    contacts_.clear();
    breakups_.clear();
    refusals_.clear();
    films_.clear();
    handed_down_.clear();
    film_events_.clear();
    look_.droplets.clear();
    look_.lists.clear();
    boxes_.clear();
    ids_given_ = 0;
    steps_taken_ = vertex_updates_ = 0;
    alarm_ = {};
}

inline void Island::hand_over(IslandResult& result) {
    for (std::size_t i = 0; i < droplets_.size(); ++i) droplets_[i].seen = look_.droplets[i];
    result.done = !strayed_;
    result.droplets.swap(droplets_);
    result.gone.swap(gone_);
    result.contacts.swap(contacts_);
    result.breakups.swap(breakups_);
    result.refusals.swap(refusals_);
    result.films.swap(films_);
    result.film_events.swap(film_events_);
    result.steps = steps_taken_;
    result.vertex_updates = vertex_updates_;
    result.ids_given = ids_given_;
}

inline void Island::begin(double time) {
    start_ = time;
    step_ = 0;
    time_step_ = world_->model.time_step;
    sample_steps_ = std::max<std::int64_t>(1, std::llround(world_->sample_interval / time_step_));
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
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        const Ring& ring = droplets_[i].ring;
        DropletLook& seen = look_.droplets[i];
        seen.relative = time_step_ * std::sqrt(steps * largest_path(ring));
        seen.drift = time_step_ * steps * std::hypot(ring.drift_x, ring.drift_y);
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

#include "coalescence.hpp"
#include "events.hpp"
