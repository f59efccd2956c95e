// The energy of a scene, term by term, from the same functions as the forces. For reports and tests.
// Included by collision.hpp, which declares Collision::energies.
#pragma once

namespace pinchoff {

/// Energies of the droplets at their present positions, U = U_s + U_w [paper, eqs. shape and U].
inline Energies Collision::energies() {
    list_contacts();
    Energies sum;
    for (const Droplet& d : droplets_) {
        const Ring& ring = d.ring;
        const std::vector<Vec2> r = d.positions();
        sum.area += area_energy(signed_area(r), ring.rest_area, ring.area_stiffness);
        for (int i = 0; i < ring.count; ++i) {
            const Vec2 e = next_vertex(r, i) - r[i];
            const double length = std::sqrt(dot(e, e));
            sum.edges += edge_energy(length, ring.rest_length, ring.edge_spring);
            sum.line_tension += line_tension_energy(length, ring.line_tension);
            for (const Obstacle& o : obstacles_) {
                const Vec2 from = r[i] - Vec2{o.x, o.y};
                sum.wall += contact_energy(std::sqrt(dot(from, from)) - o.radius, ring.rest_length, ring.wall_stiffness);
            }
        }
    }
    for (const DropletContact& c : lists_.touches) {
        const Ring &a = droplets_[c.ring].ring, &b = droplets_[c.other].ring;
        const Nearest near = nearest_edge(b, {a.x[c.vertex], a.y[c.vertex]}, c.first_edge, c.edge_count);
        sum.touch += contact_energy(near.distance, touch_length(a, b), touch_stiffness(a, b));
    }
    return sum;
}

}  // namespace pinchoff
