// Droplets that may meet one another, advanced together among obstacles.
//
// Before a block of steps (blocks.hpp) every droplet is looked over by a list of detectors
// (events.hpp), which find every event at the very step at which it happens. The parts of an island
// are in files of their own, included at the end.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "island_result.hpp"
#include "join.hpp"
#include "look.hpp"
#include "split.hpp"
#include "stability.hpp"
#include "world.hpp"

namespace pinchoff {

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

    double time() const { return start_ + static_cast<double>(step_) * time_step_; }
    std::int64_t step() const { return step_; }
    std::int64_t sample_steps() const { return sample_steps_; }
    bool at_sample() const { return step_ % sample_steps_ == 0; }
    double sample_interval() const { return static_cast<double>(sample_steps_) * time_step_; }
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

    /// Crossing edges at the end of a run; the guard stops it.
    void look_for_crossings();

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
    enum class Round { quiet, again, ended };
    Round look_round(Budget& budget);
    Finding look_at_soundness(Look& look) const;
    Finding look_at_necks(Look& look) const;
    Finding look_at_obstacles(Look& look) const;
    Finding look_at_touches(Look& look) const;
    Finding look_at_films(Look& look) const;
    void take_out(int id, Guard guard, double value);
    void break_up(const Finding& found);
    Guard refuses_cut(const Droplet& parent, const double (&areas)[2], double& value) const;
    std::vector<Droplet> daughters_of(const Droplet& parent, Vec2 velocity,
                                      std::pair<Shape, Shape> halves,
                                      const double (&areas)[2]) const;
    void hand_films_down(const BreakupEvent& event, const std::vector<Film>& films);
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
    pairs_.clear();
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

}  // namespace pinchoff

#include "blocks.hpp"
#include "breakup.hpp"
#include "coalescence.hpp"
#include "events.hpp"
#include "mending.hpp"
#include "seeking.hpp"
