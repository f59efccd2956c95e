// Who is near whom: boxes, obstacles in a grid, droplets in a hash grid, and images where space
// repeats itself.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "math.hpp"
#include "types.hpp"

namespace pinchoff {

/// Distance between two boxes, zero where they overlap.
inline double gap(const Box& a, const Box& b) {
    const double x = std::max({0.0, a.left - b.right, b.left - a.right});
    const double y = std::max({0.0, a.bottom - b.top, b.bottom - a.top});
    return std::hypot(x, y);
}

inline Box box_of(Vec2 r) { return {r.x, r.x, r.y, r.y}; }

inline Box grown(const Box& b, double by) {
    return {b.left - by, b.right + by, b.bottom - by, b.top + by};
}

inline Box shifted(const Box& b, Vec2 by) {
    return {b.left + by.x, b.right + by.x, b.bottom + by.y, b.top + by.y};
}

/// How far the sides of `outer` are beyond those of `inner`, at the nearest place.
inline double room_in(const Box& outer, const Box& inner) {
    return std::min({inner.left - outer.left, outer.right - inner.right,
                     inner.bottom - outer.bottom, outer.top - inner.top});
}

/// Lengths after which space repeats itself along x and y, D0; zero where it does not.
struct Period {
    double x = 0, y = 0;

    bool any() const { return x > 0.0 || y > 0.0; }
};

/// The whole numbers of periods by which something at `place` has to be shifted to come within half
/// a period of `target`, and one more on either side; [0, 0] where space does not repeat.
inline std::pair<int, int> image_range(double target, double place, double period) {
    if (!(period > 0.0)) return {0, 0};
    const int nearest = static_cast<int>(std::lround((target - place) / period));
    return {nearest - 1, nearest + 1};
}

/// Calls use(shift) for every image of box b, shifted by whole periods, that overlaps box a.
template <class Use>
void for_overlapping_images(const Box& a, const Box& b, Period period, const Use& use) {
    const auto [first_x, last_x] =
        image_range(0.5 * (a.left + a.right), 0.5 * (b.left + b.right), period.x);
    const auto [first_y, last_y] =
        image_range(0.5 * (a.bottom + a.top), 0.5 * (b.bottom + b.top), period.y);
    for (int j = first_y; j <= last_y; ++j)
        for (int i = first_x; i <= last_x; ++i) {
            const Vec2 shift{i * period.x, j * period.y};
            const Box image = shifted(b, shift);
            if (image.left <= a.right && a.left <= image.right && image.bottom <= a.top &&
                a.bottom <= image.top)
                use(shift);
        }
}

/// An obstacle, seen whole periods away from where it stands.
struct ObstacleImage {
    int index;
    Vec2 shift;
};

/// Obstacles sorted into the cells of a regular grid.
class ObstacleGrid {
public:
    ObstacleGrid(std::vector<Obstacle> obstacles, Period period)
        : obstacles_(std::move(obstacles)), period_(period) {
        Box all{0, 0, 0, 0};
        for (std::size_t i = 0; i < obstacles_.size(); ++i) {
            const Obstacle& o = obstacles_[i];
            if (i == 0) all = box_of({o.x, o.y});
            all = {std::min(all.left, o.x), std::max(all.right, o.x), std::min(all.bottom, o.y),
                   std::max(all.top, o.y)};
            largest_ = std::max(largest_, o.radius);
        }
        const double width = period.x > 0.0 ? period.x : all.right - all.left;
        const double height = period.y > 0.0 ? period.y : all.top - all.bottom;
        const auto count = static_cast<double>(std::max<std::size_t>(obstacles_.size(), 1));
        const double side = std::sqrt(std::max(width, 1e-9) * std::max(height, 1e-9) / count);
        left_ = all.left;
        bottom_ = all.bottom;
        columns_ = cells(width, side);
        rows_ = cells(height, side);
        cell_x_ = width > 0.0 ? width / static_cast<double>(columns_) : 1.0;
        cell_y_ = height > 0.0 ? height / static_cast<double>(rows_) : 1.0;
        sort_into_cells();
    }

    const std::vector<Obstacle>& obstacles() const { return obstacles_; }

