// Bindings of rays across borders in pictures: shapes and types, nothing else.
#include "pinchoff/rays.hpp"

#include "bindings.hpp"

namespace pinchoff {

using Line = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<nb::numpy, bool, nb::ndim<1>>;

static Flags flags_of(const std::vector<char>& values) {
    bool* copy = new bool[values.size()];
    std::copy(values.begin(), values.end(), copy);
    nb::capsule owner(copy, [](void* p) noexcept { delete[] static_cast<bool*>(p); });
    return Flags(copy, {values.size()}, owner);
}

static Picture picture_of(Rows rows) {
    return {rows.data(), static_cast<std::ptrdiff_t>(rows.shape(0)),
            static_cast<std::ptrdiff_t>(rows.shape(1))};
}

static std::vector<Ray> rays_of(Points points, Points normals, double from, double step) {
    if (normals.shape(0) != points.shape(0))
        throw nb::value_error(
            "normals must have one row for each point; got another number; give one a point");
    std::vector<Ray> rays(points.shape(0));
    for (std::size_t k = 0; k < rays.size(); ++k) {
        const double *p = points.data() + 2 * k, *n = normals.data() + 2 * k;
        rays[k] = {{p[0] + from * n[0], p[1] + from * n[1]}, {step * n[0], step * n[1]}};
    }
    return rays;
}

void bind_rays(nb::module_& m) {
    m.def(
        "region_border",
        [](Points line, double spacing, int fewest, int most, double smoothing, double margin,
           Pair size) {
            const RegionBorder b =
                region_border(points_of(line), {spacing, fewest, most, smoothing, margin},
                              size.first, size.second);
            return std::tuple(array_of(b.points), array_of(b.normals), flags_of(b.at_edge));
        },
        "line"_a, "spacing"_a, "fewest"_a, "most"_a, "smoothing"_a, "margin"_a, "size"_a,
        "Points spaced evenly round an (n, 2) line, smoothed, with outward normals, and which are "
        "within `margin` of the edge\nof a frame of some (width, height); (0, 0): of none.");
    m.def(
        "running_median",
        [](Line values, int reach) {
            return array_of(running_median({values.data(), values.data() + values.size()}, reach));
        },
        "values"_a, "reach"_a,
        "Values round a closed line, (n,), each the median of those as far as `reach` on either "
        "side.");
    m.def(
        "rim_ends",
        [](Rows dark, Points points, Points normals, double from, double step, int samples,
           double level, double edge, int inside, int beyond) {
            const Picture picture = picture_of(dark);
            const RimRule rule{static_cast<float>(level), static_cast<float>(edge),
                               static_cast<std::size_t>(inside), static_cast<std::size_t>(beyond),
                               static_cast<std::size_t>(samples)};
            const std::vector<Ray> rays = rays_of(points, normals, from, step);
            std::vector<double> places, contrasts;
            std::vector<float> profile;
            for (const Ray& ray : rays) {
                const RimEnd end = rim_end(picture, ray, rule, profile);
                places.push_back(from + step * end.place);
                contrasts.push_back(static_cast<double>(end.peak - end.first));
            }
            return std::pair(array_of(places), array_of(contrasts));
        },
        "dark"_a, "points"_a, "normals"_a, "start"_a, "step"_a, "samples"_a, "level"_a, "edge"_a,
        "inside"_a, "beyond"_a,
        "How far from (n, 2) points dark rims end along rays, NaN where they do not; and how much "
        "darker they get than where\nthe ray begins, `start` from the point.");
    m.def(
        "spot_edges",
        [](Rows dark, Points points, Points normals, double reach, double step, double beyond) {
            const Picture picture = picture_of(dark);
            const auto samples = static_cast<std::size_t>((2.0 * reach + 1e-6) / step) + 1;
            const SpotRule rule{samples, std::max<std::size_t>(1, samples / 4),
                                static_cast<std::size_t>(std::ceil((beyond + reach) / step)),
                                reach / step};
            std::vector<double> values;
            std::vector<float> profile;
            for (const Ray& ray : rays_of(points, normals, -reach, step)) {
                const SpotEdge edge = spot_edge(picture, ray, rule, profile);
                values.insert(values.end(), {edge.inner - edge.outer, edge.beyond,
                                             edge.steepest / step, step * edge.place - reach});
            }
            return matrix_of(values.data(), points.shape(0), 4);
        },
        "dark"_a, "points"_a, "normals"_a, "reach"_a, "step"_a, "beyond"_a,
        "Of rays across the edge of a dark spot, `reach` to both sides of (n, 2) points, (n, 4): "
        "how much darker it is within\nthan outside, the darkness at `beyond`, the steepest "
        "change, and where it is halfway (NaN: nowhere).");
}

}  // namespace pinchoff
