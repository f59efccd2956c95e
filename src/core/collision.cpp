// Bindings of the collision: rows of numbers in, rows of numbers and outlines out.
#include <limits>
#include <memory>
#include <string>

#include "pinchoff/collision.hpp"
#include "pool.hpp"
#include "runs.hpp"

namespace pinchoff {

static Flow stokes_flow(const Obstacle& obstacle) {
    Flow flow;
    flow.kind = FlowKind::stokes;
    flow.radius = obstacle.radius;
    flow.x = obstacle.x;
    flow.y = obstacle.y;
    flow.vx = 1.0;
    return flow;
}

static FlowObject uniform_flow(double vx, double vy) {
    FlowObject object;
    object.flow.kind = FlowKind::uniform;
    object.flow.vx = vx;
    object.flow.vy = vy;
    return object;
}

static FlowObject sampled_flow(double x0, double y0, double dx, double dy, Grid u, Grid v,
                               bool periodic_x, bool periodic_y) {
    if (u.shape(0) != v.shape(0) || u.shape(1) != v.shape(1) || u.shape(0) < 4 || u.shape(1) < 4)
        throw nb::value_error(
            "u and v must have the same shape (ny, nx), at least 4 by 4; got others; "
            "sample both on one grid");
    FlowObject object;
    Flow& f = object.flow;
    f.kind = FlowKind::sampled;
    f.x0 = x0;
    f.y0 = y0;
    f.dx = dx;
    f.dy = dy;
    f.ny = static_cast<int>(u.shape(0));
    f.nx = static_cast<int>(u.shape(1));
    f.periodic_x = periodic_x;
    f.periodic_y = periodic_y;
    object.nodes = padded_nodes(f, u.data(), v.data());
    f.nodes = object.nodes.data();  // stays valid when the object is moved
    return object;
}

static FlowObject brinkman_flow(double radius, double x, double y, Grid cells) {
    if (cells.shape(0) < 1 || cells.shape(1) != 8)
        throw nb::value_error(
            "cells must have the shape (n, 8); got another; give two cubics for each cell");
    FlowObject object;
    Flow& f = object.flow;
    f = stokes_flow({x, y, radius});
    f.kind = FlowKind::brinkman;
    f.nx = static_cast<int>(cells.shape(0));
    object.nodes.assign(cells.data(), cells.data() + 8 * cells.shape(0));
    f.nodes = object.nodes.data();  // stays valid when the object is moved
    return object;
}

static Matrix flow_at(const FlowObject& self, Points points) {
    const std::vector<Vec2> r = points_of(points);
    std::vector<double> x, y, u(r.size()), v(r.size());
    for (const Vec2& p : r) {
        x.push_back(p.x);
        y.push_back(p.y);
    }
    best_kernels().flow_velocity(self.flow, x.data(), y.data(), u.data(), v.data(),
                                 static_cast<int>(r.size()));
    std::vector<Vec2> out(r.size());
    for (std::size_t i = 0; i < r.size(); ++i) out[i] = {u[i], v[i]};
    return array_of(out);
}

/// Velocities of the shape of the points: lists as well as arrays, one point as well as many.
static nb::object flow_velocity(const FlowObject& self, nb::object points) {
    const nb::object numpy = nb::module_::import_("numpy");
    const nb::object array = numpy.attr("ascontiguousarray")(points, "float64");
    const nb::object shape = numpy.attr("shape")(points);
    if (nb::len(shape) == 0 || nb::cast<int>(shape[nb::int_(-1)]) != 2)
        throw nb::value_error(("points must be an array whose last axis is x and y; got shape " +
                               std::string(nb::str(shape).c_str()) +
                               "; give [x, y] or an (n, 2) array")
                                  .c_str());
    const Points rows = nb::cast<Points>(array.attr("reshape")(-1, 2));
    return nb::cast(flow_at(self, rows)).attr("reshape")(shape);
}

static std::string flow_text(const FlowObject& self) {
    const Flow& f = self.flow;
    const auto number = [](double value) {
        return std::string(nb::str(nb::float_(value)).c_str());
    };
    switch (f.kind) {
        case FlowKind::stokes:
            return "<Flow: Stokes around an obstacle of radius " + number(f.radius) + " D0 at (" +
                   number(f.x) + ", " + number(f.y) + ")>";
        case FlowKind::uniform:
            return "<Flow: uniform, (" + number(f.vx) + ", " + number(f.vy) + ") v_f∞>";
        case FlowKind::sampled: break;
    }
    const std::string repeats = std::string(f.periodic_x ? "x" : "") + (f.periodic_y ? "y" : "");
    return "<Flow: sampled at " + std::to_string(f.nx) + " by " + std::to_string(f.ny) +
           " nodes from (" + number(f.x0) + ", " + number(f.y0) + ") D0" +
           (repeats.empty() ? "" : ", periodic along " + repeats) + ">";
}

/// A collision together with the flow that it refers to.
struct System {
    nb::object flow;  // keeps the node values alive
    Collision collision;
};

static void make_system(System* self, Row model, nb::object flow, Triples obstacles,
                        Triples droplets) {
    const Flow plain = nb::cast<const FlowObject&>(flow).flow;
    new (self) System{flow, Collision(checked_model(model), plain, obstacles_of(obstacles),
                                      starts_of(droplets), best_kernels())};
}

static void advance_system(System& self, double time) {
    SignalWatch watch;
    {
        const nb::gil_scoped_release release;
        self.collision.advance(time, [&] { return watch(); });
    }
    if (watch.pending()) throw nb::python_error();
}

static nb::dict dict_of(const Energies& e) {
    nb::dict d;
    double total = 0;
#define PINCHOFF_PUT(name) \
    d[#name] = e.own.name; \
    total += e.own.name;
    PINCHOFF_TERMS(PINCHOFF_PUT)
#undef PINCHOFF_PUT
    d["contact"] = e.contact;
    d["total"] = total + e.contact;
    return d;
}

static nb::dict dict_of(const ContactEvent& c) {
    nb::dict d;
    d["time"] = c.time;
    d["droplet_id"] = c.droplet;
    d["obstacle"] = c.obstacle;
    d["symmetry"] = c.symmetry;
    d["impact_parameter"] = c.impact_parameter;
    d["speed"] = c.speed;
    d["area"] = c.area;
    d["shape_parameter"] = c.shape_parameter;
    d["x"] = c.centroid.x;
    d["y"] = c.centroid.y;
    d["velocity_x"] = c.velocity.x;
    d["velocity_y"] = c.velocity.y;
    d["centroid_velocity_x"] = c.centroid_velocity.x;
    d["centroid_velocity_y"] = c.centroid_velocity.y;
    return d;
}

static nb::dict dict_of(const BreakupEvent& b) {
    nb::dict d;
    d["time"] = b.time;
    d["droplet_id"] = b.droplet;
    d["generation"] = b.generation;
    d["daughter_ids"] = nb::make_tuple(b.daughters[0], b.daughters[1]);
    d["areas"] = nb::make_tuple(b.areas[0], b.areas[1]);
    d["neck_thickness"] = b.neck_thickness;
    d["neck"] = nb::make_tuple(nb::make_tuple(b.ends[0].x, b.ends[0].y),
                               nb::make_tuple(b.ends[1].x, b.ends[1].y));
    return d;
}

template <class Event>
static nb::list list_of(const std::vector<Event>& events) {
    nb::list list;
    for (const Event& e : events) list.append(dict_of(e));
    return list;
}

static nb::list outlines(System& self) {
    nb::list list;
    const std::vector<Droplet>& droplets = self.collision.droplets();
    const std::vector<std::vector<Vec2>> velocities = self.collision.synchronized_velocities();
    for (std::size_t i = 0; i < droplets.size(); ++i) {
        const Droplet& d = droplets[i];
        list.append(
            nb::make_tuple(d.id, d.generation, array_of(d.positions()), array_of(velocities[i])));
    }
    return list;
}

/// One droplet of any shape at an instant, for looks at its forces.
static Droplet droplet_of(const Model& model, Points positions, Points velocities,
                          double diameter) {
    if (positions.shape(0) < static_cast<std::size_t>(kLeastVertices) ||
        velocities.shape(0) != positions.shape(0))
        throw nb::value_error(
            "positions and velocities must have the same shape (n, 2), n at least 16; got others; "
            "give one row for each vertex");
    return Droplet(model, kReferenceArea * diameter * diameter, points_of(positions),
                   points_of(velocities));
}

static nb::dict term_energies(Row model, Points positions, Triples obstacles, double diameter) {
    Energies e;
    add_energies(e, droplet_of(checked_model(model), positions, positions, diameter),
                 obstacles_of(obstacles));
    return dict_of(e);
}

static nb::dict term_forces_of(Row model, Points positions, Triples obstacles, double diameter) {
    const std::vector<Terms<Vec2>> forces = term_forces(
        droplet_of(checked_model(model), positions, positions, diameter), obstacles_of(obstacles));
    std::vector<Vec2> one(forces.size());
    nb::dict d;
#define PINCHOFF_PUT(name)                                                   \
    for (std::size_t i = 0; i < forces.size(); ++i) one[i] = forces[i].name; \
    d[#name] = array_of(one);
    PINCHOFF_TERMS(PINCHOFF_PUT)
#undef PINCHOFF_PUT
    return d;
}

/// Acceleration as the time step computes it, forces and drag in one pass: v relaxes towards its
/// final value at rate ζ, so a = ζ (v(τ) - v)/(1 - exp(-ζ τ)) for any τ.
static Matrix acceleration(Row row, const FlowObject& flow, Points positions, Points velocities,
                           Triples obstacles, double diameter) {
    const Model model = checked_model(row);
    std::vector<Droplet> one;
    one.push_back(droplet_of(model, positions, velocities, diameter));
    Ring& ring = one[0].ring;
    ring.pushed = true;
    std::vector<WallContact> walls;
    for (const Obstacle& o : obstacles_of(obstacles)) walls.push_back({0, 0, ring.padded, o});
    const Scene scene{&ring,   1, flow.flow, walls.data(), static_cast<int>(walls.size()),
                      nullptr, 0};
    const std::vector<Vec2> before = one[0].velocities();
    const double time = 1.0 / ring.drag_rate;
    ring.shift = time;
    best_kernels().shift_velocities(scene);
    std::vector<Vec2> a = one[0].velocities();
    for (std::size_t i = 0; i < a.size(); ++i)
        a[i] = ring.drag_rate / relaxation(ring.drag_rate, time).replaced * (a[i] - before[i]);
    return array_of(a);
}

/// Front tracking of one outline of any shape, its own area kept.
static nb::tuple advance_outline(Row row, const FlowObject& flow, Points positions,
                                 Triples obstacles, double time_step, int steps) {
    const Model model = checked_model(row);
    if (!(model.front_tracking != 0.0))
        throw nb::value_error("model must be front-tracking; got another; set model in Parameters");
    const std::vector<Vec2> r = points_of(positions), rest(r.size(), Vec2{0, 0});
    if (r.size() < static_cast<std::size_t>(kLeastVertices))
        throw nb::value_error("positions must have at least 16 rows; got fewer; add vertices");
    std::vector<Droplet> one;
    one.emplace_back(model, signed_area(r), r, rest);
    Ring& ring = one[0].ring;
    std::vector<WallContact> walls;
    for (const Obstacle& o : obstacles_of(obstacles)) walls.push_back({0, 0, ring.padded, o});
    ring.last_wall = static_cast<int>(walls.size());
    const Scene scene{&ring,   1, flow.flow, walls.data(), static_cast<int>(walls.size()),
                      nullptr, 0};
    best_kernels().front_velocities(scene, time_step);
    best_kernels().advance_fronts(scene, time_step, steps);
    const std::vector<Vec2> advanced = one[0].positions();
    best_kernels().front_velocities(scene, time_step);
    return nb::make_tuple(array_of(advanced), array_of(one[0].velocities()));
}

/// For tests: the list of contacts of one droplet's vertices with another droplet's edges.
static nb::tuple touches_of(Row row, Points one, Points other, double diameter_one,
                            double diameter_other) {
    const Model model = checked_model(row);
    const Droplet a = droplet_of(model, one, one, diameter_one),
                  b = droplet_of(model, other, other, diameter_other);
    ContactLists lists;
    Survey box_a, box_b;
    best_kernels().survey(a.ring, box_a);
    best_kernels().survey(b.ring, box_b);
    const PairRoom room = list_pair(lists, a.ring, 0, box_a.box, b.ring, 1, box_b.box, Vec2{0, 0});
    nb::list list;
    for (const DropletContact& c : lists.touches)
        list.append(nb::make_tuple(c.vertex, c.first_edge, c.edge_count));
    return nb::make_tuple(room.allowed, room.depth, list);
}

/// For tests: all contacts that an island lists, and how far its vertices may then move.
static nb::tuple contact_lists(Row row, const std::vector<Points>& outlines, Triples obstacles,
                               double period_x, double period_y, bool exhaustive) {
    const Model model = checked_model(row);
    World world{model, uniform_flow(0.0, 0.0).flow,
                ObstacleGrid(obstacles_of(obstacles), {period_x, period_y}), best_kernels(),
                Period{period_x, period_y}};
    world.retires = true;  // no guard ends it
    world.exhaustive = exhaustive;
    Island island(world);
    for (const Points& outline : outlines) {
        const std::vector<Vec2> r = points_of(outline);
        Droplet d(model, signed_area(r), r, std::vector<Vec2>(r.size(), Vec2{0, 0}));
        for (int o = 0; o < static_cast<int>(world.obstacles.obstacles().size()); ++o) d.meet(o);
        island.add(std::move(d));
    }
    island.begin(0.0);
    nb::list walls, touches;
    for (const WallContact& c : island.seen().lists.walls)
        walls.append(nb::make_tuple(c.ring, c.first, c.last, c.obstacle.x, c.obstacle.y));
    for (const DropletContact& c : island.seen().lists.touches)
        touches.append(nb::make_tuple(c.ring, c.vertex, c.other, c.first_edge, c.edge_count,
                                      c.image_x, c.image_y));
    return nb::make_tuple(walls, touches);
}

/// For tests: the list of one droplet's vertices that may feel an obstacle which it has met.
static nb::tuple wall_vertices(Row row, Points outline, double x, double y, double radius) {
    const Droplet d = droplet_of(checked_model(row), outline, outline, 1.0);
    Look look;
    const Obstacle obstacle{x, y, radius};
    const Nearby near = look_nearby(look, best_kernels(), d.ring, 0, obstacle, 0);
    const double room =
        list_wall(look.lists, d, 0, obstacle, true, look.distance2.data() + near.chunks);
    nb::list list;
    for (const WallContact& c : look.lists.walls) list.append(nb::make_tuple(c.first, c.last));
    return nb::make_tuple(room, list);
}

/// One collision from start to end, or until `stop` is set.
static Result run_one(const Model& model, const FlowObject* flow, const std::atomic<bool>& stop) {
    const auto [obstacles, droplets] = default_arrangement(model);
    const Flow field = flow ? flow->flow : stokes_flow(obstacles.front());
    Collision collision(model, field, obstacles, droplets, best_kernels());
    collision.advance(std::numeric_limits<double>::infinity(), [&] { return stop.load(); });
    return collision.result();
}

static Matrix run_many(Rows models, const FlowObject* flow, int threads, nb::object progress) {
    if (models.shape(1) != static_cast<std::size_t>(kModelFields))
        throw nb::value_error(
            "models must have one column for each of MODEL_FIELDS; got others; "
            "stack Parameters.model_row()");
    if (threads < 1)
        throw nb::value_error(
            "threads must be at least 1; got less; leave it out to use all cores");
    const std::size_t count = models.shape(0);
    const double* rows = models.data();
    for (std::size_t i = 0; i < count; ++i) clocked(model_of(rows + i * kModelFields));
    std::vector<Result> results(count);
    bool interrupted = false;
    const auto watch = [&](std::size_t done) {
        const nb::gil_scoped_acquire gil;
        if (!progress.is_none() && !interrupted) {
            try {
                progress(done);
            } catch (nb::python_error& e) {
                e.restore();
                interrupted = true;
            }
        }
        if (!interrupted && PyErr_CheckSignals() != 0) interrupted = true;
        return !interrupted;
    };
    {
        const nb::gil_scoped_release release;
        run_jobs(
            count, std::min<std::size_t>(threads, std::max<std::size_t>(count, 1)),
            [&](std::size_t i, const std::atomic<bool>& stop) {
                results[i] = run_one(model_of(rows + i * kModelFields), flow, stop);
            },
            watch);
    }
    if (interrupted) throw nb::python_error();
    return matrix_of(count ? reinterpret_cast<const double*>(results.data()) : nullptr, count,
                     kResultFields);
}

void bind_collision(nb::module_& m) {
#define PINCHOFF_NAME(name) #name,
    m.attr("MODEL_FIELDS") = tuple_of({PINCHOFF_MODEL_FIELDS(PINCHOFF_NAME)});
    m.attr("RESULT_FIELDS") = tuple_of({PINCHOFF_RESULT_FIELDS(PINCHOFF_NAME)});
    m.attr("TERMS") = tuple_of({PINCHOFF_TERMS(PINCHOFF_NAME)});
#undef PINCHOFF_NAME
#define PINCHOFF_NAME(name, limit) #name,
    m.attr("GUARDS") = tuple_of({"", PINCHOFF_GUARDS(PINCHOFF_NAME)});
#undef PINCHOFF_NAME
    nb::dict limits;
#define PINCHOFF_LIMIT(name, limit) limits[#name] = limit_of(Guard::name);
    PINCHOFF_GUARDS(PINCHOFF_LIMIT)
#undef PINCHOFF_LIMIT
    m.attr("GUARD_LIMITS") = limits;

    nb::class_<FlowObject>(m, "Flow",
                           "Fluid velocity as a function of position, in units of v_f∞ and D0.")
        .def("velocity", &flow_velocity, "points"_a,
             "Velocity, v_f∞, at points [x, y], D0: one point, (2,), or many, (..., 2).")
        .def("__repr__", &flow_text);
    m.def(
        "StokesFlow",
        [](double radius, double x, double y) {
            return FlowObject{stokes_flow({x, y, radius}), {}};
        },
        "radius"_a, "x"_a = 0.0, "y"_a = 0.0, "Stokes' flow near a cylinder at (x, y).");
    m.def("BrinkmanFlow", &brinkman_flow, "radius"_a, "x"_a, "y"_a, "cells"_a,
          "Brinkman's flow past a cylinder at (x, y), its parts as cubics in R/r: cells (n, 8).");
    m.def("UniformFlow", &uniform_flow, "vx"_a, "vy"_a, "The same velocity everywhere.");
    m.def("SampledFlow", &sampled_flow, "x0"_a, "y0"_a, "dx"_a, "dy"_a, "u"_a, "v"_a,
          "periodic_x"_a = false, "periodic_y"_a = false,
          "Velocities u, v (ny, nx) on a regular grid with its first node at (x0, y0), "
          "interpolated bicubically.");

    nb::class_<System>(m, "System",
                       "Droplets and obstacles in a flow, from the start to the outcome.")
        .def("__init__", &make_system, "model"_a, "flow"_a, "obstacles"_a, "droplets"_a,
             "model: one number for each of MODEL_FIELDS; obstacles: (M, 3) rows x, y, radius; "
             "droplets: (K, 3) rows x, y,\n"
             "diameter; all in D0.")
        .def("advance", &advance_system, "time"_a,
             "Run to the first sample at or after `time`, or to the end. A signal ends it.")
        .def_prop_ro("finished", [](const System& s) { return s.collision.finished(); })
        .def_prop_ro("time", [](const System& s) { return s.collision.time(); })
        .def(
            "result",
            [](const System& s) {
                const Result r = s.collision.result();
                const double* fields = reinterpret_cast<const double*>(&r);
                return array_of(std::vector<double>(fields, fields + kResultFields));
            },
            "One number for each of RESULT_FIELDS.")
        .def("outlines", &outlines,
             "List of (id, generation, positions (n, 2), velocities (n, 2)), one a droplet.")
        .def(
            "energies", [](System& s) { return dict_of(s.collision.energies()); },
            "Energy by term, in M v_f∞².")
        .def("contacts", [](const System& s) { return list_of(s.collision.contacts()); })
        .def("breakups", [](const System& s) { return list_of(s.collision.breakups()); });

    m.def(
        "default_arrangement",
        [](Row row) {
            const auto [obstacles, droplets] = default_arrangement(checked_model(row));
            const Obstacle& o = obstacles.front();
            const Start& d = droplets.front();
            return nb::make_tuple(nb::make_tuple(o.x, o.y, o.radius),
                                  nb::make_tuple(d.x, d.y, d.diameter));
        },
        "model"_a,
        "The obstacle (x, y, radius) and the droplet (x, y, diameter) unless others are given.");
    m.def("term_energies", &term_energies, "model"_a, "positions"_a, "obstacles"_a,
          "diameter"_a = 1.0, "Energy by term of one droplet of any shape (n, 2), in M v_f∞².");
    m.def("term_forces", &term_forces_of, "model"_a, "positions"_a, "obstacles"_a,
          "diameter"_a = 1.0,
          "Force by term on every vertex (n, 2) of one droplet of any shape, in M v_f∞²/D0.");
    m.def("acceleration", &acceleration, "model"_a, "flow"_a, "positions"_a, "velocities"_a,
          "obstacles"_a, "diameter"_a = 1.0,
          "Acceleration (n, 2) of the vertices as the time step computes it, drag included.");

    m.def("touches", &touches_of, "model"_a, "one"_a, "other"_a, "diameter_one"_a = 1.0,
          "diameter_other"_a = 1.0,
          "Contacts that the engine lists between the vertices of one droplet (n, 2) and the edges "
          "of another (m, 2):\n"
          "(displacement of all vertices below which the list stays complete, depth, list of "
          "(vertex, first edge, edges)).\nFor tests.");
    m.def("contact_lists", &contact_lists, "model"_a, "outlines"_a, "obstacles"_a,
          "period_x"_a = 0.0, "period_y"_a = 0.0, "exhaustive"_a = false,
          "All contacts that the engine lists among droplets (n, 2) that have met the obstacles "
          "(M, 3):\n"
          "(walls (droplet, first, last + 1, x, y), touches (droplet, vertex, other, first edge, "
          "edges, image x, image y)).\n"
          "exhaustive: everybody is compared with everybody. For tests.");
    m.def("wall_vertices", &wall_vertices, "model"_a, "outline"_a, "x"_a, "y"_a, "radius"_a,
          "Vertices of a droplet (n, 2) that the engine lists as near an obstacle: (displacement "
          "below which the list\n"
          "stays complete, list of (first, last + 1)). For tests.");

    m.def(
        "advance_front", &advance_outline, "model"_a, "flow"_a, "positions"_a, "obstacles"_a,
        "time_step"_a, "steps"_a,
        "Front tracking: positions and velocities (n, 2) of one outline (n, 2) of any shape after "
        "`steps` steps among obstacles,\n"
        "its area kept.");

    m.def("run_many", &run_many, "models"_a, "flow"_a.none(), "threads"_a, "progress"_a.none(),
          "Run (n, len(MODEL_FIELDS)) collisions of one droplet with one obstacle; returns (n, "
          "len(RESULT_FIELDS)).");
    m.def(
        "stable_time_step",
        [](Row model) { return stable_time_step(undeformed(row_model(model)).ring); }, "model"_a,
        "Largest stable time step of the model's undeformed droplet, in t0.");
    m.def(
        "auto_time_step",
        [](Row model) { return auto_time_step(undeformed(row_model(model)).ring); }, "model"_a,
        "Time step with a margin for the deformed droplet and for accuracy, in t0.");
    m.def(
        "instruction_set", [] { return std::string(best_kernels().name); },
        "Instruction set of the compiled loops.");
}

}  // namespace pinchoff

NB_MODULE(_core, m) {
    m.doc() = "Compiled core of pinchoff: geometry of outlines, flows, and the collision.";
    pinchoff::bind_geometry(m);
    pinchoff::bind_rays(m);
    pinchoff::bind_collision(m);
    pinchoff::bind_emulsion(m);
}
