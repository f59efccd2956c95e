// The terms of the energy and of the drag, each once: a force beside the energy it derives from.
// Units D0, v_f∞ and M; energies in M v_f∞², forces in M v_f∞²/D0.
#pragma once

#include <algorithm>
#include <cmath>

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
