// A droplet that a guard refuses, where the run goes on without it. Included by island.hpp, which
// declares these functions.
#pragma once

namespace pinchoff {

/// A droplet re-spaced less than this long ago, t0, is not re-spaced again.
inline constexpr double kMendingInterval = 1.0;
/// Loops with less than this share of a droplet's area are no more than a thread drawn too thin.
inline constexpr double kSmallLoop = 0.02;

/// Takes a droplet out; it is kept where the clock may be set back.
inline void Island::remove(int index) {
    if (droplets_[index].remembered()) gone_.push_back(std::move(droplets_[index]));
    droplets_.erase(droplets_.begin() + index);
    look_.droplets.erase(look_.droplets.begin() + index);
    boxes_.clear();
    pairs_.clear();
}

/// A droplet that a guard refuses is re-spaced at its proper area, without the loops in which it
/// crosses itself, or, where that does not serve or has just been tried, taken out.
inline void Island::mend(const Finding& found) {
    Droplet& d = droplets_[found.droplet];
    const Shape whole = untangled({d.positions(), d.velocities()});
    const std::vector<Vec2>& r = whole.r;
    const bool respaceable = found.guard == Guard::area || found.guard == Guard::self_intersection;
    // What small loops have been taken off may be mended again, but not at the same instant.
    const bool small = found.guard == Guard::self_intersection &&
                       signed_area(r) > (1.0 - kSmallLoop) * d.ring.rest_area;
    const bool retired = !respaceable || !(time() - d.mended > (small ? 0.0 : kMendingInterval)) ||
                         !(signed_area(r) > 0.5 * d.ring.rest_area);
    refusals_.push_back(
        {time(), d.id, found.guard, found.value, d.ring.rest_area, centroid(r), retired});
    if (retired) {
        end_films(d.id);
        return remove(found.droplet);
    }
    Shape even = respace(whole, d.ring.count);
    scale_to_area(even, d.ring.rest_area);
    Droplet mended = heir(d, Droplet(world_->model, d.ring.rest_area, even.r, even.v));
    mended.stand_for(d);
    mended.mended = time();
    remove(found.droplet);
    add(std::move(mended));
    renew_steps();
}

}  // namespace pinchoff