    Obstacle seen(const ObstacleImage& image) const {
        const Obstacle& o = obstacles_[image.index];
        return {o.x + image.shift.x, o.y + image.shift.y, o.radius};
    }

    /// Every image of an obstacle whose surface is within `reach` of a box, by number.
    void find(const Box& box, double reach, std::vector<ObstacleImage>& out) const {
        out.clear();
        const Box wide = grown(box, reach + largest_);
        const auto [first_x, last_x] =
            range(wide.left - left_, wide.right - left_, cell_x_, columns_, period_.x > 0.0);
        const auto [first_y, last_y] =
            range(wide.bottom - bottom_, wide.top - bottom_, cell_y_, rows_, period_.y > 0.0);
        for (std::int64_t j = first_y; j <= last_y; ++j)
            for (std::int64_t i = first_x; i <= last_x; ++i) {
                const std::int64_t turns_x = floor_divide(i, columns_),
                                   turns_y = floor_divide(j, rows_);
                const std::size_t cell =
                    (j - turns_y * rows_) * columns_ + (i - turns_x * columns_);
                for (int k = starts_[cell]; k < starts_[cell + 1]; ++k) {
                    const ObstacleImage image{members_[k].index,
                                              members_[k].shift + way_of(turns_x, turns_y)};
                    const Obstacle o = seen(image);
                    if (gap(box_of({o.x, o.y}), box) <= o.radius + reach) out.push_back(image);
                }
            }
        std::ranges::sort(out, [](const ObstacleImage& a, const ObstacleImage& b) {
            if (a.index != b.index) return a.index < b.index;
            return a.shift.x != b.shift.x ? a.shift.x < b.shift.x : a.shift.y < b.shift.y;
        });
    }

private:
    std::vector<Obstacle> obstacles_;
    Period period_;
    double largest_ = 0, left_ = 0, bottom_ = 0, cell_x_ = 1, cell_y_ = 1;
    std::int64_t columns_ = 1, rows_ = 1;
    std::vector<int> starts_;
    std::vector<ObstacleImage> members_;  // shifted into the grid where space repeats

    static std::int64_t cells(double length, double side) {
        return std::clamp<std::int64_t>(static_cast<std::int64_t>(length / side), 1, 4096);
    }

    static std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
        return a >= 0 ? a / b : -((b - 1 - a) / b);
    }

    /// So many periods.
    Vec2 way_of(std::int64_t turns_x, std::int64_t turns_y) const {
        return {static_cast<double>(turns_x) * period_.x, static_cast<double>(turns_y) * period_.y};
    }

    /// Cells from one place to another; past the ends the last ones, or, where space repeats, on.
    static std::pair<std::int64_t, std::int64_t> range(double from, double to, double side,
                                                       std::int64_t count, bool periodic) {
        const auto cell = [side](double place) {
            constexpr double kMost = 1e9;
            return static_cast<std::int64_t>(std::floor(std::clamp(place / side, -kMost, kMost)));
        };
        const std::int64_t first = cell(from), last = cell(to);
        if (periodic) return {first, last};
        return {std::clamp<std::int64_t>(first, 0, count - 1),
                std::clamp<std::int64_t>(last, 0, count - 1)};
    }

    void sort_into_cells() {
        std::vector<std::pair<std::int64_t, ObstacleImage>> placed;
        for (int index = 0; index < static_cast<int>(obstacles_.size()); ++index) {
            const Obstacle& o = obstacles_[index];
            std::int64_t i =
                range(o.x - left_, o.x - left_, cell_x_, columns_, period_.x > 0).first;
            std::int64_t j =
                range(o.y - bottom_, o.y - bottom_, cell_y_, rows_, period_.y > 0).first;
            const std::int64_t turns_x = floor_divide(i, columns_),
                               turns_y = floor_divide(j, rows_);
            i -= turns_x * columns_;
            j -= turns_y * rows_;
            placed.push_back({j * columns_ + i, {index, way_of(-turns_x, -turns_y)}});
        }
        std::ranges::stable_sort(placed, {}, [](const auto& p) { return p.first; });
        starts_.assign(columns_ * rows_ + 1, 0);
        for (const auto& [cell, image] : placed) {
            ++starts_[cell + 1];
            members_.push_back(image);
        }
        for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
    }
};

