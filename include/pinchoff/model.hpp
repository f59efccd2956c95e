// The numbers that define a collision and those that come out of it, each as one flat row of
// doubles, so that a sweep is a table in and a table out.
#pragma once

#include <cmath>
#include <limits>

#include "math.hpp"

namespace pinchoff {

/// Area of the undeformed droplet, that of a circle of unit diameter.
inline constexpr double kReferenceArea = 0.25 * kPi;

/// Every input, in units D0 = v_f∞ = M = 1.
#define PINCHOFF_MODEL_FIELDS(FIELD)    \
    FIELD(obstacle_radius)              \
    FIELD(drag)                         \
    FIELD(line_tension)                 \
    FIELD(edge_stiffness)               \
    FIELD(area_stiffness)               \
    FIELD(wall_stiffness)               \
    FIELD(offset)                       \
    FIELD(start_distance)               \
    FIELD(vertex_count)                 \
    FIELD(time_step)                    \
    FIELD(time_limit)                   \
    FIELD(neck_thickness)               \
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

#define PINCHOFF_GUARDS(GUARD) \
    GUARD(penetration)         \
    GUARD(overlap)             \
    GUARD(self_intersection)   \
    GUARD(area)                \
    GUARD(blow_up)             \
    GUARD(flow_domain)

#define PINCHOFF_ENTRY(name) name,
enum class Guard { none, PINCHOFF_GUARDS(PINCHOFF_ENTRY) };
#undef PINCHOFF_ENTRY

/// What one guard saw when it stopped a run.
struct Alarm {
    Guard guard = Guard::none;
    double value = 0, time = 0;
};

/// Fraction of its radius by which a vertex or an edge may enter an obstacle.
inline constexpr double kPenetrationLimit = 0.25;
/// Fraction by which an area may differ from A_eq.
inline constexpr double kAreaLimit = 0.01;
/// Coordinates beyond this, in D0, mean that the run has blown up.
inline constexpr double kReachLimit = 1e4;
/// A droplet has left an obstacle behind when all of it is this far, in D0, beyond its rear.
inline constexpr double kDepartureDistance = 0.5;
/// Front tracking: an outline this near to an obstacle, in D0, has touched it.
inline constexpr double kFrontTouch = 1e-9;
/// Samples between two searches for crossing edges.
inline constexpr int kCrossingSamples = 10;
/// Least vertices of a droplet.
inline constexpr int kLeastVertices = 16;

/// Regular polygon with the area of a circle: its edge is l_eq [paper, section 3.5].
inline double rest_length(double area, int count) {
    return std::sqrt(4.0 * area * std::tan(kPi / count) / count);
}

}  // namespace pinchoff
