// Energies and forces of one droplet, term by term, from the same functions as the time step; for
// reports and tests. The step itself sums the terms in one pass (step.hpp).
#pragma once

#include <cmath>
#include <vector>

#include "droplet.hpp"

namespace pinchoff {

/// Energy term by term, in M v_f∞².
struct Energies {
    double area = 0, edges = 0, line_tension = 0, wall = 0, touch = 0;
};

/// Force on every vertex term by term, in M v_f∞²/D0.
struct TermForces {
    std::vector<Vec2> area, edges, line_tension, wall;
};

/// Adds the energies of one droplet, U = U_s + U_w [paper, eqs. shape, U_γ, U_w, U].
inline void add_energies(Energies& sum, const Droplet& droplet,
                         const std::vector<Obstacle>& obstacles) {
    const Ring& ring = droplet.ring;
    const std::vector<Vec2> r = droplet.positions();
    sum.area += area_energy(signed_area(r), ring.rest_area, ring.area_stiffness);
    for (int i = 0; i < ring.count; ++i) {
        const Vec2 e = next_vertex(r, i) - r[i];
        const double length = std::sqrt(dot(e, e));
        sum.edges += edge_energy(length, ring.rest_length, ring.edge_spring);
        sum.line_tension += line_tension_energy(length, ring.line_tension);
        for (const Obstacle& o : obstacles) {
            const Vec2 from = r[i] - Vec2{o.x, o.y};
            sum.wall += contact_energy(std::sqrt(dot(from, from)) - o.radius, ring.rest_length,
                                       ring.wall_stiffness);
        }
    }
}

/// Forces of one droplet's own terms on its vertices.
inline TermForces term_forces(const Droplet& droplet, const std::vector<Obstacle>& obstacles) {
    const Ring& ring = droplet.ring;
    const std::vector<Vec2> r = droplet.positions();
    const int n = ring.count;
    const double p = pressure(signed_area(r), ring.rest_area, ring.area_stiffness);
    TermForces f;
    for (int i = 0; i < n; ++i) {
        const Vec2 before = r[(i + n - 1) % n], here = r[i], after = r[(i + 1) % n];
        const Vec2 in = here - before, out = after - here;
        const double in_inverse = 1.0 / std::sqrt(dot(in, in)),
                     out_inverse = 1.0 / std::sqrt(dot(out, out));
        f.area.push_back(pressure_force(before, after, p));
        f.edges.push_back(edge_pull(out_inverse, ring.rest_length, ring.edge_spring) * out -
                          edge_pull(in_inverse, ring.rest_length, ring.edge_spring) * in);
        f.line_tension.push_back(line_tension_pull(out_inverse, ring.line_tension) * out -
                                 line_tension_pull(in_inverse, ring.line_tension) * in);
        Vec2 wall{0, 0};
        for (const Obstacle& o : obstacles) {
            const Vec2 from = here - Vec2{o.x, o.y};
            const double distance = std::sqrt(dot(from, from));
            wall =
                wall + contact_force(distance - o.radius, ring.rest_length, ring.wall_stiffness) /
                           distance * from;
        }
        f.wall.push_back(wall);
    }
    return f;
}

}  // namespace pinchoff