/// Two droplets whose boxes overlap: the second one's image is shifted by `image`.
struct DropletPair {
    int first, second;
    Vec2 image;
};

/// Finds all pairs of boxes that overlap, in either order, and every box with itself; by number.
class PairFinder {
public:
    void find(std::span<const Box> boxes, Period period, std::vector<DropletPair>& out) {
        out.clear();
        const int count = static_cast<int>(boxes.size());
        candidates_.clear();
        if (count <= kFew) {
            for (int i = 0; i < count; ++i)
                for (int j = i; j < count; ++j) candidates_.push_back({i, j});
        } else {
            share_cells(boxes, period);
        }
        for (const auto& [i, j] : candidates_)
            for_overlapping_images(boxes[i], boxes[j], period, [&](Vec2 shift) {
                const bool itself = i == j && shift.x == 0.0 && shift.y == 0.0;
                out.push_back({i, j, shift});
                if (i != j && !itself) out.push_back({j, i, {0.0 - shift.x, 0.0 - shift.y}});
            });
        std::ranges::sort(out, [](const DropletPair& a, const DropletPair& b) {
            if (a.first != b.first) return a.first < b.first;
            if (a.second != b.second) return a.second < b.second;
            return a.image.x != b.image.x ? a.image.x < b.image.x : a.image.y < b.image.y;
        });
    }

private:
    /// Up to so many, looking at all pairs is faster.
    static constexpr int kFew = 12;

    std::vector<std::pair<int, int>> candidates_;
    std::vector<std::pair<std::uint64_t, int>> entries_;

    static std::uint64_t key(std::int64_t i, std::int64_t j) {
        return static_cast<std::uint64_t>(i) << 32 ^ (static_cast<std::uint64_t>(j) & 0xffffffffu);
    }

    static std::int64_t wrapped(std::int64_t i, std::int64_t count) {
        if (count == 0) return i;
        const std::int64_t rest = i % count;
        return rest < 0 ? rest + count : rest;
    }

    /// Candidates: boxes that share a cell of a grid with cells about as large as the boxes.
    void share_cells(std::span<const Box> boxes, Period period) {
        double side = 0;
        for (const Box& b : boxes) side += std::max(b.right - b.left, b.top - b.bottom);
        side = std::max(side / static_cast<double>(boxes.size()), 1e-9);
        const auto columns = static_cast<std::int64_t>(period.x / side),
                   rows = static_cast<std::int64_t>(period.y / side);
        const double cell_x = columns > 0 ? period.x / static_cast<double>(columns) : side;
        const double cell_y = rows > 0 ? period.y / static_cast<double>(rows) : side;
        const std::int64_t turn_x = period.x > 0.0 ? std::max<std::int64_t>(columns, 1) : 0;
        const std::int64_t turn_y = period.y > 0.0 ? std::max<std::int64_t>(rows, 1) : 0;
        const auto cell = [](double at, double size) {
            return static_cast<std::int64_t>(std::floor(at / size));
        };
        const auto last = [](std::int64_t first, std::int64_t to, std::int64_t turn) {
            return turn > 0 ? std::min(to, first + turn - 1) : to;
        };
        entries_.clear();
        for (int k = 0; k < static_cast<int>(boxes.size()); ++k) {
            const Box& b = boxes[k];
            const std::int64_t left = cell(b.left, cell_x), bottom = cell(b.bottom, cell_y);
            for (std::int64_t j = bottom; j <= last(bottom, cell(b.top, cell_y), turn_y); ++j)
                for (std::int64_t i = left; i <= last(left, cell(b.right, cell_x), turn_x); ++i)
                    entries_.push_back({key(wrapped(i, turn_x), wrapped(j, turn_y)), k});
            candidates_.push_back({k, k});
        }
        std::ranges::sort(entries_);
        for (std::size_t i = 0; i < entries_.size(); ++i)
            for (std::size_t j = i + 1;
                 j < entries_.size() && entries_[j].first == entries_[i].first; ++j)
                candidates_.push_back({entries_[i].second, entries_[j].second});
        std::ranges::sort(candidates_);
        const auto repeated = std::ranges::unique(candidates_);
        candidates_.erase(repeated.begin(), repeated.end());
    }
};

}  // namespace pinchoff
