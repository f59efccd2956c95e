// Fluid velocity at a point. A flow is a small struct with one function: Vec2 at(Vec2 r).
#pragma once

#include "math.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Stokes' solution near a cylinder, zero on its surface and inside it [paper, eqs. for v_f,r and
/// v_f,θ]. In Cartesian form it needs neither an angle nor a square root: with ρ = R²/r² and
/// q = (ρ - 1)/2, u = ½ ln(1/ρ) + q (x² - y²)/r² and v = 2 q x y / r², in units of v_f∞.
struct StokesFlow {
    double x, y, radius2, speed;

    PINCHOFF_HD explicit StokesFlow(const Flow& f)
        : x(f.x), y(f.y), radius2(f.radius * f.radius), speed(f.vx) {}

    PINCHOFF_HD Vec2 at(Vec2 r) const {
        const double dx = r.x - x, dy = r.y - y;
        const double x2 = dx * dx, y2 = dy * dy;
        const double r2 = x2 + y2;
        const double inverse = 1.0 / r2;
        const double rho = radius2 * inverse;
        const double q_over_r2 = 0.5 * (rho - 1.0) * inverse;
        const double u = -0.5 * natural_log(rho) + q_over_r2 * (x2 - y2);
        const double v = 2.0 * q_over_r2 * (dx * dy);
        const bool outside = rho < 1.0;
        return {outside ? speed * u : 0.0, outside ? speed * v : 0.0};
    }
};

struct UniformFlow {
    Vec2 velocity;

    PINCHOFF_HD explicit UniformFlow(const Flow& f) : velocity{f.vx, f.vy} {}

    PINCHOFF_HD Vec2 at(Vec2) const { return velocity; }
};

/// Node values on a regular grid, interpolated by cubic convolution (Keys, a = -1/2): it passes
/// through the nodes, has continuous slopes, reproduces quadratics and converges as the cube of
/// the spacing. Outside the grid the edge value continues; the collision refuses to go there.
struct SampledFlow {
    const double *u, *v;
    int nx, ny;
    double x0, y0, inverse_dx, inverse_dy;

    PINCHOFF_HD explicit SampledFlow(const Flow& f)
        : u(f.u), v(f.v), nx(f.nx), ny(f.ny), x0(f.x0), y0(f.y0), inverse_dx(1.0 / f.dx),
          inverse_dy(1.0 / f.dy) {}

    /// Weights of the four nodes around a point a fraction t past the second of them.
    PINCHOFF_HD static void weights(double t, double w[4]) {
        w[0] = t * (-0.5 + t * (1.0 - 0.5 * t));
        w[1] = 1.0 + t * t * (-2.5 + 1.5 * t);
        w[2] = t * (0.5 + t * (2.0 - 1.5 * t));
        w[3] = t * t * (-0.5 + 0.5 * t);
    }

    /// Value at node (i, j), continued linearly by one node past the edge so that quadratics'
    /// slopes at the rim stay right to second order.
    PINCHOFF_HD double node(const double* f, int i, int j) const {
        if (i < 0) return 2.0 * node(f, 0, j) - node(f, 1, j);
        if (i >= nx) return 2.0 * node(f, nx - 1, j) - node(f, nx - 2, j);
        if (j < 0) return 2.0 * f[i] - f[nx + i];
        if (j >= ny) return 2.0 * f[(ny - 1) * nx + i] - f[(ny - 2) * nx + i];
        return f[j * nx + i];
    }

    /// Cell and fraction along one axis. Written so that a coordinate that is not a number gives
    /// cell 0 and keeps the fraction not a number, instead of reading outside the grid.
    PINCHOFF_HD static int locate(double s, int n, double& t) {
        const double clamped = s > 0.0 ? (s < n - 1.0 ? s : n - 1.0) : (s <= 0.0 ? 0.0 : s);
        const int cell = clamped >= 0.0 ? static_cast<int>(clamped) : 0;
        const int last = cell > n - 2 ? n - 2 : cell;
        t = clamped - last;
        return last;
    }

    PINCHOFF_HD Vec2 at(Vec2 r) const {
        double tx, ty, wx[4], wy[4];
        const int i = locate((r.x - x0) * inverse_dx, nx, tx);
        const int j = locate((r.y - y0) * inverse_dy, ny, ty);
        weights(tx, wx);
        weights(ty, wy);
        Vec2 sum{0.0, 0.0};
        for (int b = 0; b < 4; ++b) {
            for (int a = 0; a < 4; ++a) {
                const double w = wx[a] * wy[b];
                sum.x += w * node(u, i - 1 + a, j - 1 + b);
                sum.y += w * node(v, i - 1 + a, j - 1 + b);
            }
        }
        return sum;
    }
};

/// Calls `use` with the flow in its own type, so that a loop over vertices has no branch on it.
template <class Use>
void with_flow(const Flow& flow, Use&& use) {
    switch (flow.kind) {
        case FlowKind::stokes: use(StokesFlow(flow)); break;
        case FlowKind::uniform: use(UniformFlow(flow)); break;
        case FlowKind::sampled: use(SampledFlow(flow)); break;
    }
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
