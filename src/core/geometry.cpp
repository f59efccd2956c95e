// Bindings of the geometry of one outline: shapes and types, no physics.
#include "bindings.hpp"

#include "pinchoff/split.hpp"
#include "pinchoff/survey.hpp"

namespace pinchoff {

static std::vector<Vec2> outline_of(Points points) {
    if (points.shape(0) < 3)
        throw nb::value_error(
            "outline must have at least 3 vertices; got fewer; give an (n, 2) array");
    return points_of(points);
}

/// Vertices in counter-clockwise order, in which every function here takes them.
static std::vector<Vec2> counter_clockwise(Points points) {
    std::vector<Vec2> r = outline_of(points);
    if (signed_area(r) < 0) std::reverse(r.begin(), r.end());
    return r;
}

/// The outline itself, or its mirror image where its vertices run clockwise: the vertices keep
/// their numbers.
static std::vector<Vec2> mirrored_counter_clockwise(Points points) {
    std::vector<Vec2> r = outline_of(points);
    if (signed_area(r) < 0)
        for (Vec2& p : r) p.y = -p.y;
    return r;
}

/// Coordinates with the first vertex repeated at the end, as the kernels want them.
static std::pair<std::vector<double>, std::vector<double>> closed_columns(
    const std::vector<Vec2>& r) {
    std::vector<double> x, y;
    for (std::size_t i = 0; i <= r.size(); ++i) {
        x.push_back(r[i % r.size()].x);
        y.push_back(r[i % r.size()].y);
    }
    return {x, y};
}

void bind_geometry(nb::module_& m) {
    m.def(
        "area", [](Points r) { return std::fabs(signed_area(outline_of(r))); }, "outline"_a,
        "Area enclosed by an (n, 2) outline, in its unit squared.");
    m.def(
        "perimeter", [](Points r) { return perimeter(outline_of(r)); }, "outline"_a,
        "Length of a closed (n, 2) outline, in its unit.");
    m.def(
        "centroid",
        [](Points r) {
            const Vec2 c = centroid(outline_of(r));
            return std::pair(c.x, c.y);
        },
        "outline"_a, "Centre of mass (x, y) of the area inside an (n, 2) outline [appendix B].");
    m.def(
        "distance", [](Points r, Pair point) { return distance_to(outline_of(r), vec(point)); },
        "outline"_a, "point"_a, "Least distance of the edges of an (n, 2) outline from a point.");
    m.def(
        "shape_parameter", [](Points r) { return shape_parameter(outline_of(r)); }, "outline"_a,
        "P²/(4πA) of an (n, 2) outline, 1 for a circle [appendix B].");
    m.def(
        "centroid_velocity",
        [](Points r, Points v) {
            if (v.shape(0) != r.shape(0))
                throw nb::value_error(
                    "velocities must have one row for each vertex; got another number; "
                    "give an array shaped like the outline");
            const Vec2 c = centroid_velocity(outline_of(r), points_of(v));
            return std::pair(c.x, c.y);
        },
        "outline"_a, "velocities"_a,
        "Velocity (vx, vy) of the centre of mass of an (n, 2) outline whose vertices move with (n, "
        "2) velocities.");
    m.def(
        "symmetry",
        [](Points r, Pair point, Pair direction) {
            return symmetry(counter_clockwise(r), vec(point), vec(direction));
        },
        "outline"_a, "point"_a, "direction"_a,
        "S = 1 - (A_large - A_small)/A of an (n, 2) outline about the line through `point` along "
        "`direction` [eq. symdef].");
    m.def(
        "impact_parameter",
        [](Points r, Pair point, Pair direction) {
            return impact_parameter(outline_of(r), vec(point), vec(direction));
        },
        "outline"_a, "point"_a, "direction"_a,
        "Distance of an (n, 2) outline's centre of mass from the line through `point` along "
        "`direction` [eq. for b].");
    m.def(
        "neck",
        [](Points r, double separation, bool in_diameters, double diameter) {
            const Neck n = find_neck(mirrored_counter_clockwise(r),
                                     in_diameters ? Separation{0.0, separation * diameter}
                                                  : Separation{separation, 0.0});
            return std::tuple(n.thickness, n.first, n.second);
        },
        "outline"_a, "separation"_a = 0.28, "in_diameters"_a = false, "diameter"_a = 1.0,
        "Thinnest chord inside an (n, 2) outline whose shorter arc exceeds `separation`, a "
        "fraction of "
        "the perimeter or,\n"
        "`in_diameters`, a length in units of `diameter`: (thickness, i, j), or (inf, -1, -1) "
        "where no pair qualifies.");
    m.def(
        "cut",
        [](Points r, int i, int j, int first_count, int second_count) {
            const std::vector<Vec2> whole = counter_clockwise(r);
            const int n = static_cast<int>(whole.size());
            if (first_count < 3 || second_count < 3)
                throw nb::value_error(
                    "first_count and second_count must be at least 3; got less; give numbers of "
                    "vertices");
            if (!(0 <= i && i < j - 1 && j < n && j - i < n - 1))
                throw nb::value_error(
                    "i and j must be indices of two vertices that are not neighbours, i < j; got "
                    "others; use those of neck()");
            const auto [one, two] = cut({whole, whole}, {{i, 0.0}, {j, 0.0}});
            return std::pair(array_of(respace(one, first_count).r),
                             array_of(respace(two, second_count).r));
        },
        "outline"_a, "i"_a, "j"_a, "first_count"_a, "second_count"_a,
        "The two parts of a counter-clockwise (n, 2) outline on the sides of its chord from i to "
        "j, each re-spaced to a\n"
        "number of vertices with its area and centre kept.");
    m.def(
        "self_intersects",
        [](Points r) {
            const auto [x, y] = closed_columns(outline_of(r));
            return best_kernels().self_intersects(x.data(), y.data(), static_cast<int>(r.shape(0)));
        },
        "outline"_a, "Whether two edges of an (n, 2) outline cross.");
    m.def(
        "scan_neck",
        [](Points points, double separation, bool in_diameters, double threshold) {
            const auto [x, y] = closed_columns(mirrored_counter_clockwise(points));
            const int n = static_cast<int>(points.shape(0));
            std::vector<double> work(neck_work_size(n));
            const NeckScan s = best_kernels().scan_neck(
                x.data(), y.data(), n,
                in_diameters ? Separation{0.0, separation} : Separation{separation, 0.0}, threshold,
                work.data());
            return std::pair(std::sqrt(s.thickness2), s.budget);
        },
        "outline"_a, "separation"_a, "in_diameters"_a, "threshold"_a,
        "The look at the neck between blocks of steps: (thinnest admissible chord, displacement of "
        "the vertices below\n"
        "which none can pass `threshold`). For tests.");
    m.def(
        "natural_log",
        [](nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu> in) {
            std::vector<double> out(in.size());
            best_kernels().natural_log(in.data(), out.data(), static_cast<int>(in.size()));
            return array_of(out);
        },
        "values"_a,
        "The logarithm that the flow uses, of (n,) positive normal numbers. For tests.");
}

}  // namespace pinchoff
