// Energies and forces of one droplet, term by term, from the same functions as the time step; for
// reports and tests. The step itself sums the terms in one pass (step.hpp).
#pragma once

#include <cmath>
#include <vector>

#include "droplet.hpp"

namespace pinchoff {

/// Energy term by term, in M v_f∞²: of the droplets, and of their contacts with each other.
struct Energies {
    Terms<double> own;
    double contact = 0;
};

/// Adds the energies of one droplet, U = U_s + U_w [paper, eqs. shape, U_γ, U_w, U].
inline void add_energies(Energies& sum, const Droplet& droplet,
                         const std::vector<Obstacle>& obstacles) {
    const Ring& ring = droplet.ring;
    const std::vector<Vec2> r = droplet.positions();
    sum.own.area += area_energy(signed_area(r), ring.rest_area, ring.area_stiffness);
    for (int i = 0; i < ring.count; ++i)
        add_vertex_energies(sum.own, ring, r[i], next_vertex(r, i), obstacles);
}

/// Forces of one droplet's own terms on each of its vertices, in M v_f∞²/D0.
inline std::vector<Terms<Vec2>> term_forces(const Droplet& droplet,
                                            const std::vector<Obstacle>& obstacles) {
    const Ring& ring = droplet.ring;
    const std::vector<Vec2> r = droplet.positions();
    const int n = ring.count;
    const double p = pressure(signed_area(r), ring.rest_area, ring.area_stiffness);
    std::vector<Terms<Vec2>> forces;
    for (int i = 0; i < n; ++i)
        forces.push_back(
            vertex_forces(ring, r[(i + n - 1) % n], r[i], r[(i + 1) % n], p, obstacles));
    return forces;
}

}  // namespace pinchoff
