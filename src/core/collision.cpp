// Bindings of the collision: rows of numbers in, rows of numbers and outlines out.
#include "pinchoff/collision.hpp"

#include <limits>
#include <string>

#include "pool.hpp"
#include "runs.hpp"

namespace pinchoff {

namespace {

/// A collision together with the flow that it refers to.
struct System {
    nb::object flow;  // keeps the node values alive
    Collision collision;
};

void make_system(System* self, Row model, FlowHandle flow, Triples obstacles, Triples droplets) {
    new (self) System{nb::borrow(flow),
                      Collision(checked_model(model), flow_of(flow), obstacles_of(obstacles),
                                starts_of(droplets), best_kernels())};
}

void advance_system(System& self, double time) {
    SignalWatch watch;
    {
        const nb::gil_scoped_release release;
        self.collision.advance(time, [&] { return watch(); });
    }
    if (watch.pending()) throw nb::python_error();
}

nb::dict dict_of(const ContactEvent& c) {
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

nb::dict dict_of(const BreakupEvent& b) {
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
nb::list list_of(const std::vector<Event>& events) {
    nb::list list;
    for (const Event& e : events) list.append(dict_of(e));
    return list;
}

nb::list outlines(System& self) {
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

/// One collision from start to end, or until `stop` is set.
Result run_one(const Model& model, const FlowObject* flow, const std::atomic<bool>& stop) {
    const auto [obstacles, droplets] = default_arrangement(model);
    const Flow field = flow ? flow->flow : stokes_flow(obstacles.front());
    Collision collision(model, field, obstacles, droplets, best_kernels());
    collision.advance(std::numeric_limits<double>::infinity(), [&] { return stop.load(); });
    return collision.result();
}

Matrix run_many(Rows models, const FlowObject* flow, int threads, nb::object progress) {
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
            count, static_cast<int>(std::clamp<std::size_t>(count, 1, threads)),
            [&](std::size_t i, const std::atomic<bool>& stop) {
                results[i] = run_one(model_of(rows + i * kModelFields), flow, stop);
            },
            watch);
    }
    if (interrupted) throw nb::python_error();
    return matrix_of(count ? reinterpret_cast<const double*>(results.data()) : nullptr, count,
                     kResultFields);
}

}  // namespace

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
#ifdef NDEBUG
    // At exit Python leaves alive what threads and modules still hold; users would read of leaks.
    nb::set_leak_warnings(false);
#endif
    m.doc() = "Compiled core of pinchoff: geometry of outlines, flows, and the collision.";
    pinchoff::bind_geometry(m);
    pinchoff::bind_flows(m);
    pinchoff::bind_rays(m);
    pinchoff::bind_collision(m);
    pinchoff::bind_inspection(m);
    pinchoff::bind_emulsion(m);
}
