// One time step: leapfrog form of velocity Verlet in which the drag is integrated exactly.
//
// With ζ = μ D0/M the equation of motion of a vertex is dv/dt = F(r)/m + ζ (v_f(r) - v). Velocities
// live half a step before positions. Over one step, with the position-dependent part frozen at its
// middle, v relaxes by 1 - exp(-ζ Δt) towards v_f + F/(m ζ), then r moves by Δt v. That is
// symmetric about the position, so second order, and without drag it is velocity Verlet. Where ζ Δt
// is large the velocity follows the forces with a lag that stays below half a step.
#pragma once

#include <algorithm>
#include <cmath>

#include "flow.hpp"
#include "forces.hpp"
#include "polygon.hpp"
#include "types.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Fill the ghost vertices of two arrays of a ring from the vertices they repeat.
inline void wrap(const Ring& ring, double* x, double* y) {
    for (double* a : {x, y}) {
        a[-1] = a[ring.count - 1];
        for (int i = ring.count; i <= ring.padded; ++i) a[i] = a[i - ring.count];
    }
}

/// The same of arrays without ghosts at their ends.
inline void repeat_first(const Ring& ring, double* x, double* y) {
    for (int i = ring.count; i < ring.padded; ++i) {
        x[i] = x[i - ring.count];
        y[i] = y[i - ring.count];
    }
}

/// The vertices, and the edges that start at them, before and after one.
inline int before(const Ring& ring, int i) { return i == 0 ? ring.count - 1 : i - 1; }
inline int after(const Ring& ring, int i) { return i + 1 == ring.count ? 0 : i + 1; }

/// Tension of every edge into pull_x, pull_y; returns the signed area.
inline double pull_edges(Ring ring) {
    const double* x = ring.x;
    const double* y = ring.y;
    double* px = ring.pull_x;
    double* py = ring.pull_y;
    const int padded = ring.padded;
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < padded; ++i) {
        const Vec2 e = Vec2{x[i + 1], y[i + 1]} - Vec2{x[i], y[i]};
        const double inverse = 1.0 / std::sqrt(dot(e, e));
        const double pull = edge_pulls(ring, inverse);
        px[i] = pull * e.x;
        py[i] = pull * e.y;
    }
    px[-1] = px[ring.count - 1];
    py[-1] = py[ring.count - 1];
    return signed_area(ring);
}

/// New velocities from the forces at the present positions. Track: add to the path of each vertex.
template <bool Push, bool Track, class FlowAt>
void kick(const Ring& ring, const FlowAt& flow, Relaxation relaxation) {
    const double p = pressure(pull_edges(ring), ring.rest_area, ring.area_stiffness);
    if constexpr (FlowAt::kByRing) flow.fill(ring, ring.x, ring.y);
    const double* fluid_x = ring.fluid_x;
    const double* fluid_y = ring.fluid_y;
    const double* x = ring.x;
    const double* y = ring.y;
    const double* px = ring.pull_x;
    const double* py = ring.pull_y;
    const double* push_x = ring.push_x;
    const double* push_y = ring.push_y;
    double* vx = ring.vx;
    double* vy = ring.vy;
    double* path = ring.path;
    const double mobility = ring.mobility, wx = ring.drift_x, wy = ring.drift_y;
    const int padded = ring.padded;
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < padded; ++i) {
        const Vec2 before{x[i - 1], y[i - 1]}, here{x[i], y[i]}, after{x[i + 1], y[i + 1]};
        Vec2 fluid;
        if constexpr (FlowAt::kByRing) fluid = {fluid_x[i], fluid_y[i]};
        else fluid = flow.at(here);
        Vec2 force = vertex_force(ring, before, here, after, p);
        force.x += px[i] - px[i - 1];
        force.y += py[i] - py[i - 1];
        if constexpr (Push) {
            force.x += push_x[i];
            force.y += push_y[i];
        }
        const Vec2 v = relax_velocity({vx[i], vy[i]}, fluid, force, mobility, relaxation);
        vx[i] = v.x;
        vy[i] = v.y;
        if constexpr (Track) {
            const Vec2 relative = v - Vec2{wx, wy};
            path[i] += dot(relative, relative);
        }
    }
}

inline void drift(const Ring& ring, double time_step) {
    double* x = ring.x;
    double* y = ring.y;
    const double* vx = ring.vx;
    const double* vy = ring.vy;
    PINCHOFF_INDEPENDENT
    for (int i = 0; i < ring.padded; ++i) {
        x[i] += time_step * vx[i];
        y[i] += time_step * vy[i];
    }
    wrap(ring, x, y);
}

