// What has happened in a run of many droplets, kept as events and summed in the balance.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "island.hpp"
#include "records.hpp"

namespace pinchoff {

/// Droplets are named by the numbers that they have for good.
class Ledger {
public:
    Balance balance;

    /// The events since this was last asked.
    std::vector<EmulsionEvent> take_events() { return std::exchange(events_, {}); }

    void note(const ContactEvent& c, int droplet) {
        EmulsionEvent& e = add(EventKind::contact, c.time, droplet, c.centroid, c.area);
        e.obstacle = c.obstacle;
        e.symmetry = c.symmetry;
        e.impact_parameter = c.impact_parameter;
        e.speed = c.speed;
        e.shape_parameter = c.shape_parameter;
        balance.contacts += 1;
    }

    void note(const BreakupEvent& b, int droplet, int daughter_1, int daughter_2) {
        EmulsionEvent& e = add(EventKind::breakup, b.time, droplet, 0.5 * (b.ends[0] + b.ends[1]),
                               b.areas[0] + b.areas[1]);
        e.daughter_1 = daughter_1;
        e.daughter_2 = daughter_2;
        e.area_1 = b.areas[0];
        e.area_2 = b.areas[1];
        e.neck_thickness = b.neck_thickness;
        balance.breakups += 1;
    }

    void note(const RefusalEvent& r, int droplet) {
        EmulsionEvent& e = add(r.retired ? EventKind::retired : EventKind::respaced, r.time,
                               droplet, r.centroid, r.area);
        e.guard = static_cast<double>(r.guard);
        e.guard_value = r.value;
        if (r.retired) {
            balance.retired += 1;
            balance.area_retired += r.area;
        } else {
            balance.respaced += 1;
        }
    }

    /// `film`: with final numbers, the lower one first; `swapped`: whether that is the other order
    /// than in the event; `into`: final too.
    void note(const FilmEvent& f, const Film& film, bool swapped, int into) {
        constexpr EventKind kKinds[] = {EventKind::touched, EventKind::parted, EventKind::merge,
                                        EventKind::unmerged};
        const bool merged = f.stage == FilmStage::merged;
        const double area = merged ? f.areas[0] + f.areas[1] : f.areas[swapped];
        EmulsionEvent& e = add(kKinds[static_cast<int>(f.stage)], f.time, film, f.place, area);
        e.area_1 = f.areas[swapped];
        e.area_2 = f.areas[!swapped];
        if (merged) e.into = into;
        if (f.stage == FilmStage::unmerged) {
            e.guard = static_cast<double>(f.guard);
            e.guard_value = f.value;
        }
        balance.touches += f.stage == FilmStage::touched;
        balance.merges += merged;
        balance.unmerged += f.stage == FilmStage::unmerged;
    }

    /// A contact that ends because one of its droplets has left.
    void note_parted(double time, const Film& film, Vec2 place, double area) {
        add(EventKind::parted, time, film, place, area);
    }

    void note_left(double time, int droplet, Vec2 place, double area) {
        add(EventKind::left, time, droplet, place, area);
        balance.left += 1;
        balance.area_left += area;
    }

    void note_entered(double time, int droplet, Vec2 place, double area, double waited) {
        add(EventKind::entered, time, droplet, place, area).waited = waited;
        balance.entered += 1;
    }

private:
    std::vector<EmulsionEvent> events_;

    EmulsionEvent& add(EventKind kind, double time, int droplet, Vec2 place, double area) {
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

    EmulsionEvent& add(EventKind kind, double time, const Film& film, Vec2 place, double area) {
        EmulsionEvent& e = add(kind, time, film.first, place, area);
        e.partner = film.second;
        e.facing_length = film.longest;
        e.clock = film.clock;
        e.since = film.since;
        return e;
    }
};

}  // namespace pinchoff
