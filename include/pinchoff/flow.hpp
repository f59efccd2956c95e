// Fluid velocity at a point. A flow is a small struct with a function Vec2 at(Vec2 r). Where
// kByRing is true it is not evaluated in the loop over vertices that sums the forces, but before
// it, by fill(ring, x, y): at the places x, y (padded), into the ring's fluid_x, fluid_y.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "math.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Stokes' solution near a cylinder, zero on its surface and inside it [paper, eqs. for v_f,r and
/// v_f,θ]. In Cartesian form it needs neither an angle nor a square root: with ρ = R²/r² and
/// q = (ρ - 1)/2, u = ½ ln(1/ρ) + q (x² - y²)/r² and v = 2 q x y / r², in units of v_f∞.
struct StokesFlow {
    static constexpr bool kByRing = false;
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

/// Brinkman's depth-averaged flow past a cylinder in a thin gap, zero on its surface and inside it:
/// v_r = f cos θ and v_θ = -g sin θ, so that u = g + (f - g) x²/r² and v = (f - g) x y/r². Both are
/// functions of r alone, which hold Bessel functions; they come as cubics in R/r, nodes (nx, 8):
/// the four coefficients of f - g in the fraction of a cell, then those of g.
struct BrinkmanFlow {
    static constexpr bool kByRing = true;
    double x, y, radius2, speed, cells;
    const double* nodes;

    explicit BrinkmanFlow(const Flow& f)
        : x(f.x), y(f.y), radius2(f.radius * f.radius), speed(f.vx), cells(f.nx), nodes(f.nodes) {}

    /// Cell and fraction in it; the first cell, and a fraction that is not below 1, where there is
    /// no flow. A distance that is not a number keeps to the table.
    int locate(double inverse2, double& t) const {
        const double place = cells * std::sqrt(radius2 * inverse2);
        const double cell = place < cells ? place : 0.0;
        const int whole = static_cast<int>(cell);
        t = place - whole;
        return whole;
    }

    Vec2 at(Vec2 r) const {
        const double dx = r.x - x, dy = r.y - y, r2 = dx * dx + dy * dy, inverse2 = 1.0 / r2;
        double t;
        const double* c = nodes + 8 * locate(inverse2, t);
        const double difference = c[0] + t * (c[1] + t * (c[2] + t * c[3]));
        const double g = c[4] + t * (c[5] + t * (c[6] + t * c[7]));
        const double along = difference * inverse2;
        const bool outside = r2 > radius2;
        return {outside ? speed * (g + along * dx * dx) : 0.0,
                outside ? speed * (along * dx * dy) : 0.0};
    }

    void fill(const Ring& ring, const double* x_at, const double* y_at) const {
        constexpr int kCoefficients = 8;
        static_assert(kCoefficients % kWidth == 0);
        for (int first = 0; first < ring.padded; first += kWidth) {
            const Lanes dx = load(x_at + first) - x, dy = load(y_at + first) - y;
            const Lanes r2 = dx * dx + dy * dy, inverse2 = 1.0 / r2, none{};
            double t[kWidth], inverse[kWidth];
            int cell[kWidth];
            store(inverse, inverse2);
            for (int l = 0; l < kWidth; ++l) cell[l] = locate(inverse[l], t[l]);
            // The coefficients of one vertex lie side by side; those of one kind are wanted so.
            Lanes c[kCoefficients];
            for (int k = 0; k < kCoefficients; k += kWidth) {
                for (int l = 0; l < kWidth; ++l)
                    c[k + l] = load(nodes + kCoefficients * cell[l] + k);
                transpose(c + k);
            }
            const Lanes part = load(t);
            const Lanes difference = c[0] + part * (c[1] + part * (c[2] + part * c[3]));
            const Lanes g = c[4] + part * (c[5] + part * (c[6] + part * c[7]));
            const Lanes along = difference * inverse2;
            store(ring.fluid_x + first, r2 > radius2 ? speed * (g + along * dx * dx) : none);
            store(ring.fluid_y + first, r2 > radius2 ? speed * (along * dx * dy) : none);
        }
    }
};

struct UniformFlow {
    static constexpr bool kByRing = false;
    Vec2 velocity;

    PINCHOFF_HD explicit UniformFlow(const Flow& f) : velocity{f.vx, f.vy} {}

    PINCHOFF_HD Vec2 at(Vec2) const { return velocity; }
};

/// Node values on a regular grid, interpolated by cubic convolution (Keys, a = -1/2): it passes
/// through the nodes, has continuous slopes, reproduces quadratics and converges as the cube of
/// the spacing. Outside the grid the edge value continues; the collision refuses to go there. Along
/// a periodic axis the grid repeats.
///
/// The nodes lie in a grid that is padded by one row before and two after, u and v side by side, so
/// that the four nodes of a row, of both components, are one register.
struct SampledFlow {
    static constexpr bool kByRing = true;
    const double* nodes;
    std::int64_t stride;  // numbers from one row of nodes to the next
    double x0, y0, inverse_dx, inverse_dy, cells_x, cells_y, wrap_x, wrap_y;

    explicit SampledFlow(const Flow& f)
        : nodes(f.nodes), stride(2 * padded_length(f.nx)), x0(f.x0), y0(f.y0),
          inverse_dx(1.0 / f.dx), inverse_dy(1.0 / f.dy), cells_x(f.periodic_x ? f.nx : f.nx - 1),
          cells_y(f.periodic_y ? f.ny : f.ny - 1), wrap_x(f.periodic_x ? 1.0 / f.nx : 0.0),
          wrap_y(f.periodic_y ? 1.0 / f.ny : 0.0) {}

    static constexpr int padded_length(int nodes) { return nodes + 3; }

