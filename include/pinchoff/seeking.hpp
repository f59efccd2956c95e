// Who is near whom. Included by island.hpp, which declares these functions.
#pragma once

namespace pinchoff {

/// How much wider than a droplet the box is that it is kept in while its neighbours are known, D0.
inline constexpr double kKeptMargin = 0.25;
/// Up to so many bodies in all, comparing all of them is faster than knowing the neighbours.
inline constexpr int kFewBodies = 8;
/// The box of a droplet that is compared with everybody, D0; and the margin where space repeats.
inline constexpr double kEverywhere = 1e9;
inline constexpr double kExhaustiveMargin = 4.0;

/// Extents and speeds of every droplet, the drift that the coming paths are taken relative to, and
/// who is near whom.
inline void Island::survey() {
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        Ring& ring = droplets_[i].ring;
        ring.drift_x = mean(ring.vx, ring.count);
        ring.drift_y = mean(ring.vy, ring.count);
        world_->kernels.survey(ring, look_.droplets[i].survey);
        look_.droplets[i].scanned = false;
    }
    seek_neighbours();
}

inline bool Island::looks_at_all() const {
    const std::size_t bodies = world_->obstacles.obstacles().size() + droplets_.size();
    return world_->exhaustive || (bodies <= kFewBodies && !world_->period.any());
}

/// Keeps the lists of neighbours complete: sought anew for a droplet that comes near the side of
/// the box that it is kept in.
inline void Island::seek_neighbours() {
    look_.neighbour_room = std::numeric_limits<double>::infinity();
    bool changed = boxes_.size() != droplets_.size();
    boxes_.resize(droplets_.size());
    for (std::size_t i = 0; i < droplets_.size(); ++i) {
        Droplet& d = droplets_[i];
        const Survey& seen = look_.droplets[i].survey;
        // One that is refused at once is not compared with anybody; its box may hold all others.
        const bool refused = blown_up(d.ring, seen) || out_of_area(d.ring, seen);
        const Box box = refused ? Box{0, 0, 0, 0} : seen.box;
        if (!d.sought || !(room_in(d.kept, box) > 0.25 * kKeptMargin)) seek_obstacles(d, box);
        changed = changed || d.kept.left != boxes_[i].left || d.kept.top != boxes_[i].top ||
                  d.kept.right != boxes_[i].right || d.kept.bottom != boxes_[i].bottom;
        boxes_[i] = d.kept;
        look_.neighbour_room = std::min(look_.neighbour_room, room_in(d.kept, box));
    }
    if (changed) finder_.find(boxes_, world_->period, pairs_);
}

/// Draws a new box round a droplet and finds the obstacles near it.
inline void Island::seek_obstacles(Droplet& d, const Box& box) const {
    d.sought = true;
    const ObstacleGrid& grid = world_->obstacles;
    if (!looks_at_all() || world_->period.any()) {
        d.kept = grown(box, world_->exhaustive ? kExhaustiveMargin : kKeptMargin);
        return grid.find(d.kept, longest_wall_range(d.ring), d.near);
    }
    d.kept = {-kEverywhere, kEverywhere, -kEverywhere, kEverywhere};
    d.near.clear();
    for (int o = 0; o < static_cast<int>(grid.obstacles().size()); ++o)
        d.near.push_back({o, {0, 0}});
}

}  // namespace pinchoff
