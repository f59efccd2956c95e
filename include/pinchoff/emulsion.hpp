// Many droplets among many obstacles, with a cost that grows like their number.
//
// Time goes on in windows. At the start of each, droplets that could meet before its end are put
// into one island: boxes, grown by a bound on the way that each may go, that overlap. Islands know
// nothing of each other, so they run in any order and on any thread, with a time step of their own.
// Where a droplet went further than its bound the islands that it could have met are undone and run
// again as one. What an island is follows from the state alone and results are taken over in the
// order of droplets' numbers: no bit of any outline depends on the number of threads.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "island.hpp"

namespace pinchoff {

/// Where droplets come in: centres on the line x between two y, such that they take up a fraction
/// of the area that flows in; their diameters are drawn from a list. No droplet comes in where
/// `fraction` is zero.
struct Inlet {
    double x = 0, bottom = 0, top = 0, fraction = 0;
    std::vector<double> diameters;
};

struct EmulsionSettings {
    Box cell{0, 0, 0, 0};  // droplets are brought back into it along the axes that are periodic
    Inlet inlet;
    double outlet = std::numeric_limits<double>::infinity();  // droplets beyond this x have left
    std::uint64_t seed = 0;
    bool stops_at_guard = false;  // whether the first droplet that is taken out ends the run
};

#define PINCHOFF_EVENT_KINDS(KIND) \
    KIND(contact)                  \
    KIND(breakup)                  \
    KIND(entered)                  \
    KIND(left)                     \
    KIND(touched)                  \
    KIND(parted)                   \
    KIND(merge)                    \
    KIND(unmerged)                 \
    KIND(respaced)                 \
    KIND(retired)
#define PINCHOFF_ENTRY(name) name,
enum class EventKind { PINCHOFF_EVENT_KINDS(PINCHOFF_ENTRY) };
#undef PINCHOFF_ENTRY

/// One event of any kind; not a number where a field has no meaning.
#define PINCHOFF_EVENT_FIELDS(FIELD) \
    FIELD(kind)                      \
    FIELD(time)                      \
    FIELD(droplet_id)                \
    FIELD(x)                         \
    FIELD(y)                         \
    FIELD(area)                      \
    FIELD(obstacle)                  \
    FIELD(symmetry)                  \
    FIELD(impact_parameter)          \
    FIELD(speed)                     \
    FIELD(shape_parameter)           \
    FIELD(daughter_1)                \
    FIELD(daughter_2)                \
    FIELD(area_1)                    \
    FIELD(area_2)                    \
    FIELD(neck_thickness)            \
    FIELD(partner)                   \
    FIELD(into)                      \
    FIELD(facing_length)             \
    FIELD(clock)                     \
    FIELD(since)                     \
    FIELD(waited)                    \
    FIELD(guard)                     \
    FIELD(guard_value)
#define PINCHOFF_DECLARE(name) double name = std::numeric_limits<double>::quiet_NaN();
struct EmulsionEvent {
    PINCHOFF_EVENT_FIELDS(PINCHOFF_DECLARE)
};
#undef PINCHOFF_DECLARE
inline constexpr int kEventFields = sizeof(EmulsionEvent) / sizeof(double);

/// What has happened so far, in numbers: start + entered + breakups - merges - left - retired are
/// present.
#define PINCHOFF_BALANCE_FIELDS(FIELD) \
    FIELD(start)                       \
    FIELD(entered)                     \
    FIELD(breakups)                    \
    FIELD(merges)                      \
    FIELD(unmerged)                    \
    FIELD(touches)                     \
    FIELD(left)                        \
    FIELD(retired)                     \
    FIELD(respaced)                    \
    FIELD(contacts)                    \
    FIELD(waits)                       \
    FIELD(area_in)                     \
    FIELD(area_left)                   \
    FIELD(area_retired)                \
    FIELD(steps)                       \
    FIELD(vertex_updates)              \
    FIELD(windows)                     \
    FIELD(islands)                     \
    FIELD(undone)
#define PINCHOFF_DECLARE(name) double name = 0;
struct Balance {
    PINCHOFF_BALANCE_FIELDS(PINCHOFF_DECLARE)
};
#undef PINCHOFF_DECLARE
inline constexpr int kBalanceFields = sizeof(Balance) / sizeof(double);

/// Random numbers that are the same everywhere and whose state is one number (SplitMix64).
class Random {
public:
    explicit Random(std::uint64_t seed) : state(seed) {}

