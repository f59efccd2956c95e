// The compiled loops for one instruction set. Built once for each, with PINCHOFF_ARCH naming it.
#include "kernels.hpp"

#include "pinchoff/front.hpp"
#include "pinchoff/neck.hpp"
#include "pinchoff/step.hpp"
#include "pinchoff/survey.hpp"

#define PINCHOFF_JOIN_(a, b) a##b
#define PINCHOFF_JOIN(a, b) PINCHOFF_JOIN_(a, b)
#define PINCHOFF_QUOTE_(a) #a
#define PINCHOFF_QUOTE(a) PINCHOFF_QUOTE_(a)

namespace pinchoff {
inline namespace PINCHOFF_ARCH {

static void flow_velocity(const Flow& flow, const double* x, const double* y, double* u, double* v,
                          int count) {
    with_flow(flow, [&](const auto& f) {
        for (int i = 0; i < count; ++i) {
            const Vec2 velocity = f.at({x[i], y[i]});
            u[i] = velocity.x;
            v[i] = velocity.y;
        }
    });
}

static void natural_logs(const double* in, double* out, int count) {
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < count; ++i) out[i] = natural_log(in[i]);
}

}  // namespace PINCHOFF_ARCH

extern const Kernels PINCHOFF_JOIN(kernels_, PINCHOFF_ARCH) = {
    .name = PINCHOFF_QUOTE(PINCHOFF_ARCH),
    .advance = PINCHOFF_ARCH::advance,
    .shift_velocities = PINCHOFF_ARCH::shift_velocities,
    .settle_fronts = PINCHOFF_ARCH::settle_fronts,
    .advance_fronts = PINCHOFF_ARCH::advance_fronts,
    .front_velocities = PINCHOFF_ARCH::front_velocities,
    .survey = PINCHOFF_ARCH::survey,
    .chunk_distance2 = PINCHOFF_ARCH::chunk_distance2,
    .edge_distance2 = PINCHOFF_ARCH::edge_distance2,
    .contains = PINCHOFF_ARCH::contains,
    .scan_neck = PINCHOFF_ARCH::scan_neck,
    .self_intersects = PINCHOFF_ARCH::self_intersects,
    .flow_velocity = PINCHOFF_ARCH::flow_velocity,
    .natural_log = PINCHOFF_ARCH::natural_logs,
};

}  // namespace pinchoff