/// Repulsion of the listed vertices from their obstacle.
inline void push_from_walls(const Scene& scene) {
    for (int c = 0; c < scene.wall_count; ++c) {
        const WallContact& contact = scene.walls[c];
        const Ring& ring = scene.rings[contact.ring];
        const Obstacle o = contact.obstacle;
        const double* x = ring.x;
        const double* y = ring.y;
        double* push_x = ring.push_x;
        double* push_y = ring.push_y;
        const double rest = ring.rest_length, stiffness = ring.wall_stiffness;
        PINCHOFF_INDEPENDENT
        for (int i = contact.first; i < contact.last; ++i) {
            const Vec2 r = displacement({o.x, o.y}, {x[i], y[i]});
            const double distance = std::sqrt(dot(r, r));
            const double f = contact_force(distance - o.radius, rest, stiffness) / distance;
            push_x[i] += f * r.x;
            push_y[i] += f * r.y;
        }
    }
}

/// Forces of adhesion to one wall on the ends of all edges, times `scale`: into fx, fy (count).
inline void pull_to_wall(const Ring& ring, const Obstacle& o, const double* x, const double* y,
                         double scale, double* fx, double* fy) {
    const double reach = o.radius + adhesion_start(ring) + adhesion_fade(ring);
    for (int i = 0; i < ring.count; ++i) {
        const Vec2 a{x[i] - o.x, y[i] - o.y}, b{x[i + 1] - o.x, y[i + 1] - o.y};
        if (smaller(dot(a, a), dot(b, b)) > reach * reach) continue;
        const EdgeForces f = adhesion_forces(ring, o.radius, a, b);
        const int next = after(ring, i);
        fx[i] += scale * f.start.x;
        fy[i] += scale * f.start.y;
        fx[next] += scale * f.end.x;
        fy[next] += scale * f.end.y;
    }
}

/// Adhesion of the listed droplets to the pillars that they have met.
inline void pull_to_walls(const Scene& scene) {
    for (int c = 0; c < scene.wall_count; ++c) {
        const WallContact& contact = scene.walls[c];
        const Ring& ring = scene.rings[contact.ring];
        if (!(ring.constants.adhesion > 0.0) || !contact.met) continue;
        pull_to_wall(ring, contact.obstacle, ring.x, ring.y, 1.0, ring.push_x, ring.push_y);
        repeat_first(ring, ring.push_x, ring.push_y);
    }
}

/// Nearest point of some edges of a ring to a point, with the side that the point is on.
struct Nearest {
    int edge;         // it lies on the edge from this vertex to the next
    double fraction;  // along that edge
    double distance;  // negative inside the droplet
    Vec2 normal;      // unit vector out of the droplet, along the line to the nearest point
};

/// Normal of the edge that starts at a vertex, out of the droplet: the inside is on its left.
inline Vec2 edge_normal(const Ring& ring, int edge) {
    const Vec2 e{ring.x[edge + 1] - ring.x[edge], ring.y[edge + 1] - ring.y[edge]};
    return (1.0 / std::sqrt(dot(e, e))) * Vec2{e.y, -e.x};
}

/// The nearest point of one edge to a point: how far along the edge, and the way from it.
struct Foot {
    double fraction;
    Vec2 apart;
};

inline Foot foot_on(const Ring& ring, Vec2 r, int edge) {
    const Vec2 a{ring.x[edge], ring.y[edge]}, e = Vec2{ring.x[edge + 1], ring.y[edge + 1]} - a;
    const double t = smaller(larger(dot(r - a, e) / dot(e, e), 0.0), 1.0);
    return {t, r - (a + t * e)};
}

/// Square of the distance from a point to one edge.
inline double edge_distance2(const Ring& ring, Vec2 r, int edge) {
    const Vec2 apart = foot_on(ring, r, edge).apart;
    return dot(apart, apart);
}

inline Nearest nearest_edge(const Ring& ring, Vec2 r, int first, int count) {
    int edge = first;
    double fraction = 0.0, least2 = 1e300;
    Vec2 off{0.0, 0.0};
    for (int n = 0, k = first; n < count; ++n, k = after(ring, k)) {
        const Foot foot = foot_on(ring, r, k);
        if (dot(foot.apart, foot.apart) < least2) {
            least2 = dot(foot.apart, foot.apart);
            edge = k;
            fraction = foot.fraction;
            off = foot.apart;
        }
    }
    // At a corner the side is told by both edges: past a sharp one, either alone may be wrong.
    Vec2 outward = edge_normal(ring, edge);
    if (fraction == 0.0) outward = outward + edge_normal(ring, before(ring, edge));
    if (fraction == 1.0) outward = outward + edge_normal(ring, after(ring, edge));
    const double side = dot(off, outward) < 0.0 ? -1.0 : 1.0, distance = std::sqrt(least2);
    // On the outline itself the direction of `off` is lost in round-off.
    const bool on_outline = distance < 1e-12;
    const Vec2 normal =
        on_outline ? 1.0 / std::sqrt(dot(outward, outward)) * outward : side / distance * off;
    return {edge, fraction, side * distance, normal};
}