    double uniform() {
        state += 0x9e3779b97f4a7c15ULL;
        std::uint64_t z = state;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
        return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }

    std::uint64_t state;
};

class Emulsion {
public:
    Emulsion(World world, EmulsionSettings settings, const std::vector<Start>& starts)
        : world_(std::move(world)), settings_(std::move(settings)), random_(settings_.seed) {
        for (const Start& s : starts) admit(undeformed(world_.model, s));
        balance_.start = static_cast<double>(starts.size());
        draw_next();
    }

    Emulsion(const Emulsion&) = delete;

    double time() const { return balance_.windows * world_.sample_interval; }
    double window() const { return world_.sample_interval; }
    const std::vector<Droplet>& droplets() const { return droplets_; }
    const Balance& balance() const { return balance_; }
    const World& world() const { return world_; }
    bool stopped() const { return settings_.stops_at_guard && balance_.retired > 0; }

    /// The events since this was last asked.
    std::vector<EmulsionEvent> take_events() { return std::exchange(events_, {}); }

    /// One window. for_each(count, job) runs job(worker, i) for every i below count, on any thread;
    /// a worker runs one job at a time and has a number below `workers`.
    template <class ForEach>
    void advance(int workers, const ForEach& for_each) {
        while (static_cast<int>(islands_.size()) < workers) islands_.emplace_back(world_);
        if (world_.fronts())
            for_each(droplets_.size(), [&](int, std::size_t i) { follow_perimeter(droplets_[i]); });
        reckon_ways(for_each);
        group({});
        run(for_each);
        while (enlarge_ways()) {
            group(std::exchange(groups_, {}));
            run(for_each);
        }
        take_over();
        balance_.windows += 1;
        let_out();
        bring_back();
        let_in();
    }

    /// Everything that a run goes on from, as numbers, and the way back.
    std::vector<double> state() const;
    void restore(std::span<const double> state);

private:
    /// What became of one group of droplets in a window.
    struct Result {
        bool done = false;
        std::vector<Droplet> droplets, gone;
        std::vector<ContactEvent> contacts;
        std::vector<BreakupEvent> breakups;
        std::vector<RefusalEvent> refusals;
        std::vector<Film> films;
        std::vector<FilmEvent> film_events;
        std::int64_t steps = 0, vertex_updates = 0;
        int ids_given = 0;
    };

    World world_;
    EmulsionSettings settings_;
    Random random_;
    Balance balance_;
    std::int64_t next_id_ = 0;
    double credit_ = 0;              // area that has flowed in and not come as droplets
    double next_diameter_ = 0;       // of the droplet that comes in next
    double waited_ = 0;              // for how long it has found no room
    std::vector<Droplet> droplets_;  // in the order of their numbers
    std::vector<Film> films_;        // of droplets that touch, likewise
    std::vector<std::pair<int, int>> film_places_;  // where their droplets stand
    std::vector<std::vector<int>> group_films_;
    std::vector<Island> islands_;  // one a worker, empty between windows
    std::vector<EmulsionEvent> events_;
    std::vector<Box> boxes_, wide_boxes_;  // at the start of the window, and grown by the ways
    std::vector<double> ways_;
    std::vector<int> place_;
    std::vector<DropletPair> pairs_;
    PairFinder finder_;
    std::vector<int> parent_;  // of the union of groups
    std::vector<std::vector<int>> groups_;
    std::vector<Result> results_;

    void admit(Droplet droplet) {
        droplet.id = static_cast<int>(next_id_++);
        droplet.key = mixed(static_cast<std::uint64_t>(droplet.id));
        balance_.area_in += droplet.ring.rest_area;
        droplets_.push_back(std::move(droplet));
    }

