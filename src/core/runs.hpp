// What the bindings of runs share: rows of numbers in, plain flows, energies out, signals.
#pragma once

#include "bindings.hpp"

#include <chrono>
#include <cstring>
#include <string>

#include "pinchoff/droplet.hpp"
#include "pinchoff/energy.hpp"

namespace pinchoff {

using Row = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Triples = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Grid = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

/// A flow as Python holds it: the plain description and, for a sampled one, its node values.
struct FlowObject {
    Flow flow;
    std::vector<double> nodes;
};

/// A flow that a run refers to: the run keeps it, and with it the node values, alive.
using FlowHandle = nb::handle_t<FlowObject>;

inline const Flow& flow_of(FlowHandle handle) { return nb::cast<const FlowObject&>(handle).flow; }

/// Stokes' flow round one obstacle: that of a run to which no other is given.
inline Flow stokes_flow(const Obstacle& obstacle) {
    Flow flow;
    flow.kind = FlowKind::stokes;
    flow.radius = obstacle.radius;
    flow.x = obstacle.x;
    flow.y = obstacle.y;
    flow.vx = 1.0;
    return flow;
}

inline Flow uniform_flow(double vx, double vy) {
    Flow flow;
    flow.kind = FlowKind::uniform;
    flow.vx = vx;
    flow.vy = vy;
    return flow;
}

inline Model model_of(const double* row) {
    Model model;
    std::memcpy(&model, row, sizeof model);
    return model;
}

/// Refuses a model whose run could not be counted.
inline Model clocked(const Model& model) {
    if (const char* rule = wrong_clock(model))
        throw nb::value_error(
            (std::string("model: ") + rule + "; got another number; use Parameters.model_row()")
                .c_str());
    return model;
}

inline Model row_model(Row row) {
    if (row.shape(0) != static_cast<std::size_t>(kModelFields))
        throw nb::value_error(
            "model must have one number for each of MODEL_FIELDS; got another length; "
            "use Parameters.model_row()");
    return model_of(row.data());
}

inline Model checked_model(Row row) { return clocked(row_model(row)); }

inline std::vector<Obstacle> obstacles_of(Triples rows) {
    std::vector<Obstacle> list;
    for (std::size_t i = 0; i < rows.shape(0); ++i) {
        const double* o = rows.data() + 3 * i;
        list.push_back({o[0], o[1], o[2]});
    }
    return list;
}

inline std::vector<Start> starts_of(Triples rows) {
    std::vector<Start> list;
    for (std::size_t i = 0; i < rows.shape(0); ++i) {
        const double* d = rows.data() + 3 * i;
        list.push_back({d[0], d[1], d[2]});
    }
    return list;
}

/// Says, ten times a second at most, whether Python has a signal for this thread.
class SignalWatch {
public:
    bool operator()() {
        const auto now = std::chrono::steady_clock::now();
        if (!pending_ && now - last_ > std::chrono::milliseconds(100)) {
            last_ = now;
            const nb::gil_scoped_acquire gil;
            pending_ = PyErr_CheckSignals() != 0;
        }
        return pending_;
    }
    bool pending() const { return pending_; }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
    bool pending_ = false;
};

inline nb::dict dict_of(const Energies& e) {
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

inline nb::tuple tuple_of(const std::vector<const char*>& names) {
    nb::list list;
    for (const char* n : names) list.append(nb::str(n));
    return nb::tuple(list);
}

}  // namespace pinchoff
