// One droplet: its vertices in the kernels' layout, and its constants.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "model.hpp"
#include "neighbours.hpp"
#include "polygon.hpp"
#include "step.hpp"

namespace pinchoff {

/// Regular polygon with the area of a circle: its edge is l_eq [paper, section 3.5].
inline double rest_length(double area, int count) {
    return std::sqrt(4.0 * area * std::tan(kPi / count) / count);
}

/// What was measured on one droplet. A look at the chords of its outline holds for a while: until
/// its vertices have moved, relative to their drift, by what it left.
struct DropletLook {
    Survey survey{};
    NeckScan neck{std::numeric_limits<double>::infinity(), 0,
                  std::numeric_limits<double>::infinity()};
    bool scanned = false;  // whether `neck` is of this instant
    double neck_room =
        -1.0;             // how far the vertices may still move before a neck can be thin enough
    double thinnest = 0;  // no chord across is shorter
    double relative = 0, drift = 0;  // path over the last block: relative to the drift, and its own
};

/// The number of a droplet that has none yet.
inline constexpr int kNoNumber = -1;

/// Owns the arrays that its `ring` points to.
class Droplet {
public:
    int id = kNoNumber;
    int generation = 0;
    Ring ring;
    double lag = 0;              // how far its velocities are behind its positions, in time
    std::vector<int> contacted;  // obstacles that it, or a droplet it came from, has met
    std::uint64_t key = 0;       // of its random numbers: the same whatever its number
    double widest = 0;           // how thick its bridge has been, D0
    int meetings = 0;            // contacts with other droplets that have begun
    int bridge = 0;  // the bridge of a merge that has not opened yet is between vertex 0 and this

    Box kept{0, 0, 0, 0};             // a box that held it when its neighbours were last sought
    bool sought = false;              // whether they were
    std::vector<ObstacleImage> near;  // obstacles near that box
    DropletLook seen;                 // from one island to the next

    int place = -1;  // where it stood when its window began
    double travel = std::numeric_limits<double>::infinity();   // way that its island reckons with
    double travelled = 0;                                      // bound on its way since it began
    double mended = -std::numeric_limits<double>::infinity();  // when it was last re-spaced

    /// A droplet of area A_eq `rest_area` at positions and velocities (count), counter-clockwise.
    ///
    /// `reference` is the undeformed droplet of the model, of unit diameter. Line tension, edge
    /// springs and viscosity belong to the liquids and stay. The two numerical penalties are scaled
    /// so that a small droplet is as incompressible under its Laplace pressure as the large one
    /// (k_a ∝ D⁻³) and its vertices bounce off the wall at the same frequency (ε_w ∝ m l_eq²).
    Droplet(const Model& model, double rest_area, std::span<const Vec2> r,
            std::span<const Vec2> v) {
        const int count = static_cast<int>(r.size());
        allocate(count);
        const double reference_count = model.vertex_count;
        const double reference_length =
            pinchoff::rest_length(kReferenceArea, static_cast<int>(reference_count));
        ring.constants = model;
        ring.mass = rest_area / kReferenceArea;
        ring.diameter = std::sqrt(ring.mass);
        ring.rest_area = rest_area;
        ring.rest_length = pinchoff::rest_length(rest_area, count);
        ring.edge_spring = model.edge_stiffness * count;
        ring.area_stiffness = model.area_stiffness / (ring.mass * ring.diameter);
        const double vertex_mass_ratio = ring.mass * reference_count / count;
        const double length_ratio = ring.rest_length / reference_length;
        ring.wall_stiffness =
            model.wall_stiffness * vertex_mass_ratio * length_ratio * length_ratio;
        ring.drag_rate = model.drag * ring.diameter / ring.mass;
        ring.mobility = count / (model.drag * ring.diameter);
        for (int i = 0; i < count; ++i) {
            ring.x[i] = r[i].x;
            ring.y[i] = r[i].y;
            ring.vx[i] = v[i].x;
            ring.vy[i] = v[i].y;
        }
        wrap(ring, ring.x, ring.y);
        repeat_first(ring, ring.vx, ring.vy);
    }

    bool has_met(int obstacle) const {
        return std::ranges::find(contacted, obstacle) != contacted.end();
    }
    void meet(int obstacle) { contacted.push_back(obstacle); }

    /// Becomes the droplet that another is, whose vertices it has in place of that one's.
    void stand_for(const Droplet& other) {
        id = other.id;
        generation = other.generation;
        contacted = other.contacted;
        key = other.key;
        meetings = other.meetings;
        widest = other.widest;
        mended = other.mended;
    }

    std::vector<Vec2> positions() const { return copy(ring.x, ring.y); }
    std::vector<Vec2> velocities() const { return copy(ring.vx, ring.vy); }

    void set_velocities(std::span<const Vec2> v) {
        for (int i = 0; i < ring.padded; ++i) {
            ring.vx[i] = v[i % ring.count].x;
            ring.vy[i] = v[i % ring.count].y;
        }
    }