    /// Spaces a droplet anew that has been drawn out, or has drawn itself together again.
    void follow_perimeter(Droplet& d) const {
        const std::vector<Vec2> r = d.positions();
        const int wanted = vertex_count(world_.model, d.ring.diameter, perimeter(r));
        if (wanted < kDrawnOut * d.ring.count && kDrawnIn * wanted > d.ring.count) return;
        const Shape even = respace({r, d.velocities()}, wanted);
        Droplet anew(world_.model, d.ring.rest_area, even.r, even.v);
        anew.id = d.id;
        anew.generation = d.generation;
        anew.contacted = std::move(d.contacted);
        anew.key = d.key;
        anew.widest = d.widest;
        anew.meetings = d.meetings;
        anew.bridge = static_cast<int>(std::int64_t{d.bridge} * wanted / d.ring.count);
        anew.mended = d.mended;
        d = std::move(anew);
    }

    // ---------------------------------------------------------------- islands

    /// A bound on the way that each droplet goes in a window: more than its fastest vertex's.
    template <class ForEach>
    void reckon_ways(const ForEach& for_each) {
        boxes_.resize(droplets_.size());
        ways_.resize(droplets_.size());
        for_each(droplets_.size(), [&](int, std::size_t i) {
            Droplet& d = droplets_[i];
            world_.kernels.survey(d.ring, d.seen.survey);
            const Survey& seen = d.seen.survey;
            // One that has blown up is refused at once, alone; its box would mean nothing.
            const bool sound = seen.reach < limit_of(Guard::blow_up) * std::sqrt(d.ring.padded) &&
                               std::isfinite(seen.speed);
            boxes_[i] = sound ? grown(seen.box, 0.5 * d.ring.rest_length) : Box{0, 0, 0, 0};
            ways_[i] = sound ? (kWayFactor * seen.speed + kWaySpeed) * window() : 0.0;
            d.travelled = 0;
            d.sought = false;  // so that what is known of neighbours is no part of the state
            d.place = static_cast<int>(i);
            d.remember();
        });
        film_places_.clear();
        for (const Film& f : films_)
            film_places_.push_back({place_of(f.first), place_of(f.second)});
    }

    /// Where the droplet of a number stands.
    int place_of(int id) const {
        const auto at = std::ranges::lower_bound(droplets_, id, {}, &Droplet::id);
        return static_cast<int>(at - droplets_.begin());
    }

    int root(int i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }

    void join(int i, int j) {
        i = root(i);
        j = root(j);
        parent_[std::max(i, j)] = std::min(i, j);
    }

    /// Puts droplets that may meet into one group. `before`: the groups that have been run; those
    /// that stay as they are and went as far as they might need not run again.
    void group(const std::vector<std::vector<int>>& before) {
        wide_boxes_.resize(boxes_.size());
        for (std::size_t i = 0; i < boxes_.size(); ++i) wide_boxes_[i] = grown(boxes_[i], ways_[i]);
        finder_.find(wide_boxes_, world_.period, pairs_);
        parent_.resize(boxes_.size());
        std::iota(parent_.begin(), parent_.end(), 0);
        for (const DropletPair& p : pairs_) join(p.first, p.second);
        for (const auto& [one, other] : film_places_) join(one, other);
        for (std::size_t i = 1; i < boxes_.size() && world_.exhaustive; ++i)
            join(0, static_cast<int>(i));
        place_.assign(boxes_.size(), -1);
        groups_.clear();
        for (int i = 0; i < static_cast<int>(boxes_.size()); ++i) {
            int& place = place_[root(i)];
            if (place < 0) {
                place = static_cast<int>(groups_.size());
                groups_.emplace_back();
            }
            groups_[place].push_back(i);
        }
        group_films_.assign(groups_.size(), {});
        for (int k = 0; k < static_cast<int>(films_.size()); ++k)
            group_films_[place_[root(film_places_[k].first)]].push_back(k);
        std::vector<Result> results(groups_.size());
        for (std::size_t g = 0; g < before.size(); ++g) {
            const int place = place_[root(before[g].front())];
            if (results_[g].done && groups_[place] == before[g])
                results[place] = std::move(results_[g]);
            else undo(results_[g]);
        }
        results_ = std::move(results);
    }

    template <class ForEach>
    void run(const ForEach& for_each) {
        for_each(groups_.size(), [&](int worker, std::size_t g) {
            if (!results_[g].done) run_island(islands_[worker], g);
        });
    }

