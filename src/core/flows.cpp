// Bindings of the flows: grids and radii in, velocities out.
#include <string>

#include "runs.hpp"

namespace pinchoff {

namespace {

FlowObject sampled_flow(double x0, double y0, double dx, double dy, Grid u, Grid v, bool periodic_x,
                        bool periodic_y) {
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

FlowObject brinkman_flow(double radius, double x, double y, Grid cells) {
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

Matrix flow_at(const FlowObject& self, Points points) {
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
nb::object flow_velocity(const FlowObject& self, nb::object points) {
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

std::string flow_text(const FlowObject& self) {
    const Flow& f = self.flow;
    const auto number = [](double value) {
        return std::string(nb::str(nb::float_(value)).c_str());
    };
    const std::string place =
        "radius " + number(f.radius) + " D0 at (" + number(f.x) + ", " + number(f.y) + ")";
    switch (f.kind) {
        case FlowKind::stokes: return "<Flow: Stokes around an obstacle of " + place + ">";
        case FlowKind::brinkman: return "<Flow: Brinkman around an obstacle of " + place + ">";
        case FlowKind::uniform:
            return "<Flow: uniform, (" + number(f.vx) + ", " + number(f.vy) + ") v_f∞>";
        case FlowKind::sampled: break;
    }
    const std::string repeats = std::string(f.periodic_x ? "x" : "") + (f.periodic_y ? "y" : "");
    return "<Flow: sampled at " + std::to_string(f.nx) + " by " + std::to_string(f.ny) +
           " nodes from (" + number(f.x0) + ", " + number(f.y0) + ") D0" +
           (repeats.empty() ? "" : ", periodic along " + repeats) + ">";
}

}  // namespace

void bind_flows(nb::module_& m) {
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
    m.def(
        "UniformFlow", [](double vx, double vy) { return FlowObject{uniform_flow(vx, vy), {}}; },
        "vx"_a, "vy"_a, "The same velocity everywhere.");
    m.def("SampledFlow", &sampled_flow, "x0"_a, "y0"_a, "dx"_a, "dy"_a, "u"_a, "v"_a,
          "periodic_x"_a = false, "periodic_y"_a = false,
          "Velocities u, v (ny, nx) on a regular grid with its first node at (x0, y0), "
          "interpolated bicubically.");
}

}  // namespace pinchoff
