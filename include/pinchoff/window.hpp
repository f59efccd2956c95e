// One window of time for many droplets, in islands.
//
// At the start of a window, droplets that could meet before its end are put into one island: boxes,
// grown by a bound on the way that each may go, that overlap. Islands know nothing of each other,
// so they run in any order and on any thread, with a time step of their own. Where a droplet went
// further than its bound the islands that it could have met are undone and run again as one. What
// an island is follows from the state alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "grouping.hpp"
#include "island.hpp"

namespace pinchoff {

class Window {
public:
    explicit Window(const World& world) : world_(&world) {}

    /// Runs droplets, in the order of their numbers, from a time to the next sample. They are moved
    /// into the results. for_each(count, job) runs job(worker, i) for every i below count, on any
    /// thread; a worker runs one job at a time and has a number below `workers`.
    template <class ForEach>
    void run(std::vector<Droplet>& droplets, std::span<const Film> films, double time, int workers,
             const ForEach& for_each) {
        while (static_cast<int>(islands_.size()) < workers) islands_.emplace_back(*world_);
        undone_ = 0;
        reckon_ways(droplets, for_each);
        find_links(droplets, films);
        group({}, droplets);
        run_groups(droplets, films, time, for_each);
        while (enlarge_ways()) {
            const std::vector<std::vector<int>> before = grouping_.groups();
            group(before, droplets);
            run_groups(droplets, films, time, for_each);
        }
    }

    /// What became of the groups, in the order of their first droplets; for the taking.
    std::vector<IslandResult>& results() { return results_; }

    /// How many islands were undone.
    int undone() const { return undone_; }

private:
    const World* world_;
    std::vector<Island> islands_;          // one a worker, empty between windows
    std::vector<Box> boxes_, wide_boxes_;  // at the start of the window, and grown by the ways
    std::vector<double> ways_;
    std::vector<std::pair<int, int>> links_;  // places of the droplets of each film
    std::vector<std::vector<int>> group_films_;
    Grouping grouping_;
    std::vector<IslandResult> results_;
    int undone_ = 0;

    /// The bound on a droplet's way in a window: this times the way of its fastest vertex, and
    /// what a vertex of this speed goes, v_f∞.
    static constexpr double kWayFactor = 1.5, kWaySpeed = 0.5;

    /// A bound on the way that each droplet goes in a window: more than its fastest vertex's.
    template <class ForEach>
    void reckon_ways(std::vector<Droplet>& droplets, const ForEach& for_each) {
        boxes_.resize(droplets.size());
        ways_.resize(droplets.size());
        for_each(droplets.size(), [&](int, std::size_t i) {
            Droplet& d = droplets[i];
            world_->kernels.survey(d.ring, d.seen.survey);
            const Survey& seen = d.seen.survey;
            // One that has blown up is refused at once, alone.
            const bool sound = !blown_up(d.ring, seen) && std::isfinite(seen.speed);
            boxes_[i] = sound ? grown(seen.box, 0.5 * d.ring.rest_length) : Box{0, 0, 0, 0};
            ways_[i] =
                sound ? (kWayFactor * seen.speed + kWaySpeed) * world_->model.sample_interval : 0.0;
            d.travelled = 0;
            d.sought = false;  // so that what is known of neighbours is no part of the state
            d.place = static_cast<int>(i);
            d.remember();
        });
    }

    void find_links(std::span<const Droplet> droplets, std::span<const Film> films) {
        const auto place_of = [&](int id) {
            return static_cast<int>(std::ranges::lower_bound(droplets, id, {}, &Droplet::id) -
                                    droplets.begin());
        };
        links_.clear();
        for (const Film& f : films) links_.push_back({place_of(f.first), place_of(f.second)});
    }

    /// Puts droplets that may meet into one group. `before`: the groups that have been run; those
    /// that stay as they are and went as far as they might need not run again.
    void group(const std::vector<std::vector<int>>& before, std::vector<Droplet>& droplets) {
        wide_boxes_.resize(boxes_.size());
        for (std::size_t i = 0; i < boxes_.size(); ++i) wide_boxes_[i] = grown(boxes_[i], ways_[i]);
        grouping_.find(wide_boxes_, world_->period, links_, world_->exhaustive);
        const std::vector<std::vector<int>>& groups = grouping_.groups();
        group_films_.assign(groups.size(), {});
        for (int k = 0; k < static_cast<int>(links_.size()); ++k)
            group_films_[grouping_.group_of(links_[k].first)].push_back(k);
        std::vector<IslandResult> results(groups.size());
        for (std::size_t g = 0; g < before.size(); ++g) {
            const int now = grouping_.group_of(before[g].front());
            if (results_[g].done && groups[now] == before[g]) results[now] = std::move(results_[g]);
            else undo(results_[g], droplets);
        }
        results_ = std::move(results);
    }

    template <class ForEach>
    void run_groups(std::vector<Droplet>& droplets, std::span<const Film> films, double time,
                    const ForEach& for_each) {
        for_each(results_.size(), [&](int worker, std::size_t g) {
            if (!results_[g].done) run_island(islands_[worker], g, droplets, films, time);
        });
    }

    void run_island(Island& island, std::size_t g, std::vector<Droplet>& droplets,
                    std::span<const Film> films, double time) {
        island.clear();
        for (const int i : grouping_.groups()[g]) {
            droplets[i].travel = ways_[i];
            island.add(std::move(droplets[i]));
        }
        for (const int k : group_films_[g]) island.add(films[k]);
        island.begin(time);
        while (!island.strayed() && island.step() < island.sample_steps() &&
               !island.droplets().empty()) {
            const Budget budget = island.settle();
            if (!island.droplets().empty()) island.run_block(budget);
        }
        island.hand_over(results_[g]);
    }

    /// Doubles the bounds of the groups in which a droplet went further; whether there were any.
    bool enlarge_ways() {
        const int before = undone_;
        for (std::size_t g = 0; g < results_.size(); ++g) {
            if (results_[g].done) continue;
            ++undone_;
            for (const int i : grouping_.groups()[g]) ways_[i] *= 2.0;
        }
        return undone_ > before;
    }

    /// Puts the droplets of a group back to where they were when the window began.
    static void undo(IslandResult& result, std::vector<Droplet>& droplets) {
        for (std::vector<Droplet>* part : {&result.droplets, &result.gone})
            for (Droplet& d : *part)
                if (d.remembered()) {
                    d.recall();
                    droplets[d.place] = std::move(d);
                }
    }
};

}  // namespace pinchoff