    void run_island(Island& island, std::size_t g) {
        Result& result = results_[g];
        island.clear();
        for (const int i : groups_[g]) {
            droplets_[i].travel = ways_[i];
            island.add(std::move(droplets_[i]));
        }
        for (const int k : group_films_[g]) island.films_.push_back(films_[k]);
        island.begin(time());
        while (!island.strayed() && island.step() < island.sample_steps() &&
               !island.droplets_.empty()) {
            const Budget budget = island.settle();
            if (!island.droplets_.empty()) island.run_block(budget);
        }
        result.done = !island.strayed();
        for (std::size_t i = 0; i < island.droplets_.size(); ++i)
            island.droplets_[i].seen = island.look_.droplets[i];
        result.droplets.swap(island.droplets_);
        result.gone.swap(island.gone_);
        result.contacts.swap(island.contacts_);
        result.breakups.swap(island.breakups_);
        result.refusals.swap(island.refusals_);
        result.films.swap(island.films_);
        result.film_events.swap(island.film_events_);
        result.steps = island.steps_taken();
        result.vertex_updates = island.vertex_updates();
        result.ids_given = island.ids_given();
    }

    /// Doubles the bounds of the groups in which a droplet went further; whether there were any.
    bool enlarge_ways() {
        bool any = false;
        for (std::size_t g = 0; g < groups_.size(); ++g) {
            if (results_[g].done) continue;
            any = true;
            balance_.undone += 1;
            for (const int i : groups_[g]) ways_[i] *= 2.0;
        }
        return any;
    }

    /// Puts the droplets of a group back to where they were when the window began.
    void undo(Result& result) {
        for (std::vector<Droplet>* part : {&result.droplets, &result.gone})
            for (Droplet& d : *part)
                if (d.remembered()) {
                    d.recall();
                    droplets_[d.place] = std::move(d);
                }
    }

    void take_over();
    template <class Global>
    void note(const Result& result, const Global& global);
    template <class Global>
    void note_films(const Result& result, const Global& global);
    EmulsionEvent& record_film(EventKind kind, double time, const Film& film, Vec2 place,
                               double area);
    EmulsionEvent& record(EventKind kind, double time, int droplet, Vec2 place, double area);
    void let_out();
    void bring_back();
    void let_in();
    void let_one_in(const Start& start);
    bool has_room(double x, double y, double diameter) const;
    void draw_next() {
        const std::vector<double>& diameters = settings_.inlet.diameters;
        if (diameters.empty()) return;
        const double at = random_.uniform() * static_cast<double>(diameters.size());
        next_diameter_ = diameters[std::min(static_cast<std::size_t>(at), diameters.size() - 1)];
    }

    /// The bound on a droplet's way in a window: this times the way of its fastest vertex, and
    /// what a vertex of this speed goes, v_f∞.
    static constexpr double kWayFactor = 1.5, kWaySpeed = 0.5;
    /// Least gap between a droplet that comes in and all others, D0.
    static constexpr double kInletGap = 0.05;
    /// Places that are tried in a window for the droplet that comes in next.
    static constexpr int kInletTries = 8;
};

/// Takes over what became of the groups: those that stay, then those that are new, with numbers in
/// the order of the groups, which is that of their first droplets.
inline void Emulsion::take_over() {
    std::vector<Droplet> heirs;
    films_.clear();
    std::vector<char> there(boxes_.size(), 0);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        Result& result = results_[g];
        // Numbers given within an island count down from -2, in the order in which they were given.
        const auto global = [&](int id) {
            return id >= 0 ? id : static_cast<int>(next_id_) - 2 - id;
        };
        note(result, global);
        note_films(result, global);
        for (Droplet& d : result.droplets) {
            if (d.id >= 0 && !there[d.place]) {
                there[d.place] = 1;
                const int place = d.place;
                droplets_[place] = std::move(d);
            } else {
                d.id = global(d.id);
                heirs.push_back(std::move(d));
            }
        }
        next_id_ += result.ids_given;
        balance_.steps += static_cast<double>(result.steps);
        balance_.vertex_updates += static_cast<double>(result.vertex_updates);
    }
    balance_.islands += static_cast<double>(groups_.size());
    std::size_t kept = 0;
    for (std::size_t i = 0; i < there.size(); ++i)
        if (there[i]) {
            if (kept != i) droplets_[kept] = std::move(droplets_[i]);
            ++kept;
        }
    droplets_.erase(droplets_.begin() + static_cast<std::ptrdiff_t>(kept), droplets_.end());
    std::ranges::sort(films_, earlier);
    std::ranges::sort(heirs, {}, &Droplet::id);
    std::ranges::move(heirs, std::back_inserter(droplets_));
}