/// How a vertex of ring a and an edge of ring b repel: the potential of the wall, with another
/// length in place of l_eq and another stiffness.
struct Touch {
    double length, stiffness;
};

/// Between droplets: their mean vertex spacing and γ times it, so that a vertex on the other's
/// outline is pushed with 2γ, more than line tension and pressure press it there with, yet so
/// gently that the two halves of a cut, which start in touch, do not jolt apart. Between two sides
/// of one droplet, which meet only where it has thinned far below any neck: as hard as the wall.
inline Touch touch_of(const Ring& a, const Ring& b) {
    if (&a == &b) return {a.rest_length, a.wall_stiffness};
    return {0.5 * (a.rest_length + b.rest_length),
            0.5 * (a.constants.line_tension * a.rest_length +
                   b.constants.line_tension * b.rest_length)};
}

/// Force on a vertex of ring a from the nearest point of ring b. Another droplet is pushed out of,
/// one's own far side is pushed away from, on whichever side of it the vertex is.
inline Vec2 touch_force(const Ring& a, const Ring& b, const Nearest& near) {
    const Touch touch = touch_of(a, b);
    if (&a != &b) return contact_force(near.distance, touch.length, touch.stiffness) * near.normal;
    const double f = contact_force(std::fabs(near.distance), touch.length, touch.stiffness);
    return (near.distance < 0.0 ? -f : f) * near.normal;
}

/// Where the vertex of a contact is in the frame of the other droplet, whose image it touches.
inline Vec2 vertex_seen_by(const Scene& scene, const DropletContact& touch) {
    const Ring& a = scene.rings[touch.ring];
    return displacement({touch.image_x, touch.image_y}, {a.x[touch.vertex], a.y[touch.vertex]});
}

/// Repulsion of the listed vertices from other droplets and from the far side of their own, with
/// the reaction on the edge's two ends. The only scatter there is: few vertices touch, and the
/// list's order fixes the order of the sums.
inline void push_droplets_apart(const Scene& scene) {
    for (int c = 0; c < scene.touch_count; ++c) {
        const DropletContact& touch = scene.touches[c];
        const Ring& a = scene.rings[touch.ring];
        const Ring& b = scene.rings[touch.other];
        const Nearest near =
            nearest_edge(b, vertex_seen_by(scene, touch), touch.first_edge, touch.edge_count);
        const Vec2 f = touch_force(a, b, near);
        const int next = after(b, near.edge);
        a.push_x[touch.vertex] += f.x;
        a.push_y[touch.vertex] += f.y;
        b.push_x[near.edge] -= (1.0 - near.fraction) * f.x;
        b.push_y[near.edge] -= (1.0 - near.fraction) * f.y;
        b.push_x[next] -= near.fraction * f.x;
        b.push_y[next] -= near.fraction * f.y;
    }
}

/// Contact forces of this instant into push_x, push_y of the rings that take part.
inline void push_contacts(const Scene& scene) {
    for (int r = 0; r < scene.ring_count; ++r) {
        const Ring& ring = scene.rings[r];
        if (!ring.pushed) continue;
        std::fill_n(ring.push_x, ring.padded, 0.0);
        std::fill_n(ring.push_y, ring.padded, 0.0);
    }
    push_from_walls(scene);
    pull_to_walls(scene);
    push_droplets_apart(scene);
}

/// `steps` steps of every ring, whose relaxation is set for this time step.
inline void advance(const Scene& scene, double time_step, int steps) {
    with_flow(scene.flow, [&](const auto& flow) {
        for (int n = 0; n < steps; ++n) {
            push_contacts(scene);
            for (int r = 0; r < scene.ring_count; ++r) {
                const Ring& ring = scene.rings[r];
                if (ring.pushed) kick<true, true>(ring, flow, {ring.kept, ring.replaced});
                else kick<false, true>(ring, flow, {ring.kept, ring.replaced});
            }
            for (int r = 0; r < scene.ring_count; ++r) drift(scene.rings[r], time_step);
        }
    });
}

/// Carry the velocities of each ring over its `shift` with the forces of the present positions,
/// which stay: half a step forward gives them at the time of the positions, half a step back
/// prepares the next step.
inline void shift_velocities(const Scene& scene) {
    with_flow(scene.flow, [&](const auto& flow) {
        push_contacts(scene);
        for (int r = 0; r < scene.ring_count; ++r) {
            const Ring& ring = scene.rings[r];
            const Relaxation relax = relaxation(ring.drag_rate, ring.shift);
            if (ring.pushed) kick<true, false>(ring, flow, relax);
            else kick<false, false>(ring, flow, relax);
        }
    });
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
