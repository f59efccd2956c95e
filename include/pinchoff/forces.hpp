// The terms of the energy and of the drag, each once: a force beside the energy it derives from.
// Units D0, v_f∞ and M; energies in M v_f∞², forces in M v_f∞²/D0. Below the terms stand the sums
// of them that the time step takes, and the same term by term, for reports and tests: what is in
// one must be in the other. A new term needs no other place in the engine than this file.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "math.hpp"

namespace pinchoff::inline PINCHOFF_ARCH {

/// Area energy k_a/2 (A - A_eq)² [paper, eq. shape, first term].
PINCHOFF_HD inline double area_energy(double area, double rest_area, double stiffness) {
    return 0.5 * stiffness * (area - rest_area) * (area - rest_area);
}

/// Pressure in the droplet, -dU/dA of the area energy.
PINCHOFF_HD inline double pressure(double area, double rest_area, double stiffness) {
    return stiffness * (rest_area - area);
}

/// Force of the pressure on a vertex of a counter-clockwise polygon: p dA/dr, where dA/dr depends
/// on the two neighbours only.
PINCHOFF_HD inline Vec2 pressure_force(Vec2 before, Vec2 after, double p) {
    return {0.5 * p * (after.y - before.y), 0.5 * p * (before.x - after.x)};
}

/// Edge energy k_l N_v/2 (l - l_eq)² of one edge [paper, eq. shape, second term]; spring = k_l N_v.
PINCHOFF_HD inline double edge_energy(double length, double rest_length, double spring) {
    return 0.5 * spring * (length - rest_length) * (length - rest_length);
}

/// Tension of that spring divided by the edge's length, so that the pull is this times the edge.
PINCHOFF_HD inline double edge_pull(double inverse_length, double rest_length, double spring) {
    return spring * (1.0 - rest_length * inverse_length);
}

/// Line-tension energy γ_2D l of one edge [paper, eq. for U_γ].
PINCHOFF_HD inline double line_tension_energy(double length, double line_tension) {
    return line_tension * length;
}

/// Tension γ_2D divided by the edge's length.
PINCHOFF_HD inline double line_tension_pull(double inverse_length, double line_tension) {
    return line_tension * inverse_length;
}

/// Repulsion ε/2 (1 - 2d/l_eq)² at distance d < l_eq/2 from a surface [paper, eq. for U_w].
PINCHOFF_HD inline double contact_energy(double distance, double rest_length, double stiffness) {
    const double overlap = 1.0 - 2.0 * distance / rest_length;
    return overlap > 0.0 ? 0.5 * stiffness * overlap * overlap : 0.0;
}

/// Force of that repulsion along the outward normal of the surface.
PINCHOFF_HD inline double contact_force(double distance, double rest_length, double stiffness) {
    const double overlap = 1.0 - 2.0 * distance / rest_length;
    return overlap > 0.0 ? 2.0 * stiffness / rest_length * overlap : 0.0;
}

/// Where a ring's adhesion to a wall begins to fade, as a distance from it: where the wall no
/// longer repels.
PINCHOFF_HD inline double adhesion_start(const Ring& ring) {
    return ring.constants.front_tracking != 0.0 ? 0.0 : 0.5 * ring.rest_length;
}

/// Over how long a way it fades, in vertex spacings. Front tracking keeps its edges even round the
/// corner at a pillar too, and needs more of them there: with one, 60° come out as 74°.
inline constexpr double kAdhesionFade = 1.0, kFrontAdhesionFade = 4.0;

PINCHOFF_HD inline double adhesion_fade(const Ring& ring) {
    const bool front = ring.constants.front_tracking != 0.0;
    return (front ? kFrontAdhesionFade : kAdhesionFade) * ring.rest_length;
}

/// How much of an edge adheres, from the distances of its two ends, and the slopes with them.
struct Wetted {
    double part, by_start, by_end;
};

/// The mean along the edge of what fades smoothly from 1 to 0, by Gauss's rule of three points:
/// from the middle alone, the outline would stick to its vertices.
PINCHOFF_HD inline Wetted wetted(const Ring& ring, double first, double second) {
    constexpr double kPlaces[] = {0.1127016653792583, 0.5, 0.8872983346207417};
    constexpr double kWeights[] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    const double start = adhesion_start(ring), inverse = 1.0 / adhesion_fade(ring);
    Wetted sum{0.0, 0.0, 0.0};
    for (int k = 0; k < 3; ++k) {
        const double distance = first + kPlaces[k] * (second - first);
        const double s = smaller(larger(inverse * (distance - start), 0.0), 1.0);
        const double slope = -6.0 * kWeights[k] * inverse * s * (1.0 - s);
        sum.part += kWeights[k] * (1.0 - s * s * (3.0 - 2.0 * s));
        sum.by_start += (1.0 - kPlaces[k]) * slope;
        sum.by_end += kPlaces[k] * slope;
    }
    return sum;
}

/// Adhesion energy -W l of an edge that lies on a pillar, W = γ_2D (1 + cos θ): with its line
/// tension it then costs -γ_2D cos θ a length, as Young's equation has it. l is the edge's length
/// round the pillar, so that one that goes back along the wall takes back what the first has
/// gained: below 90° an outline would else fold itself up there. Ends relative to the pillar's
/// centre.
PINCHOFF_HD inline double adhesion_energy(const Ring& ring, double radius, Vec2 a, Vec2 b) {
    const double far_a = std::sqrt(dot(a, a)), far_b = std::sqrt(dot(b, b));
    const double part = wetted(ring, far_a - radius, far_b - radius).part;
    return ring.constants.adhesion * part * cross(a, b) / (0.5 * (far_a + far_b));
}

/// Forces of that energy on the two ends of the edge.
struct EdgeForces {
    Vec2 start, end;
};

PINCHOFF_HD inline EdgeForces adhesion_forces(const Ring& ring, double radius, Vec2 a, Vec2 b) {
    const double far_a = std::sqrt(dot(a, a)), far_b = std::sqrt(dot(b, b)),
                 inverse = 1.0 / (0.5 * (far_a + far_b));
    const Wetted wet = wetted(ring, far_a - radius, far_b - radius);
    const double round = ring.constants.adhesion * inverse, along = round * wet.part,
                 across = round * cross(a, b), shrink = 0.5 * inverse * wet.part;
    return {Vec2{-along * b.y, along * b.x} - across * (wet.by_start - shrink) / far_a * a,
            Vec2{along * a.y, -along * a.x} - across * (wet.by_end - shrink) / far_b * b};
}

/// Every term of one droplet's energy.
#define PINCHOFF_TERMS(TERM) \
    TERM(area)               \
    TERM(edges)              \
    TERM(line_tension)       \
    TERM(wall)               \
    TERM(adhesion)

/// Something of each term.
template <class T>
struct Terms {
#define PINCHOFF_DECLARE(name) T name{};
    PINCHOFF_TERMS(PINCHOFF_DECLARE)
#undef PINCHOFF_DECLARE
};

/// What the terms pull an edge's two ends together with, divided by its length.
PINCHOFF_HD inline double edge_pulls(const Ring& ring, double inverse_length) {
    return line_tension_pull(inverse_length, ring.constants.line_tension) +
           edge_pull(inverse_length, ring.rest_length, ring.edge_spring);
}

/// Force on a vertex between two others, beside the pulls of its edges and what it touches.
PINCHOFF_HD inline Vec2 vertex_force([[maybe_unused]] const Ring& ring, Vec2 before,
                                     [[maybe_unused]] Vec2 here, Vec2 after, double p) {
    return pressure_force(before, after, p);
}

/// Adds the energies of a vertex and of the edge from it to the next; that of the area comes once a
/// droplet.
inline void add_vertex_energies(Terms<double>& sum, const Ring& ring, Vec2 here, Vec2 after,
                                std::span<const Obstacle> obstacles) {
    const Vec2 e = after - here;
    const double length = std::sqrt(dot(e, e));
    sum.edges += edge_energy(length, ring.rest_length, ring.edge_spring);
    sum.line_tension += line_tension_energy(length, ring.constants.line_tension);
    for (const Obstacle& o : obstacles) {
        const Vec2 from = here - Vec2{o.x, o.y};
        sum.wall += contact_energy(std::sqrt(dot(from, from)) - o.radius, ring.rest_length,
                                   ring.wall_stiffness);
        sum.adhesion += adhesion_energy(ring, o.radius, from, after - Vec2{o.x, o.y});
    }
}

/// Forces on a vertex between two others.
inline Terms<Vec2> vertex_forces(const Ring& ring, Vec2 before, Vec2 here, Vec2 after, double p,
                                 std::span<const Obstacle> obstacles) {
    const Vec2 in = here - before, out = after - here;
    const double in_inverse = 1.0 / std::sqrt(dot(in, in)),
                 out_inverse = 1.0 / std::sqrt(dot(out, out));
    const double gamma = ring.constants.line_tension;
    Terms<Vec2> f;
    f.area = pressure_force(before, after, p);
    f.edges = edge_pull(out_inverse, ring.rest_length, ring.edge_spring) * out -
              edge_pull(in_inverse, ring.rest_length, ring.edge_spring) * in;
    f.line_tension =
        line_tension_pull(out_inverse, gamma) * out - line_tension_pull(in_inverse, gamma) * in;
    for (const Obstacle& o : obstacles) {
        const Vec2 from = here - Vec2{o.x, o.y};
        const double distance = std::sqrt(dot(from, from));
        f.wall =
            f.wall + contact_force(distance - o.radius, ring.rest_length, ring.wall_stiffness) /
                         distance * from;
        const Vec2 centre{o.x, o.y};
        f.adhesion = f.adhesion + adhesion_forces(ring, o.radius, before - centre, from).end +
                     adhesion_forces(ring, o.radius, from, after - centre).start;
    }
    return f;
}

/// What drag at rate ζ leaves of a velocity after a time, e^(-ζ t), and what it has replaced, 1
/// minus that. A negative time undoes it; bounded where the number would overflow and drag forgets
/// it.
struct Relaxation {
    double kept, replaced;
};

inline Relaxation relaxation(double drag_rate, double time) {
    const double exponent = -std::max(drag_rate * time, -300.0);
    return {std::exp(exponent), -std::expm1(exponent)};
}

/// Velocity after a time over which drag and a constant force act [paper, eq. drag_force and eq. of
/// motion]: it relaxes towards v_f + F N_v/(μ D0), exactly.
PINCHOFF_HD inline Vec2 relax_velocity(Vec2 velocity, Vec2 fluid, Vec2 force, double mobility,
                                       Relaxation r) {
    return {r.kept * velocity.x + r.replaced * (fluid.x + mobility * force.x),
            r.kept * velocity.y + r.replaced * (fluid.y + mobility * force.y)};
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
