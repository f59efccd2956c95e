// Many droplets among many obstacles, with a cost that grows like their number.
//
// Time goes on in windows. In each, islands of droplets run apart from each other (window.hpp);
// then their droplets and events are taken over in the order of droplets' numbers, some leave and
// some come in. No bit of any outline depends on the number of threads.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "inlet.hpp"
#include "ledger.hpp"
#include "state.hpp"
#include "window.hpp"

namespace pinchoff {

struct EmulsionSettings {
    Box cell{0, 0, 0, 0};  // droplets are brought back into it along the axes that are periodic
    Inlet inlet;
    double outlet = std::numeric_limits<double>::infinity();  // droplets beyond this x have left
    std::uint64_t seed = 0;
    bool stops_at_guard = false;  // whether the first droplet that is taken out ends the run
};

class Emulsion {
public:
    Emulsion(World world, const EmulsionSettings& settings, const std::vector<Start>& starts)
        : world_(std::move(world)), cell_(settings.cell), outlet_(settings.outlet),
          stops_at_guard_(settings.stops_at_guard), inflow_(settings.inlet, settings.seed),
          window_(world_) {
        for (const Start& s : starts) admit(undeformed(world_.model, s));
        ledger_.balance.start = static_cast<double>(starts.size());
    }

    Emulsion(const Emulsion&) = delete;

    double time() const { return balance().windows * world_.model.sample_interval; }
    const std::vector<Droplet>& droplets() const { return droplets_; }
    const Balance& balance() const { return ledger_.balance; }
    bool stopped() const { return stops_at_guard_ && balance().retired > 0; }

    /// The events since this was last asked.
    std::vector<EmulsionEvent> take_events() { return ledger_.take_events(); }

    /// One window; `workers` and `for_each` as for Window::run.
    template <class ForEach>
    void advance(int workers, const ForEach& for_each) {
        if (world_.fronts())
            for_each(droplets_.size(), [&](int, std::size_t i) { follow_perimeter(droplets_[i]); });
        window_.run(droplets_, films_, time(), workers, for_each);
        take_over();
        ledger_.balance.windows += 1;
        let_out();
        bring_back();
        let_in();
    }

    /// Everything that a run goes on from, as numbers, and the way back.
    std::vector<double> state() const;
    void restore(std::span<const double> state);

private:
    World world_;
    Box cell_;
    double outlet_;
    bool stops_at_guard_;
    Inflow inflow_;
    Window window_;
    Ledger ledger_;
    std::int64_t next_id_ = 0;
    std::vector<Droplet> droplets_;  // in the order of their numbers
    std::vector<Film> films_;        // of droplets that touch, likewise

    void admit(Droplet droplet) {
        droplet.id = static_cast<int>(next_id_++);
        droplet.key = mixed(static_cast<std::uint64_t>(droplet.id));
        ledger_.balance.area_in += droplet.ring.rest_area;
        droplets_.push_back(std::move(droplet));
    }

    void follow_perimeter(Droplet& d) const;
    void take_over();
    void take_films(const IslandResult& result, const auto& final_id);
    void drop_moved(const std::vector<char>& stays);
    void let_out();
    void bring_back();
    void let_in();
    void let_one_in(const Start& start);
};

/// Spaces a droplet anew that has been drawn out, or has drawn itself together again.
inline void Emulsion::follow_perimeter(Droplet& d) const {
    const std::vector<Vec2> r = d.positions();
    const int wanted = vertex_count(world_.model, d.ring.diameter, perimeter(r));
    if (wanted < kDrawnOut * d.ring.count && kDrawnIn * wanted > d.ring.count) return;
    const Shape even = respace({r, d.velocities()}, wanted);
    Droplet anew(world_.model, d.ring.rest_area, even.r, even.v);
    anew.stand_for(d);
    anew.bridge = static_cast<int>(std::int64_t{d.bridge} * wanted / d.ring.count);
    d = std::move(anew);
}

/// Takes over what became of the islands: droplets that stay, then those that are new, with numbers
/// in the order of the islands, which is that of their first droplets.
inline void Emulsion::take_over() {
    std::vector<Droplet> heirs;
    films_.clear();
    std::vector<char> stays(droplets_.size(), 0);
    Balance& balance = ledger_.balance;
    for (IslandResult& result : window_.results()) {
        // Numbers given within an island count down from -2, in the order in which they were given.
        const auto final_id = [&](int id) {
            return id >= 0 ? id : static_cast<int>(next_id_) - 2 - id;
        };
        for (const ContactEvent& c : result.contacts) ledger_.note(c, final_id(c.droplet));
        for (const BreakupEvent& b : result.breakups)
            ledger_.note(b, final_id(b.droplet), final_id(b.daughters[0]),
                         final_id(b.daughters[1]));
        for (const RefusalEvent& r : result.refusals) ledger_.note(r, final_id(r.droplet));
        take_films(result, final_id);
        for (Droplet& d : result.droplets) {
            const int place = d.place;
            if (d.id >= 0 && !stays[place]) {
                stays[place] = 1;
                droplets_[place] = std::move(d);
            } else {
                d.id = final_id(d.id);
                heirs.push_back(std::move(d));
            }
        }
        next_id_ += result.ids_given;
        balance.steps += static_cast<double>(result.steps);
        balance.vertex_updates += static_cast<double>(result.vertex_updates);
    }
    balance.islands += static_cast<double>(window_.results().size());
    balance.undone += window_.undone();
    drop_moved(stays);
    std::ranges::sort(films_, earlier);
    std::ranges::sort(heirs, {}, &Droplet::id);
    std::ranges::move(heirs, std::back_inserter(droplets_));
}

/// What happened to the contacts of one island, and those that go on.
inline void Emulsion::take_films(const IslandResult& result, const auto& final_id) {
    const auto renumbered = [&](Film film) {
        const int one = final_id(film.first), other = final_id(film.second);
        film.first = std::min(one, other);
        film.second = std::max(one, other);
        return film;
    };
    for (const Film& film : result.films) films_.push_back(renumbered(film));
    for (const FilmEvent& f : result.film_events) {
        const Film film = renumbered(f.film);
        ledger_.note(f, film, film.first != final_id(f.film.first), final_id(f.into));
    }
}

/// Drops the droplets that are no more where they stood, in the order of the others.
inline void Emulsion::drop_moved(const std::vector<char>& stays) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < stays.size(); ++i) {
        if (!stays[i]) continue;
        if (kept != i) droplets_[kept] = std::move(droplets_[i]);
        ++kept;
    }
    droplets_.erase(droplets_.begin() + static_cast<std::ptrdiff_t>(kept), droplets_.end());
}