/// The events of one group, with the droplets' numbers as they are from now on.
template <class Global>
void Emulsion::note(const Result& result, const Global& global) {
    for (const ContactEvent& c : result.contacts) {
        EmulsionEvent& e =
            record(EventKind::contact, c.time, global(c.droplet), c.centroid, c.area);
        e.obstacle = c.obstacle;
        e.symmetry = c.symmetry;
        e.impact_parameter = c.impact_parameter;
        e.speed = c.speed;
        e.shape_parameter = c.shape_parameter;
        balance_.contacts += 1;
    }
    for (const BreakupEvent& b : result.breakups) {
        EmulsionEvent& e = record(EventKind::breakup, b.time, global(b.droplet),
                                  0.5 * (b.ends[0] + b.ends[1]), b.areas[0] + b.areas[1]);
        e.daughter_1 = global(b.daughters[0]);
        e.daughter_2 = global(b.daughters[1]);
        e.area_1 = b.areas[0];
        e.area_2 = b.areas[1];
        e.neck_thickness = b.neck_thickness;
        balance_.breakups += 1;
    }
    for (const RefusalEvent& r : result.refusals) {
        EmulsionEvent& e = record(r.retired ? EventKind::retired : EventKind::respaced, r.time,
                                  global(r.droplet), r.centroid, r.area);
        e.guard = static_cast<double>(r.guard);
        e.guard_value = r.value;
        if (r.retired) {
            balance_.retired += 1;
            balance_.area_retired += r.area;
        } else {
            balance_.respaced += 1;
        }
    }
}

/// What happened to the contacts of one group, and those that go on.
template <class Global>
void Emulsion::note_films(const Result& result, const Global& global) {
    const auto renumbered = [&](Film film) {
        const int one = global(film.first), other = global(film.second);
        film.first = std::min(one, other);
        film.second = std::max(one, other);
        return film;
    };
    for (const Film& film : result.films) films_.push_back(renumbered(film));
    for (const FilmEvent& f : result.film_events) {
        constexpr EventKind kKinds[] = {EventKind::touched, EventKind::parted, EventKind::merge,
                                        EventKind::unmerged};
        const bool merged = f.stage == FilmStage::merged;
        const Film film = renumbered(f.film);
        EmulsionEvent& e = record_film(kKinds[static_cast<int>(f.stage)], f.time, film, f.place,
                                       f.areas[0] + (merged ? f.areas[1] : 0.0));
        const bool swapped = film.first != global(f.film.first);
        e.area_1 = f.areas[swapped];
        e.area_2 = f.areas[!swapped];
        if (!merged) e.area = e.area_1;
        if (merged) e.into = global(f.into);
        if (f.stage == FilmStage::unmerged) {
            e.guard = static_cast<double>(f.guard);
            e.guard_value = f.value;
        }
        balance_.touches += f.stage == FilmStage::touched;
        balance_.merges += merged;
        balance_.unmerged += f.stage == FilmStage::unmerged;
    }
}

inline EmulsionEvent& Emulsion::record_film(EventKind kind, double time, const Film& film,
                                            Vec2 place, double area) {
    EmulsionEvent& e = record(kind, time, film.first, place, area);
    e.partner = film.second;
    e.facing_length = film.longest;
    e.clock = film.clock;
    e.since = film.since;
    return e;
}

inline EmulsionEvent& Emulsion::record(EventKind kind, double time, int droplet, Vec2 place,
                                       double area) {
    EmulsionEvent event;
    event.kind = static_cast<double>(kind);
    event.time = time;
    event.droplet_id = droplet;
    event.x = place.x;
    event.y = place.y;
    event.area = area;
    events_.push_back(event);
    return events_.back();
}

/// Droplets that are wholly beyond the outlet leave.
inline void Emulsion::let_out() {
    std::erase_if(droplets_, [&](const Droplet& d) {
        const double left = *std::min_element(d.ring.x, d.ring.x + d.ring.count);
        if (!(left > settings_.outlet)) return false;
        const Vec2 place = centroid(d.positions());
        std::erase_if(films_, [&](const Film& film) {
            if (film.first != d.id && film.second != d.id) return false;
            if (!film.cut) record_film(EventKind::parted, time(), film, place, d.ring.rest_area);
            return true;
        });
        record(EventKind::left, time(), d.id, place, d.ring.rest_area);
        balance_.left += 1;
        balance_.area_left += d.ring.rest_area;
        return true;
    });
}

