// How large a time step may be.
#pragma once

#include <algorithm>
#include <cmath>

#include "droplet.hpp"
#include "front.hpp"

namespace pinchoff {

/// Largest stable step of the leapfrog scheme for an oscillator of squared frequency ω² damped at
/// rate ζ: its characteristic roots stay inside the unit circle while ω² Δt tanh(ζ Δt/2)/ζ < 2,
/// which is ω Δt < 2 without drag and ω² Δt < 2 ζ when drag rules.
inline double stable_step(double omega2, double drag_rate) {
    double low = 2.0 / std::sqrt(omega2);  // tanh(h)/h < 1, so at least this much is stable
    double high = std::max(low, 4.0 * drag_rate / omega2) + low;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        const bool stable = omega2 * middle * std::tanh(0.5 * drag_rate * middle) < 2.0 * drag_rate;
        (stable ? low : high) = middle;
    }
    return low;
}

/// Squared frequencies of the stiffest motion that each term of the energy allows, for vertices of
/// mass m = M/N_v: neighbouring vertices against each other along and across their edge, a vertex
/// against the wall that repels and attracts it, and the whole outline against the area term, k_a
/// |∇A|²/m with |∇A|² = P²/N_v.
struct Stiffness {
    double edges, wall, area;
};

inline Stiffness stiffness(const Ring& ring, double perimeter) {
    const double vertex_mass = ring.mass / ring.count;
    const double l = ring.rest_length;
    return {4.0 * (ring.edge_spring + ring.constants.line_tension / l) / vertex_mass,
            (4.0 * ring.wall_stiffness / (l * l) + 6.0 * ring.constants.adhesion / l) / vertex_mass,
            ring.area_stiffness * perimeter * perimeter / ring.mass};
}

/// Front tracking: part of the stable step that a step takes.
inline constexpr double kFrontStepSafety = 0.8;
/// Front tracking: largest step, t0.
inline constexpr double kLongestFrontStep = 2e-3;

/// Front tracking: the largest stable step. Line tension pulls neighbouring vertices back against
/// each other at the rate 4 N_v γ/(μ D0 l), and the scheme is stable up to a product of one (that
/// of Adams and Bashforth). With P = N_v l that is Δt = Ca_sim l²/(4 P); it grows with the
/// perimeter, so the circle's is the least. Adhesion W adds less than 6 W/l to 4 γ/l.
inline double stable_front_step(const Ring& ring) {
    const double pull = 4.0 * ring.constants.line_tension + 6.0 * ring.constants.adhesion;
    return ring.rest_length / (pull * ring.mobility);
}

/// Front tracking: a step that stays stable.
inline double safe_front_step(const Ring& ring) {
    return kFrontStepSafety * stable_front_step(ring);
}

/// The step above which an undeformed droplet is certain to be unstable.
inline double stable_time_step(const Ring& ring) {
    if (tracks_front(ring)) return safe_front_step(ring);
    const Stiffness s = stiffness(ring, ring.rest_length * ring.count);
    return stable_step(std::max({s.edges, s.wall, s.area}), ring.drag_rate);
}

/// Perimeter, in units of the undeformed one, that a safe step allows for.
inline constexpr double kStretch = 2.0;
/// Part of the stable step that a safe step takes.
inline constexpr double kStepSafety = 0.9;
/// Largest automatic step, in t0: up to here S at the separating line was measured to stay within
/// 0.3 % of its value at Δt = 1e-4 t0.
inline constexpr double kLongestStep = 5e-4;

/// A step that stays stable for a droplet drawn out round an obstacle, all stiffnesses at once.
inline double safe_time_step(const Ring& ring) {
    const Stiffness s = stiffness(ring, kStretch * ring.rest_length * ring.count);
    return kStepSafety * stable_step(s.edges + s.wall + s.area, ring.drag_rate);
}

/// The automatic step: safe, and short enough for S and the outcome.
inline double auto_time_step(const Ring& ring) {
    if (tracks_front(ring)) return std::min(kLongestFrontStep, safe_front_step(ring));
    return std::min(kLongestStep, safe_time_step(ring));
}

}  // namespace pinchoff