/// Droplets that are wholly beyond the outlet leave.
inline void Emulsion::let_out() {
    std::erase_if(droplets_, [&](const Droplet& d) {
        const double left = *std::min_element(d.ring.x, d.ring.x + d.ring.count);
        if (!(left > outlet_)) return false;
        const Vec2 place = centroid(d.positions());
        std::erase_if(films_, [&](const Film& film) {
            if (film.first != d.id && film.second != d.id) return false;
            if (!film.cut) ledger_.note_parted(time(), film, place, d.ring.rest_area);
            return true;
        });
        ledger_.note_left(time(), d.id, place, d.ring.rest_area);
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
        const double i = turns(mean(d.ring.x, d.ring.count), cell_.left, period.x);
        const double j = turns(mean(d.ring.y, d.ring.count), cell_.bottom, period.y);
        if (i == 0.0 && j == 0.0) continue;
        d.move_by({-i * period.x, -j * period.y});
    }
}

/// Droplets come in as the fluid brings them; one that finds no room waits, and the next with it.
inline void Emulsion::let_in() {
    const double window = world_.model.sample_interval;
    inflow_.flow_for(world_, window);
    while (inflow_.due()) {
        const std::optional<Start> place = inflow_.find_place(world_, droplets_);
        if (!place) {
            if (inflow_.waited == 0.0) ledger_.balance.waits += 1;
            inflow_.waited += window;
            return;
        }
        let_one_in(*place);
    }
}

/// A round droplet that moves with the fluid.
inline void Emulsion::let_one_in(const Start& start) {
    Droplet d = undeformed(world_.model, start);
    world_.kernels.flow_velocity(world_.flow, d.ring.x, d.ring.y, d.ring.vx, d.ring.vy,
                                 d.ring.padded);
    const double area = d.ring.rest_area;
    ledger_.note_entered(time(), static_cast<int>(next_id_), {start.x, start.y}, area,
                         inflow_.waited);
    admit(std::move(d));
    inflow_.take(area);
}

inline std::vector<double> Emulsion::state() const {
    StateWriter state;
    state.put(balance());
    state.put(next_id_);
    state.put(inflow_);
    state.put(films_.size(), droplets_.size());
    for (const Film& f : films_) state.put(f);
    for (const Droplet& d : droplets_) state.put(d);
    return std::move(state.numbers);
}

inline void Emulsion::restore(std::span<const double> state) {
    StateReader from(state);
    Balance balance;
    Inflow inflow = inflow_;
    from.read(balance);
    const std::int64_t next_id = from.whole();
    from.read(inflow);
    std::vector<Film> films(from.count());
    const std::size_t count = from.count();
    for (Film& f : films) from.read(f);
    std::vector<Droplet> droplets;
    for (std::size_t k = 0; k < count; ++k) droplets.push_back(from.droplet(world_.model));
    if (std::ranges::adjacent_find(droplets, std::ranges::greater_equal{}, &Droplet::id) !=
        droplets.end())
        throw std::invalid_argument("a state whose droplets are out of order");
    for (const Film& f : films)
        for (const int id : {f.first, f.second})
            if (!std::ranges::binary_search(droplets, id, {}, &Droplet::id))
                throw std::invalid_argument("a state whose films have no droplets");
    ledger_.balance = balance;
    next_id_ = next_id;
    inflow_ = std::move(inflow);
    films_ = std::move(films);
    droplets_ = std::move(droplets);
}

}  // namespace pinchoff