    /// Shift it whole.
    void move_by(Vec2 way) {
        for (int i = -1; i <= ring.padded; ++i) {
            ring.x[i] += way.x;
            ring.y[i] += way.y;
        }
    }

    /// Copy of positions and velocities, ghosts included, and the way back.
    void save() { std::copy_n(state_, state_size_, saved_); }
    void restore() { std::copy_n(saved_, state_size_, state_); }

    /// The same for all that changes while an island advances, over more than one block.
    void remember() {
        std::copy_n(state_, state_size_, remembered_);
        memory_ = {true, lag, travelled, mended, contacted.size(), meetings, bridge, widest, seen};
    }
    bool remembered() const { return memory_.held; }
    void recall() {
        std::copy_n(remembered_, state_size_, state_);
        lag = memory_.lag;
        travelled = memory_.travelled;
        mended = memory_.mended;
        contacted.resize(memory_.contacted);
        meetings = memory_.meetings;
        bridge = memory_.bridge;
        widest = memory_.widest;
        seen = memory_.seen;
        sought = false;
    }

private:
    struct Free {
        void operator()(double* p) const { ::operator delete[](p, std::align_val_t{64}); }
    };
    std::unique_ptr<double[], Free> storage_;
    double *state_ = nullptr, *saved_ = nullptr, *remembered_ = nullptr;
    std::size_t state_size_ = 0;
    struct Memory {
        bool held = false;
        double lag = 0, travelled = 0, mended = 0;
        std::size_t contacted = 0;
        int meetings = 0, bridge = 0;
        double widest = 0;
        DropletLook seen;
    } memory_;

    void allocate(int count) {
        ring.count = count;
        ring.padded = (count + kLanes - 1) / kLanes * kLanes;
        const std::size_t stride = ring.padded + 2 * kLanes;  // room for ghosts, aligned to lanes
        state_size_ = 4 * stride;
        double** const arrays[] = {&ring.x,      &ring.y,       &ring.vx,      &ring.vy,
                                   &ring.pull_x, &ring.pull_y,  &ring.push_x,  &ring.push_y,
                                   &ring.path,   &ring.fluid_x, &ring.fluid_y, &ring.mid_x,
                                   &ring.mid_y,  &ring.length,  &ring.slide};
        const std::size_t total = std::size(arrays) * stride + 2 * state_size_;
        storage_.reset(
            static_cast<double*>(::operator new[](total * sizeof(double), std::align_val_t{64})));
        std::fill_n(storage_.get(), total, 0.0);
        double* next = storage_.get();
        state_ = next;
        for (double** a : arrays) {
            *a = next + kLanes;
            next += stride;
        }
        saved_ = next;
        remembered_ = saved_ + state_size_;
    }

    std::vector<Vec2> copy(const double* x, const double* y) const {
        std::vector<Vec2> out(ring.count);
        for (int i = 0; i < ring.count; ++i) out[i] = {x[i], y[i]};
        return out;
    }
};

/// A droplet at the start: a regular polygon at rest.
struct Start {
    double x, y, diameter;
};

/// Where obstacles stand and droplets start.
struct Arrangement {
    std::vector<Obstacle> obstacles;
    std::vector<Start> droplets;
};

/// Unless said otherwise: one droplet upstream of one obstacle at the origin.
inline Arrangement default_arrangement(const Model& model) {
    return {{{0.0, 0.0, model.obstacle_radius}}, {{-model.start_distance, model.offset, 1.0}}};
}

/// Vertices for a droplet of this diameter at the spacing of the reference droplet.
inline int vertex_count(const Model& model, double diameter) {
    return std::max(kLeastVertices, static_cast<int>(std::lround(model.vertex_count * diameter)));
}

/// Outlines are not resolved further than to this many times the vertices of the round droplet.
inline constexpr double kMostDrawnOut = 16.0;

/// Vertices for a droplet of this diameter whose outline is so long, at the spacing of the round
/// one.
inline int vertex_count(const Model& model, double diameter, double perimeter) {
    const int round = vertex_count(model, diameter);
    const double spacing = rest_length(kReferenceArea * (diameter * diameter), round);
    const double longer = std::clamp(perimeter / (round * spacing), 1.0, kMostDrawnOut);
    return static_cast<int>(std::lround(round * longer));
}

/// That polygon; an edge of it, not a vertex, faces the obstacle.
inline Droplet undeformed(const Model& model, const Start& s = {0, 0, 1}) {
    const double area = kReferenceArea * (s.diameter * s.diameter);
    const int count = vertex_count(model, s.diameter);
    const double angle = 2.0 * kPi / count;
    const double radius = 0.5 * rest_length(area, count) / std::sin(0.5 * angle);
    std::vector<Vec2> r(count), v(count, Vec2{0, 0});
    for (int i = 0; i < count; ++i)
        r[i] = {s.x + radius * std::cos((i + 0.5) * angle),
                s.y + radius * std::sin((i + 0.5) * angle)};
    return Droplet(model, area, r, v);
}

}  // namespace pinchoff