/// Droplets whose centre has left the cell along a periodic axis come in on the other side.
inline void Emulsion::bring_back() {
    const Period period = world_.period;
    if (!period.any()) return;
    const auto turns = [](double at, double from, double length) {
        return length > 0.0 ? std::floor((at - from) / length) : 0.0;
    };
    for (Droplet& d : droplets_) {
        const double i = turns(mean(d.ring.x, d.ring.count), settings_.cell.left, period.x);
        const double j = turns(mean(d.ring.y, d.ring.count), settings_.cell.bottom, period.y);
        if (i == 0.0 && j == 0.0) continue;
        d.move_by({-i * period.x, -j * period.y});
    }
}

/// Whether a disc is clear of all droplets, at a distance.
inline bool Emulsion::has_room(double x, double y, double diameter) const {
    const double clear = 0.5 * diameter + kInletGap;
    const Box disc = grown(box_of({x, y}), clear);
    for (const Droplet& d : droplets_) {
        bool free = true;
        Survey s;
        world_.kernels.survey(d.ring, s);
        for_overlapping_images(disc, s.box, world_.period, [&](Vec2 image) {
            const Vec2 seen = displacement(image, {x, y});
            const double edge = std::sqrt(world_.kernels.edge_distance2(d.ring, seen.x, seen.y));
            free = free && edge > clear && !world_.kernels.contains(d.ring, seen.x, seen.y);
        });
        if (!free) return false;
    }
    return true;
}

/// Droplets come in as the fluid brings them; one that finds no room waits, and the next with it.
inline void Emulsion::let_in() {
    const Inlet& inlet = settings_.inlet;
    if (!(inlet.fraction > 0.0)) return;
    constexpr int kPlaces = 64;
    double x[kPlaces], y[kPlaces], u[kPlaces], v[kPlaces], speed = 0;
    for (int i = 0; i < kPlaces; ++i) {
        x[i] = inlet.x;
        y[i] = inlet.bottom + (i + 0.5) / kPlaces * (inlet.top - inlet.bottom);
    }
    world_.kernels.flow_velocity(world_.flow, x, y, u, v, kPlaces);
    for (const double each : u) speed += std::max(each, 0.0) / kPlaces;
    credit_ += inlet.fraction * (inlet.top - inlet.bottom) * speed * window();
    while (credit_ >= kReferenceArea * next_diameter_ * next_diameter_) {
        const double diameter = next_diameter_;
        const double margin = world_.period.y > 0.0 ? 0.0 : 0.5 * diameter;
        double at = 0;
        bool found = false;
        for (int t = 0; t < kInletTries && !found; ++t) {
            at = inlet.bottom + margin +
                 random_.uniform() * (inlet.top - inlet.bottom - 2.0 * margin);
            found = has_room(inlet.x, at, diameter);
        }
        if (!found) {
            if (waited_ == 0.0) balance_.waits += 1;
            waited_ += window();
            return;
        }
        let_one_in({inlet.x, at, diameter});
    }
}

/// A round droplet that moves with the fluid.
inline void Emulsion::let_one_in(const Start& start) {
    Droplet d = undeformed(world_.model, start);
    world_.kernels.flow_velocity(world_.flow, d.ring.x, d.ring.y, d.ring.vx, d.ring.vy,
                                 d.ring.padded);
    credit_ -= d.ring.rest_area;
    EmulsionEvent& e = record(EventKind::entered, time(), static_cast<int>(next_id_),
                              {start.x, start.y}, d.ring.rest_area);
    e.waited = waited_;
    waited_ = 0;
    balance_.entered += 1;
    admit(std::move(d));
    draw_next();
}

