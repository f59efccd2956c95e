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
        [](Rows profiles, double level, double edge, int inside, int beyond) {
            std::vector<double> places(profiles.shape(0)), peaks(places.size());
            for (std::size_t k = 0; k < places.size(); ++k) {
                const RimEnd end =
                    rim_end(profiles.data() + k * profiles.shape(1), profiles.shape(1),
                            static_cast<float>(level), static_cast<float>(edge), inside, beyond);
                places[k] = end.place;
                peaks[k] = end.peak;
            }
            return std::pair(array_of(places), array_of(peaks));
        },
        "profiles"_a, "level"_a, "edge"_a, "inside"_a, "beyond"_a,
        "Where dark rims end along (n, m) profiles, samples from the first, NaN where they do "
        "not; and their darkness.");
    m.def(
        "spot_edges",
        [](Rows profiles, int ends, double middle) {
            std::vector<double> values;
            values.reserve(4 * profiles.shape(0));
            for (std::size_t k = 0; k < profiles.shape(0); ++k) {
                const SpotEdge edge = spot_edge(profiles.data() + k * profiles.shape(1),
                                                profiles.shape(1), ends, middle);
                values.insert(values.end(), {edge.inner, edge.outer, edge.steepest, edge.place});
            }
            return matrix_of(values.data(), profiles.shape(0), 4);
        },
        "profiles"_a, "ends"_a, "middle"_a,
        "Of (n, m) profiles across the edge of dark spots, (n, 4): darkness within and beyond, the "
        "steepest change between two\nsamples, and where it is halfway nearest to the middle, "
        "samples from the first (NaN: nowhere).");
}

}  // namespace pinchoff
