// Bindings of many droplets: the run in windows, its events, frames and state as arrays.
#include "pinchoff/emulsion.hpp"

#include <memory>

#include "pool.hpp"
#include "runs.hpp"

namespace pinchoff {

namespace {

using Numbers = Row;
using Four = nb::ndarray<const double, nb::shape<4>, nb::c_contig, nb::device::cpu>;

/// An emulsion with the threads that it runs on and the flow that it refers to.
struct EmulsionRun {
    nb::object flow;  // keeps the node values alive
    Team team;
    Emulsion emulsion;
};

std::vector<double> numbers_of(Numbers values) {
    return {values.data(), values.data() + values.size()};
}

void make_run(EmulsionRun* self, Row model, FlowHandle flow, Triples obstacles, Triples droplets,
              Four cell, bool periodic_x, bool periodic_y, double window, double smallest_breaking,
              Four inlet, Numbers diameters, double outlet, Numbers coalescence, std::uint64_t seed,
              int threads, bool stops_at_guard, bool exhaustive) {
    if (threads < 1)
        throw nb::value_error("threads must be at least 1; got less; give the number of cores");
    if (coalescence.size() != 0 && coalescence.size() != 3)
        throw nb::value_error("coalescence must be 3 numbers or none; got others; see the help");
    Model sampled = row_model(model);
    sampled.sample_interval = window;
    const Box box{cell.data()[0], cell.data()[1], cell.data()[2], cell.data()[3]};
    const Period period{periodic_x ? box.right - box.left : 0.0,
                        periodic_y ? box.top - box.bottom : 0.0};
    World world{clocked(sampled), flow_of(flow), ObstacleGrid(obstacles_of(obstacles), period),
                best_kernels(), period};
    world.retires = true;
    world.smallest_breaking = smallest_breaking;
    world.exhaustive = exhaustive;
    if (coalescence.size() == 3) {
        const double* how = coalescence.data();
        world.coalescence = {true, how[0], how[1], how[2] != 0.0, seed};
    }
    EmulsionSettings settings;
    settings.cell = box;
    const double* in = inlet.data();
    settings.inlet = {in[0], in[1], in[2], in[3], numbers_of(diameters)};
    settings.outlet = outlet;
    settings.seed = seed;
    settings.stops_at_guard = stops_at_guard;
    new (self) EmulsionRun{nb::borrow(flow), Team(threads),
                           Emulsion(std::move(world), settings, starts_of(droplets))};
}

/// Whole windows; fewer where Python has a signal or a guard ended the run.
void advance_run(EmulsionRun& self, int windows) {
    SignalWatch watch;
    {
        const nb::gil_scoped_release release;
        for (int w = 0; w < windows && !self.emulsion.stopped() && !watch(); ++w)
            self.emulsion.advance(self.team.threads(), [&](std::size_t count, const auto& job) {
                self.team.for_each(count, job);
            });
    }
    if (watch.pending()) throw nb::python_error();
}

Matrix take_events(EmulsionRun& self) {
    const std::vector<EmulsionEvent> events = self.emulsion.take_events();
    return matrix_of(events.empty() ? nullptr : reinterpret_cast<const double*>(events.data()),
                     events.size(), kEventFields);
}

/// All outlines in flat arrays: numbers and generations (n, 2), offsets (n + 1), vertices and
/// velocities (v, 2).
nb::tuple frame(const EmulsionRun& self) {
    std::size_t count = 0;
    for (const Droplet& d : self.emulsion.droplets()) count += d.ring.count;
    std::vector<Vec2> numbers, vertices(count), velocities(count);
    std::vector<double> offsets{0.0};
    std::size_t next = 0;
    for (const Droplet& d : self.emulsion.droplets()) {
        numbers.push_back({static_cast<double>(d.id), static_cast<double>(d.generation)});
        for (int i = 0; i < d.ring.count; ++i, ++next) {
            vertices[next] = {d.ring.x[i], d.ring.y[i]};
            velocities[next] = {d.ring.vx[i], d.ring.vy[i]};
        }
        offsets.push_back(static_cast<double>(next));
    }
    return nb::make_tuple(array_of(numbers), array_of(offsets), array_of(vertices),
                          array_of(velocities));
}

/// (n, 5): number, generation, diameter of equal area, x and y of the centre.
Matrix sizes(const EmulsionRun& self) {
    std::vector<double> out;
    for (const Droplet& d : self.emulsion.droplets()) {
        out.push_back(d.id);
        out.push_back(d.generation);
        out.push_back(d.ring.diameter);
        out.push_back(mean(d.ring.x, d.ring.count));
        out.push_back(mean(d.ring.y, d.ring.count));
    }
    return matrix_of(out.empty() ? nullptr : out.data(), out.size() / 5, 5);
}

}  // namespace

void bind_emulsion(nb::module_& m) {
#define PINCHOFF_NAME(name) #name,
    m.attr("EVENT_FIELDS") = tuple_of({PINCHOFF_EVENT_FIELDS(PINCHOFF_NAME)});
    m.attr("EVENT_KINDS") = tuple_of({PINCHOFF_EVENT_KINDS(PINCHOFF_NAME)});
    m.attr("BALANCE_FIELDS") = tuple_of({PINCHOFF_BALANCE_FIELDS(PINCHOFF_NAME)});
#undef PINCHOFF_NAME
    nb::class_<EmulsionRun>(m, "Emulsion", "Many droplets among many obstacles, run in windows.")
        .def("__init__", &make_run, "model"_a, "flow"_a, "obstacles"_a, "droplets"_a, "cell"_a,
             "periodic_x"_a, "periodic_y"_a, "window"_a, "smallest_breaking"_a, "inlet"_a,
             "diameters"_a, "outlet"_a, "coalescence"_a, "seed"_a, "threads"_a,
             "stops_at_guard"_a = false, "exhaustive"_a = false,
             "model, obstacles (M, 3), droplets (K, 3) as for System; cell: left, right, bottom, "
             "top; inlet: x, bottom, top,\n"
             "area fraction (zero: none), with the (n,) diameters that are drawn from; "
             "coalescence: K Ca_sim,\n"
             "s, and whether 1/t_d is a rate, or empty; stops_at_guard: the first droplet that is "
             "taken out ends the run; exhaustive: one "
             "island in which everybody is compared with everybody, for comparison.")
        .def("advance", &advance_run, "windows"_a,
             "Run so many windows, fewer when a guard ended the run. A signal ends it.")
        .def("take_events", &take_events, "(n, len(EVENT_FIELDS)) since this was last asked.")
        .def("frame", &frame,
             "(numbers and generations (n, 2), offsets (n + 1), vertices (v, 2), velocities (v, "
             "2)).")
        .def("sizes", &sizes, "(n, 5): number, generation, diameter, x and y of the centre.")
        .def(
            "balance",
            [](const EmulsionRun& self) {
                const auto* fields = reinterpret_cast<const double*>(&self.emulsion.balance());
                return array_of(std::vector<double>(fields, fields + kBalanceFields));
            },
            "One number for each of BALANCE_FIELDS.")
        .def(
            "state", [](const EmulsionRun& self) { return array_of(self.emulsion.state()); },
            "All that the run goes on from, as numbers.")
        .def(
            "restore",
            [](EmulsionRun& self, Numbers state) {
                self.emulsion.restore({state.data(), state.size()});
            },
            "state"_a, "Go on from a state of the same run.")
        .def_prop_ro("time", [](const EmulsionRun& self) { return self.emulsion.time(); })
        .def_prop_ro("stopped", [](const EmulsionRun& self) { return self.emulsion.stopped(); });
}

}  // namespace pinchoff