    /// Cell and fraction along one axis. Written so that a coordinate that is not a number gives
    /// cell 0 and keeps the fraction not a number, instead of reading outside the grid.
    static int locate(double s, double cells, double wrap, double& t) {
        s -= std::floor(s * wrap) * cells;
        const double below = s < cells ? s : (s >= cells ? cells : s);
        const double clamped = below > 0.0 ? below : (below <= 0.0 ? 0.0 : below);
        const double cell = clamped > 0.0 ? (clamped < cells - 1.0 ? clamped : cells - 1.0) : 0.0;
        const int whole = static_cast<int>(cell);
        t = clamped - whole;
        return whole;
    }

    Vec2 at(Vec2 r) const {
        double tx, ty;
        const int i = locate((r.x - x0) * inverse_dx, cells_x, wrap_x, tx);
        const int j = locate((r.y - y0) * inverse_dy, cells_y, wrap_y, ty);
        return interpolate(i, j, tx, weights_of(ty));
    }

    /// Weights of the four nodes around a point.
    struct Weights {
        double first, second, third, fourth;
    };

    /// Those of a point a fraction t past the second of them.
    static Weights weights_of(double t) {
        return {t * (-0.5 + t * (1.0 - 0.5 * t)), 1.0 + t * t * (-2.5 + 1.5 * t),
                t * (0.5 + t * (2.0 - 1.5 * t)), t * t * (-0.5 + 0.5 * t)};
    }

    /// Velocity in cell (i, j): at the fraction tx along x, with weights of its rows of nodes.
    Vec2 interpolate(int i, int j, double tx, const Weights& rows) const {
        const double* first = nodes + j * stride + 2 * i;
        // The weights along x, as polynomials in tx, twice each: for u and for v.
        alignas(64) static constexpr double kConstant[]{0, 0, 1, 1, 0, 0, 0, 0};
        alignas(64) static constexpr double kLinear[]{-0.5, -0.5, 0, 0, 0.5, 0.5, 0, 0};
        alignas(64) static constexpr double kSquare[]{1, 1, -2.5, -2.5, 2, 2, -0.5, -0.5};
        alignas(64) static constexpr double kCube[]{-0.5, -0.5, 1.5, 1.5, -1.5, -1.5, 0.5, 0.5};
        Lanes total{};
        for (int k = 0; k < 8; k += kWidth) {
            const double* at = first + k;
            const Lanes column = rows.first * load(at) + rows.second * load(at + stride) +
                                 rows.third * load(at + 2 * stride) +
                                 rows.fourth * load(at + 3 * stride);
            total += column *
                     (load(kConstant + k) +
                      tx * (load(kLinear + k) + tx * (load(kSquare + k) + tx * load(kCube + k))));
        }
        return sum_of_points(total);
    }

    void fill(const Ring& ring, const double* x_at, const double* y_at) const {
        for (int first = 0; first < ring.padded; first += kLanes) {
            // Apart from the interpolation, so that compilers vectorise it.
            double tx[kLanes];
            Weights rows[kLanes];
            int i[kLanes], j[kLanes];
            for (int l = 0; l < kLanes; ++l) {
                i[l] = locate((x_at[first + l] - x0) * inverse_dx, cells_x, wrap_x, tx[l]);
                double ty;
                j[l] = locate((y_at[first + l] - y0) * inverse_dy, cells_y, wrap_y, ty);
                rows[l] = weights_of(ty);
            }
            for (int l = 0; l < kLanes; ++l) {
                const Vec2 fluid = interpolate(i[l], j[l], tx[l], rows[l]);
                ring.fluid_x[first + l] = fluid.x;
                ring.fluid_y[first + l] = fluid.y;
            }
        }
    }
};

/// The node values u, v (ny, nx) in that padded grid. Past an edge they continue linearly, so that
/// quadratics' slopes at the rim stay right to second order, or, along a periodic axis, from the
/// other side.
inline std::vector<double> padded_nodes(const Flow& flow, const double* u, const double* v) {
    const int columns = SampledFlow::padded_length(flow.nx),
              rows = SampledFlow::padded_length(flow.ny);
    const int nx = flow.nx, ny = flow.ny;
    std::vector<double> nodes(2 * static_cast<std::size_t>(columns) * rows);
    const auto value = [&](const double* f, int i, int j, const auto& self) -> double {
        if (flow.periodic_x) i = (i + nx) % nx;
        if (flow.periodic_y) j = (j + ny) % ny;
        if (i < 0) return 2.0 * self(f, 0, j, self) - self(f, 1, j, self);
        if (i >= nx) return 2.0 * self(f, i - 1, j, self) - self(f, i - 2, j, self);
        if (j < 0) return 2.0 * self(f, i, 0, self) - self(f, i, 1, self);
        if (j >= ny) return 2.0 * self(f, i, j - 1, self) - self(f, i, j - 2, self);
        return f[static_cast<std::size_t>(j) * nx + i];
    };
    double* next = nodes.data();
    for (int j = -1; j < rows - 1; ++j)
        for (int i = -1; i < columns - 1; ++i) {
            *next++ = value(u, i, j, value);
            *next++ = value(v, i, j, value);
        }
    return nodes;
}

/// Calls `use` with the flow in its own type, so that a loop over vertices has no branch on it.
template <class Use>
void with_flow(const Flow& flow, Use&& use) {
    switch (flow.kind) {
        case FlowKind::stokes: use(StokesFlow(flow)); break;
        case FlowKind::uniform: use(UniformFlow(flow)); break;
        case FlowKind::sampled: use(SampledFlow(flow)); break;
        case FlowKind::brinkman: use(BrinkmanFlow(flow)); break;
    }
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
