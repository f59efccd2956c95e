// The numbers that define a collision and those that come out of it, each as one flat row of
// doubles, so that a sweep is a table in and a table out.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>

namespace pinchoff {

/// Area of the undeformed droplet, that of a circle of unit diameter.
inline constexpr double kReferenceArea = 0.25 * std::numbers::pi;

/// Every input, in units D0 = v_f∞ = M = 1.
#define PINCHOFF_MODEL_FIELDS(FIELD)    \
    FIELD(obstacle_radius)              \
    FIELD(drag)                         \
    FIELD(line_tension)                 \
    FIELD(edge_stiffness)               \
    FIELD(area_stiffness)               \
    FIELD(wall_stiffness)               \
    FIELD(adhesion)                     \
    FIELD(offset)                       \
    FIELD(start_distance)               \
    FIELD(vertex_count)                 \
    FIELD(time_step)                    \
    FIELD(time_limit)                   \
    FIELD(neck_thickness)               \
    FIELD(neck_thickness_is_fixed)      \
    FIELD(neck_separation)              \
    FIELD(neck_separation_in_diameters) \
    FIELD(sample_interval)              \
    FIELD(stop_at_breakup)              \
    FIELD(front_tracking)               \
    FIELD(evening_rate)

/// Every output; not a number where the event did not happen.
#define PINCHOFF_RESULT_FIELDS(FIELD) \
    FIELD(outcome)                    \
    FIELD(guard)                      \
    FIELD(guard_value)                \
    FIELD(guard_time)                 \
    FIELD(symmetry)                   \
    FIELD(impact_parameter)           \
    FIELD(contact_time)               \
    FIELD(contact_speed)              \
    FIELD(contact_area)               \
    FIELD(contact_shape_parameter)    \
    FIELD(minimum_neck)               \
    FIELD(maximum_shape_parameter)    \
    FIELD(maximum_perimeter)          \
    FIELD(small_daughter_area)        \
    FIELD(large_daughter_area)        \
    FIELD(breakup_time)               \
    FIELD(breakup_neck)               \
    FIELD(breakup_count)              \
    FIELD(generations)                \
    FIELD(droplet_count)              \
    FIELD(end_time)                   \
    FIELD(steps)                      \
    FIELD(vertex_updates)

#define PINCHOFF_DECLARE(name) double name;
struct Model {
    PINCHOFF_MODEL_FIELDS(PINCHOFF_DECLARE)
};
struct Result {
    PINCHOFF_RESULT_FIELDS(PINCHOFF_DECLARE)
};
#undef PINCHOFF_DECLARE

inline constexpr int kModelFields = sizeof(Model) / sizeof(double);
inline constexpr int kResultFields = sizeof(Result) / sizeof(double);

enum class Outcome { slipped, broke, captured, failed };

/// Every guard, in the order of its number, with the limit that it holds the run to:
/// penetration: fraction of its radius by which a vertex or an edge may enter an obstacle;
/// overlap: depth of one droplet in another, in vertex spacings; self_intersection: crossing edges;
/// area: fraction by which an area may differ from A_eq; blow_up: largest coordinate, D0;
/// flow_domain: way out of the sampled flow, D0; generations: break-ups in one ancestry;
/// daughter_size: least diameter of a daughter, D0; time_step: parts into which the small daughters
/// may divide it.
#define PINCHOFF_GUARDS(GUARD)  \
    GUARD(penetration, 0.25)    \
    GUARD(overlap, 1.0)         \
    GUARD(self_intersection, 0) \
    GUARD(area, 0.01)           \
    GUARD(blow_up, 1e4)         \
    GUARD(flow_domain, 0)       \
    GUARD(generations, 16)      \
    GUARD(daughter_size, 0.02)  \
    GUARD(time_step, 4096)

#define PINCHOFF_ENTRY(name, limit) name,
enum class Guard { none, PINCHOFF_GUARDS(PINCHOFF_ENTRY) };
#undef PINCHOFF_ENTRY

/// The limit of a guard.
constexpr double limit_of(Guard guard) {
#define PINCHOFF_ENTRY(name, limit) limit,
    constexpr double kLimits[] = {0, PINCHOFF_GUARDS(PINCHOFF_ENTRY)};
#undef PINCHOFF_ENTRY
    return kLimits[static_cast<int>(guard)];
}

/// What one guard saw when it stopped a run.
struct Alarm {
    Guard guard = Guard::none;
    double value = 0, time = 0;
};

/// A droplet has left an obstacle behind when all of it is this far, in D0, beyond its rear.
inline constexpr double kDepartureDistance = 0.5;
/// Front tracking: an outline this near to an obstacle, in D0, has touched it.
inline constexpr double kFrontTouch = 1e-9;
/// Samples between two searches for crossing edges.
inline constexpr int kCrossingSamples = 10;
/// The thickness below which the neck of a droplet of some diameter breaks, D0: a part of that
/// diameter, or one length for all, such as the chamber's.
inline double neck_threshold(const Model& m, double diameter) {
    return m.neck_thickness_is_fixed != 0.0 ? m.neck_thickness : m.neck_thickness * diameter;
}

/// Least vertices of a droplet.
inline constexpr int kLeastVertices = 16;

/// What is wrong with the numbers that count steps and vertices, as `<name> must be <rule>`; null
/// where nothing is. The guards see what is wrong with any other number.
inline const char* wrong_clock(const Model& m) {
    if (!(m.time_step > 0.0) || !std::isfinite(m.time_step))
        return "time_step must be positive and finite";
    if (!(m.sample_interval > 0.0) || !(m.sample_interval <= 1e9 * m.time_step))
        return "sample_interval must be positive and at most 1e9 time steps";
    if (!(m.time_limit >= 0.0) || !(m.time_limit <= 1e15 * m.time_step))
        return "time_limit must be from 0 to 1e15 time steps";
    if (!(m.vertex_count >= kLeastVertices) || !(m.vertex_count <= 1e6))
        return "vertex_count must be from 16 to 1e6";
    return nullptr;
}

}  // namespace pinchoff
