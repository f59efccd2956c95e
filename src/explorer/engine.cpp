// The engine for a page: a C interface over one collision at a time.
//
// The row of numbers that goes in and those that come out are the very rows of the Python binding.
// They stand in memory that the page writes to and reads from. A function that can refuse the row
// returns 0, or the place of the field that is wrong, counted from 1.
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "kernels.hpp"
#include "pinchoff/collision.hpp"

#define PINCHOFF_EXPORT(name) extern "C" __attribute__((export_name(#name)))

namespace pinchoff {

extern const Kernels kernels_generic;
const Kernels& best_kernels() { return kernels_generic; }

namespace {

/// More steps than this would take hours.
constexpr double kMostSteps = 1e8;
constexpr int kMostVertices = 1024;

Model row;
Result results;
std::unique_ptr<Collision> collision;
std::vector<double> values;  // what was asked for last

enum Field : int {
#define PINCHOFF_PLACE(name) k_##name,
    PINCHOFF_MODEL_FIELDS(PINCHOFF_PLACE)
#undef PINCHOFF_PLACE
};

constexpr int refused(Field field) { return 1 + static_cast<int>(field); }

Flow flow() {
    Flow stokes;
    stokes.radius = row.obstacle_radius;
    stokes.vx = 1.0;
    return stokes;
}

/// The first field, but for the time step, with which no collision can be set up, or that fits the
/// others ill, as consistency.py says. The ranges of the parameters are the page's to check, from
/// the list that Python gives it.
int fault_but_for_step() {
    const double* numbers = reinterpret_cast<const double*>(&row);
    for (int i = 0; i < kModelFields; ++i)
        if (i != k_time_step && !std::isfinite(numbers[i])) return 1 + i;
    for (const Field field : {k_obstacle_radius, k_drag, k_line_tension, k_time_limit,
                              k_neck_separation, k_sample_interval, k_evening_rate})
        if (!(numbers[field] > 0.0)) return refused(field);
    const bool springs = row.front_tracking == 0.0;  // without, no stiffness means anything
    for (const Field field : {k_edge_stiffness, k_area_stiffness, k_wall_stiffness})
        if (springs && !(numbers[field] > 0.0)) return refused(field);
    if (row.adhesion < 0.0) return refused(k_adhesion);
    const double count = row.vertex_count;
    if (count != std::floor(count) || count < kLeastVertices || count > kMostVertices)
        return refused(k_vertex_count);
    if (!(row.start_distance > row.obstacle_radius + 0.75) ||
        row.start_distance > limit_of(Guard::blow_up))
        return refused(k_start_distance);
    const bool fraction = row.neck_separation_in_diameters == 0.0;
    if (fraction && (row.neck_separation >= 0.5 || row.neck_separation < 3.0 / count))
        return refused(k_neck_separation);
    const double half_angle = row.neck_separation * (fraction ? std::numbers::pi : 1.0);
    if (row.neck_thickness < 0.0 || row.neck_thickness >= std::sin(half_angle))
        return refused(k_neck_thickness);
    return 0;
}

/// The first field that is wrong. A time step that is no number would never reach the end.
int fault() {
    if (const int field = fault_but_for_step()) return field;
    if (!(row.time_step > 0.0) || row.time_limit / row.time_step > kMostSteps)
        return refused(k_time_step);
    if (row.time_step > row.sample_interval) return refused(k_time_step);
    if (row.time_step > stable_time_step(undeformed(row).ring)) return refused(k_time_step);
    return 0;
}

void put(Vec2 v) {
    values.push_back(v.x);
    values.push_back(v.y);
}

void put_droplet(const Droplet& d) {
    const std::vector<Vec2> r = d.positions();
    const double length = row.neck_separation_in_diameters != 0.0 ? row.neck_separation : 0.0;
    const double fraction = length == 0.0 ? row.neck_separation : 0.0;
    const Neck neck = find_neck(r, {fraction, length * d.ring.diameter});
    const bool necked = neck.first >= 0;
    values.insert(values.end(), {static_cast<double>(d.id), static_cast<double>(d.generation),
                                 static_cast<double>(r.size()), signed_area(r), perimeter(r),
                                 shape_parameter(r), neck.thickness});
    put(necked ? r[neck.first] : Vec2{0, 0});
    put(necked ? r[neck.second] : Vec2{0, 0});
    for (const Vec2& p : r) put(p);
}

}  // namespace

#define PINCHOFF_WORD(name) #name " "
/// Names, each followed by a space: of the row's fields, of the results, of the guards.
PINCHOFF_EXPORT(field_names) const char* field_names() {
    return PINCHOFF_MODEL_FIELDS(PINCHOFF_WORD);
}
PINCHOFF_EXPORT(result_names) const char* result_names() {
    return PINCHOFF_RESULT_FIELDS(PINCHOFF_WORD);
}
#undef PINCHOFF_WORD
#define PINCHOFF_WORD(name, limit) #name " "
PINCHOFF_EXPORT(guard_names) const char* guard_names() { return PINCHOFF_GUARDS(PINCHOFF_WORD); }
#undef PINCHOFF_WORD

/// The row, to be written by the caller.
PINCHOFF_EXPORT(row) double* row_of_numbers() { return reinterpret_cast<double*>(&row); }

/// Put the automatic time step into the row: a whole number of steps a sample.
PINCHOFF_EXPORT(set_automatic_step) int set_automatic_step() {
    if (const int field = fault_but_for_step()) return field;
    const double longest = row.sample_interval;
    row.time_step = longest;
    row.time_step = longest / std::ceil(longest / auto_time_step(undeformed(row).ring));
    return fault();
}

/// Set up the collision of the row.
PINCHOFF_EXPORT(start) int start() {
    collision.reset();
    if (const int field = fault()) return field;
    collision = std::make_unique<Collision>(
        row, flow(), std::vector<Obstacle>{{0.0, 0.0, row.obstacle_radius}},
        std::vector<Start>{{-row.start_distance, row.offset, 1.0}}, kernels_generic);
    return 0;
}

/// Run to the first sample at or after `until`, or to the end; whether the end is still to come.
PINCHOFF_EXPORT(advance) int advance(double until) {
    if (!collision || std::isnan(until)) return 0;
    collision->advance(until, [] { return false; });
    return !collision->finished();
}

PINCHOFF_EXPORT(present_time) double present_time() { return collision ? collision->time() : 0.0; }

/// One number for each of the result's names.
PINCHOFF_EXPORT(result) const double* result() {
    if (collision) results = collision->result();
    return reinterpret_cast<const double*>(&results);
}

/// Lay the droplets out as numbers, for `numbers`; returns how many there are. For each droplet:
/// id, generation, count, area, perimeter, shape parameter, neck, its two ends; count vertices.
PINCHOFF_EXPORT(outlines) int outlines() {
    values.clear();
    if (collision)
        for (const Droplet& d : collision->droplets()) put_droplet(d);
    return static_cast<int>(values.size());
}

/// Lay the first contacts out: time, droplet, obstacle, S, b, speed, area, shape parameter, and
/// centre and velocity of the droplet.
PINCHOFF_EXPORT(contacts) int contacts() {
    values.clear();
    if (collision)
        for (const ContactEvent& c : collision->contacts()) {
            values.insert(values.end(),
                          {c.time, static_cast<double>(c.droplet), static_cast<double>(c.obstacle),
                           c.symmetry, c.impact_parameter, c.speed, c.area, c.shape_parameter});
            put(c.centroid);
            put(c.velocity);
        }
    return static_cast<int>(values.size());
}

/// Lay the break-ups out: time, droplet, both daughters, their areas, neck, and its two ends.
PINCHOFF_EXPORT(breakups) int breakups() {
    values.clear();
    if (collision)
        for (const BreakupEvent& b : collision->breakups()) {
            values.insert(
                values.end(),
                {b.time, static_cast<double>(b.droplet), static_cast<double>(b.daughters[0]),
                 static_cast<double>(b.daughters[1]), b.areas[0], b.areas[1], b.neck_thickness});
            put(b.ends[0]);
            put(b.ends[1]);
        }
    return static_cast<int>(values.size());
}

/// Lay the velocity of the fluid at a point out, for the row's obstacle.
PINCHOFF_EXPORT(fluid_velocity) int fluid_velocity(double x, double y) {
    values.assign(2, 0.0);
    kernels_generic.flow_velocity(flow(), &x, &y, &values[0], &values[1], 1);
    return 2;
}

/// What was laid out last. It moves: look at it anew after every call.
PINCHOFF_EXPORT(numbers) const double* numbers() { return values.data(); }

}  // namespace pinchoff
