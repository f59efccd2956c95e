// Bindings that look into the engine at one instant: forces, energies, lists of contacts, one
// front.
#include "pinchoff/energy.hpp"
#include "pinchoff/island.hpp"
#include "runs.hpp"

namespace pinchoff {

namespace {

/// One droplet of any shape at an instant, for looks at its forces.
Droplet droplet_of(const Model& model, Points positions, Points velocities, double diameter) {
    if (positions.shape(0) < static_cast<std::size_t>(kLeastVertices) ||
        velocities.shape(0) != positions.shape(0))
        throw nb::value_error(
            "positions and velocities must have the same shape (n, 2), n at least 16; got others; "
            "give one row for each vertex");
    return Droplet(model, kReferenceArea * diameter * diameter, points_of(positions),
                   points_of(velocities));
}

nb::dict term_energies(Row model, Points positions, Triples obstacles, double diameter) {
    Energies e;
    add_energies(e, droplet_of(checked_model(model), positions, positions, diameter),
                 obstacles_of(obstacles));
    return dict_of(e);
}

nb::dict term_forces_of(Row model, Points positions, Triples obstacles, double diameter) {
    const std::vector<Terms<Vec2>> forces = term_forces(
        droplet_of(checked_model(model), positions, positions, diameter), obstacles_of(obstacles));
    std::vector<Vec2> one(forces.size());
    nb::dict d;
#define PINCHOFF_PUT(name)                                                   \
    for (std::size_t i = 0; i < forces.size(); ++i) one[i] = forces[i].name; \
    d[#name] = array_of(one);
    PINCHOFF_TERMS(PINCHOFF_PUT)
#undef PINCHOFF_PUT
    return d;
}

/// Acceleration as the time step computes it, forces and drag in one pass: v relaxes towards its
/// final value at rate ζ, so a = ζ (v(τ) - v)/(1 - exp(-ζ τ)) for any τ.
Matrix acceleration(Row row, const FlowObject& flow, Points positions, Points velocities,
                    Triples obstacles, double diameter) {
    const Model model = checked_model(row);
    std::vector<Droplet> one;
    one.push_back(droplet_of(model, positions, velocities, diameter));
    Ring& ring = one[0].ring;
    ring.pushed = true;
    std::vector<WallContact> walls;
    for (const Obstacle& o : obstacles_of(obstacles)) walls.push_back({0, 0, ring.padded, o});
    const Scene scene{&ring,   1, flow.flow, walls.data(), static_cast<int>(walls.size()),
                      nullptr, 0};
    const std::vector<Vec2> before = one[0].velocities();
    const double time = 1.0 / ring.drag_rate;
    ring.shift = time;
    best_kernels().shift_velocities(scene);
    std::vector<Vec2> a = one[0].velocities();
    for (std::size_t i = 0; i < a.size(); ++i)
        a[i] = ring.drag_rate / relaxation(ring.drag_rate, time).replaced * (a[i] - before[i]);
    return array_of(a);
}

/// Front tracking of one outline of any shape, its own area kept.
nb::tuple advance_outline(Row row, const FlowObject& flow, Points positions, Triples obstacles,
                          double time_step, int steps) {
    const Model model = checked_model(row);
    if (!(model.front_tracking != 0.0))
        throw nb::value_error("model must be front-tracking; got another; set model in Parameters");
    const std::vector<Vec2> r = points_of(positions), rest(r.size(), Vec2{0, 0});
    if (r.size() < static_cast<std::size_t>(kLeastVertices))
        throw nb::value_error("positions must have at least 16 rows; got fewer; add vertices");
    std::vector<Droplet> one;
    one.emplace_back(model, signed_area(r), r, rest);
    Ring& ring = one[0].ring;
    std::vector<WallContact> walls;
    for (const Obstacle& o : obstacles_of(obstacles)) walls.push_back({0, 0, ring.padded, o});
    ring.last_wall = static_cast<int>(walls.size());
    const Scene scene{&ring,   1, flow.flow, walls.data(), static_cast<int>(walls.size()),
                      nullptr, 0};
    best_kernels().front_velocities(scene, time_step);
    best_kernels().advance_fronts(scene, time_step, steps);
    const std::vector<Vec2> advanced = one[0].positions();
    best_kernels().front_velocities(scene, time_step);
    return nb::make_tuple(array_of(advanced), array_of(one[0].velocities()));
}

/// For tests: the list of contacts of one droplet's vertices with another droplet's edges.
nb::tuple touches_of(Row row, Points one, Points other, double diameter_one,
                     double diameter_other) {
    const Model model = checked_model(row);
    const Droplet a = droplet_of(model, one, one, diameter_one),
                  b = droplet_of(model, other, other, diameter_other);
    ContactLists lists;
    Survey box_a, box_b;
    best_kernels().survey(a.ring, box_a);
    best_kernels().survey(b.ring, box_b);
    const PairRoom room = list_pair(lists, a.ring, 0, box_a.box, b.ring, 1, box_b.box, Vec2{0, 0});
    nb::list list;
    for (const DropletContact& c : lists.touches)
        list.append(nb::make_tuple(c.vertex, c.first_edge, c.edge_count));
    return nb::make_tuple(room.allowed, room.depth, list);
}

/// For tests: all contacts that an island lists, and how far its vertices may then move.
nb::tuple contact_lists(Row row, const std::vector<Points>& outlines, Triples obstacles,
                        double period_x, double period_y, bool exhaustive) {
    const Model model = checked_model(row);
    World world{model, uniform_flow(0.0, 0.0),
                ObstacleGrid(obstacles_of(obstacles), {period_x, period_y}), best_kernels(),
                Period{period_x, period_y}};
    world.retires = true;  // no guard ends it
    world.exhaustive = exhaustive;
    Island island(world);
    for (const Points& outline : outlines) {
        const std::vector<Vec2> r = points_of(outline);
        Droplet d(model, signed_area(r), r, std::vector<Vec2>(r.size(), Vec2{0, 0}));
        for (int o = 0; o < static_cast<int>(world.obstacles.obstacles().size()); ++o) d.meet(o);
        island.add(std::move(d));
    }
    island.begin(0.0);
    nb::list walls, touches;
    for (const WallContact& c : island.seen().lists.walls)
        walls.append(nb::make_tuple(c.ring, c.first, c.last, c.obstacle.x, c.obstacle.y));
    for (const DropletContact& c : island.seen().lists.touches)
        touches.append(nb::make_tuple(c.ring, c.vertex, c.other, c.first_edge, c.edge_count,
                                      c.image_x, c.image_y));
    return nb::make_tuple(walls, touches);
}

/// For tests: the list of one droplet's vertices that may feel an obstacle which it has met.
nb::tuple wall_vertices(Row row, Points outline, double x, double y, double radius) {
    const Droplet d = droplet_of(checked_model(row), outline, outline, 1.0);
    Look look;
    const Obstacle obstacle{x, y, radius};
    const Nearby near = look_nearby(look, best_kernels(), d.ring, 0, obstacle, 0);
    const double room =
        list_wall(look.lists, d, 0, obstacle, true, look.distance2.data() + near.chunks);
    nb::list list;
    for (const WallContact& c : look.lists.walls) list.append(nb::make_tuple(c.first, c.last));
    return nb::make_tuple(room, list);
}

}  // namespace

void bind_inspection(nb::module_& m) {
    m.def("term_energies", &term_energies, "model"_a, "positions"_a, "obstacles"_a,
          "diameter"_a = 1.0, "Energy by term of one droplet of any shape (n, 2), in M v_f∞².");
    m.def("term_forces", &term_forces_of, "model"_a, "positions"_a, "obstacles"_a,
          "diameter"_a = 1.0,
          "Force by term on every vertex (n, 2) of one droplet of any shape, in M v_f∞²/D0.");
    m.def("acceleration", &acceleration, "model"_a, "flow"_a, "positions"_a, "velocities"_a,
          "obstacles"_a, "diameter"_a = 1.0,
          "Acceleration (n, 2) of the vertices as the time step computes it, drag included.");

    m.def("touches", &touches_of, "model"_a, "one"_a, "other"_a, "diameter_one"_a = 1.0,
          "diameter_other"_a = 1.0,
          "Contacts that the engine lists between the vertices of one droplet (n, 2) and the edges "
          "of another (m, 2):\n"
          "(displacement of all vertices below which the list stays complete, depth, list of "
          "(vertex, first edge, edges)).\nFor tests.");
    m.def("contact_lists", &contact_lists, "model"_a, "outlines"_a, "obstacles"_a,
          "period_x"_a = 0.0, "period_y"_a = 0.0, "exhaustive"_a = false,
          "All contacts that the engine lists among droplets (n, 2) that have met the obstacles "
          "(M, 3):\n"
          "(walls (droplet, first, last + 1, x, y), touches (droplet, vertex, other, first edge, "
          "edges, image x, image y)).\n"
          "exhaustive: everybody is compared with everybody. For tests.");
    m.def("wall_vertices", &wall_vertices, "model"_a, "outline"_a, "x"_a, "y"_a, "radius"_a,
          "Vertices of a droplet (n, 2) that the engine lists as near an obstacle: (displacement "
          "below which the list\n"
          "stays complete, list of (first, last + 1)). For tests.");

    m.def(
        "advance_front", &advance_outline, "model"_a, "flow"_a, "positions"_a, "obstacles"_a,
        "time_step"_a, "steps"_a,
        "Front tracking: positions and velocities (n, 2) of one outline (n, 2) of any shape after "
        "`steps` steps among obstacles,\n"
        "its area kept.");
}

}  // namespace pinchoff