inline std::vector<double> Emulsion::state() const {
    const auto* balance = reinterpret_cast<const double*>(&balance_);
    std::vector<double> out(balance, balance + kBalanceFields);
    for (const double number :
         {static_cast<double>(next_id_), static_cast<double>(random_.state >> 32),
          static_cast<double>(random_.state & 0xffffffffULL), credit_, next_diameter_, waited_,
          static_cast<double>(films_.size()), static_cast<double>(droplets_.size())})
        out.push_back(number);
    for (const Film& f : films_)
        for (const double number : {static_cast<double>(f.first), static_cast<double>(f.second),
                                    f.since, f.harmonic, f.least, f.clock, f.needed, f.length,
                                    f.longest, f.cut ? 1.0 : 0.0, f.refused ? 1.0 : 0.0})
            out.push_back(number);
    for (const Droplet& d : droplets_) {
        const Ring& r = d.ring;
        for (const double number :
             {static_cast<double>(d.id), static_cast<double>(d.generation),
              static_cast<double>(r.count), static_cast<double>(d.contacted.size()), r.rest_area,
              d.lag, d.mended, d.seen.neck_room, d.seen.thinnest, static_cast<double>(d.key >> 32),
              static_cast<double>(d.key & 0xffffffffULL), static_cast<double>(d.meetings),
              static_cast<double>(d.bridge), d.widest})
            out.push_back(number);
        for (const int o : d.contacted) out.push_back(o);
        for (const double* a : {r.x, r.y, r.vx, r.vy}) out.insert(out.end(), a, a + r.count);
    }
    return out;
}

inline void Emulsion::restore(std::span<const double> state) {
    const double *next = state.data(), *end = next + state.size();
    const auto number = [&] {
        if (next == end) throw std::invalid_argument("a state that is cut short");
        return *next++;
    };
    const auto whole = [&] {
        const double n = number();
        if (!(std::abs(n) < 0x1p62)) throw std::invalid_argument("a state without its counts");
        return static_cast<std::int64_t>(n);
    };
    const auto counted = [&](std::int64_t n, std::int64_t least = 0) {  // of what follows
        if (n < least || n > end - next) throw std::invalid_argument("a state without its counts");
        return static_cast<std::size_t>(n);
    };
    auto* balance = reinterpret_cast<double*>(&balance_);
    for (int i = 0; i < kBalanceFields; ++i) balance[i] = number();
    next_id_ = whole();
    const auto halves = [&] {
        const auto upper = static_cast<std::uint64_t>(whole());
        return upper << 32 | static_cast<std::uint64_t>(whole());
    };
    random_.state = halves();
    credit_ = number();
    next_diameter_ = number();
    waited_ = number();
    films_.resize(counted(whole()));
    const std::size_t droplets = counted(whole());
    for (Film& f : films_) {
        f.first = static_cast<int>(whole());
        f.second = static_cast<int>(whole());
        for (double* value :
             {&f.since, &f.harmonic, &f.least, &f.clock, &f.needed, &f.length, &f.longest})
            *value = number();
        f.cut = number() != 0.0;
        f.refused = number() != 0.0;
    }
    droplets_.clear();
    for (std::size_t k = 0; k < droplets; ++k) {
        const int id = static_cast<int>(whole()), generation = static_cast<int>(whole());
        const std::size_t count = counted(whole(), 3), contacted = counted(whole());
        const double rest_area = number(), lag = number(), mended = number();
        const double neck_room = number(), thinnest = number();
        const std::uint64_t key = halves();
        const int meetings = static_cast<int>(whole()), bridge = static_cast<int>(whole());
        const double widest = number();
        std::vector<int> met(contacted);
        for (int& o : met) o = static_cast<int>(whole());
        std::vector<Vec2> r(count), v(count);
        for (Vec2& p : r) p.x = number();
        for (Vec2& p : r) p.y = number();
        for (Vec2& p : v) p.x = number();
        for (Vec2& p : v) p.y = number();
        Droplet d(world_.model, rest_area, r, v);
        d.id = id;
        d.generation = generation;
        d.lag = lag;
        d.mended = mended;
        d.contacted = std::move(met);
        d.key = key;
        d.meetings = meetings;
        d.bridge = bridge;
        d.widest = widest;
        d.seen.neck_room = neck_room;
        d.seen.thinnest = thinnest;
        droplets_.push_back(std::move(d));
    }
    for (const Film& f : films_)
        for (const int id : {f.first, f.second})
            if (std::ranges::find(droplets_, id, &Droplet::id) == droplets_.end())
                throw std::invalid_argument("a state whose films have no droplets");
}

}  // namespace pinchoff
