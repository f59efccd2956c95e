// The plain data that crosses from the collision to the compiled kernels.
//
// No type here has member functions: the kernels are compiled several times, once for each
// instruction set, and a function shared between those objects could be linked from the wrong one.
#pragma once

#include <cstdint>

#include "model.hpp"

namespace pinchoff {

/// Arrays are padded to a multiple of this, the widest register of any instruction set.
inline constexpr int kLanes = 8;

/// Vertices fewer edges apart than this never count as the two sides of a thin part.
inline constexpr int kApart = 5;

/// One circular obstacle: centre and radius, in D0.
struct Obstacle {
    double x, y, radius;
};

enum class FlowKind : std::int32_t { stokes, uniform, sampled, brinkman };

/// The undisturbed fluid velocity as a function of position, in units of v_f∞ and D0.
struct Flow {
    FlowKind kind = FlowKind::stokes;
    double x = 0, y = 0, radius = 0;              // stokes, brinkman: the cylinder
    double vx = 0, vy = 0;                        // uniform: the velocity; the others: vx is v_f∞
    double x0 = 0, y0 = 0;                        // sampled: position of the first node
    double dx = 1, dy = 1;                        // sampled: node spacing
    int nx = 0, ny = 0;                           // sampled: nodes along x, y; brinkman: cells
    bool periodic_x = false, periodic_y = false;  // sampled: whether nodes nx, ny are the first
    const double* nodes = nullptr;  // sampled: see padded_nodes in flow.hpp; brinkman: see there
};

/// One droplet as the kernels see it: structure of arrays with ghost vertices at both ends.
///
/// Each array holds `padded` entries (a multiple of kLanes) of which the first `count` are the
/// vertices in counter-clockwise order. Entry -1 repeats the last vertex and the entries from
/// `count` to `padded` repeat the first ones, so that no loop wraps or branches.
struct Ring {
    int count = 0, padded = 0;
    double* x = nullptr;  // (padded) position, D0
    double* y = nullptr;
    double* vx = nullptr;  // (padded) velocity half a step behind the position, v_f∞
    double* vy = nullptr;
    double* pull_x = nullptr;  // (padded) tension of edge i, which joins vertices i and i + 1
    double* pull_y = nullptr;
    double* push_x = nullptr;  // (padded) contact force on vertex i; zero where there is none
    double* push_y = nullptr;
    double* path = nullptr;     // (padded) sum of |v - v_drift|² over the steps of a block
    double* fluid_x = nullptr;  // (padded) velocity of a sampled flow at the vertices
    double* fluid_y = nullptr;
    double* mid_x = nullptr;  // (padded) front tracking: position in the middle of a step
    double* mid_y = nullptr;
    double* length = nullptr;  // (padded) front tracking: length of edge i
    double* slide = nullptr;   // (padded) front tracking: motion of vertex i along the outline

    Model constants{};                // what does not change with the droplet's size
    double mass = 1;                  // M
    double diameter = 1;              // D0 of this droplet
    double rest_area = 0;             // A_eq
    double rest_length = 0;           // l_eq
    double edge_spring = 0;           // k_l N_v
    double area_stiffness = 0;        // k_a
    double wall_stiffness = 0;        // ε_w
    double drag_rate = 0;             // μ D0 / M, the rate at which drag alone stops the droplet
    double mobility = 0;              // N_v / (μ D0), drift speed of a vertex per unit force
    double kept = 0, replaced = 1;    // of a velocity by drag in one step, see Relaxation
    double drift_x = 0, drift_y = 0;  // reference velocity of `path`
    double shift = 0;                 // time for shift_velocities, which may be negative
    int parts = 1;                    // front tracking: steps of this ring in a step of the scene

    int first_wall = 0, last_wall = 0;  // which of the scene's walls are near it
    bool pushed = false;                // whether push_x, push_y take part in this block
};

/// Vertices [first, last) of one droplet that may feel one obstacle, or an image of it that is
/// periods away; both are multiples of kLanes.
struct WallContact {
    int ring, first, last;
    Obstacle obstacle;
    bool met = true;  // front tracking lists a wall before the droplet touches it
};

/// A vertex of one droplet that may touch a run of consecutive edges of another, or of its own: of
/// the other's image that is shifted by (image_x, image_y).
struct DropletContact {
    int ring, vertex, other, first_edge, edge_count;
    double image_x = 0, image_y = 0;
};

/// What a block of steps acts on.
struct Scene {
    Ring* rings = nullptr;
    int ring_count = 0;
    Flow flow;
    const WallContact* walls = nullptr;
    int wall_count = 0;
    const DropletContact* touches = nullptr;
    int touch_count = 0;
};

/// What one look over the chords of an outline gives (neck.hpp).
struct NeckScan {
    double
        thickness2;   // square of the thinnest admissible chord; infinite where none is admissible
    double budget;    // vertex displacement below which no admissible chord can pass `threshold`
    double nearest2;  // square of the shortest chord between vertices kApart or more edges apart
};

/// A rectangle along the axes.
struct Box {
    double left, right, bottom, top;
};

/// What one look over the vertices of a droplet gives.
struct Survey {
    double area;  // signed
    double perimeter;
    double speed;           // largest |v_i|
    double relative_speed;  // largest |v_i - v_drift|
    double reach;  // root of the sum of squared coordinates; not finite when one of them is not
    Box box;
};

/// Room that a look at the neck needs.
constexpr int neck_work_size(int count) { return 5 * (2 * count + 2 * kLanes); }

/// The arc that the two sides of an admissible chord must both exceed: fraction·P + length.
struct Separation {
    double fraction;  // of the current perimeter
    double length;    // D0
};

/// The compiled loops for one instruction set.
struct Kernels {
    const char* name;
    /// Advance every ring by `steps` leapfrog steps of `time_step`, adding to `path`.
    void (*advance)(const Scene&, double time_step, int steps);
    /// Carry the velocities alone, of each ring over its `shift`.
    void (*shift_velocities)(const Scene&);
    /// Front tracking: outlines put out of walls and each other, with their areas.
    void (*settle_fronts)(const Scene&);
    /// Front tracking: steps, and the velocities of the present positions.
    void (*advance_fronts)(const Scene&, double time_step, int steps);
    void (*front_velocities)(const Scene&, double time_step);
    void (*survey)(const Ring&, Survey&);
    /// Smallest squared distance of each chunk's vertices from a point: out (padded / kLanes).
    void (*chunk_distance2)(const Ring&, double x, double y, double* out);
    /// Smallest squared distance of a point from the edges of the ring.
    double (*edge_distance2)(const Ring&, double x, double y);
    /// Whether a point is inside the ring.
    bool (*contains)(const Ring&, double x, double y);
    /// x, y: (count + 1); work: room for neck_work_size(count) numbers.
    NeckScan (*scan_neck)(const double* x, const double* y, int count, Separation separation,
                          double threshold, double* work);
    bool (*self_intersects)(const double* x, const double* y, int count);
    void (*flow_velocity)(const Flow&, const double* x, const double* y, double* u, double* v,
                          int count);
    void (*natural_log)(const double* in, double* out, int count);
};

}  // namespace pinchoff
