// Bindings of rays across borders in pictures: shapes and types, nothing else.
#include "pinchoff/rays.hpp"
#include "pinchoff/across.hpp"
#include "pinchoff/polar.hpp"

#include "bindings.hpp"

namespace pinchoff {

namespace {

using Line = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Levels = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Circles = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<nb::numpy, bool, nb::ndim<1>>;
using Traces = nb::ndarray<nb::numpy, float, nb::ndim<3>>;

/// Refuses numbers of pixels and samples with which a function would look beside its arrays.
void require(bool rule, const char* message) {
    if (!rule) throw nb::value_error(message);
}

Picture picture_of(Levels rows) {
    require(rows.size() > 0, "image must have at least one pixel; got none; give grey levels");
    return {rows.data(), static_cast<std::ptrdiff_t>(rows.shape(0)),
            static_cast<std::ptrdiff_t>(rows.shape(1))};
}

void require_pairs(Points points, Points normals) {
    require(normals.shape(0) == points.shape(0),
            "normals must have one row for each point; got another number; give one a point");
}

std::vector<Ray> rays_of(Points points, Points normals, double from, double step) {
    require_pairs(points, normals);
    std::vector<Ray> rays(points.shape(0));
    for (std::size_t k = 0; k < rays.size(); ++k) {
        const double *p = points.data() + 2 * k, *n = normals.data() + 2 * k;
        rays[k] = {{p[0] + from * n[0], p[1] + from * n[1]}, {step * n[0], step * n[1]}};
    }
    return rays;
}

/// x, y, contrast and the grey levels on both sides, each of all rays of all circles: (5, n, rays).
Traces traced_outlines(Levels image, Circles circles, const PolarRule& rule) {
    require(rule.rays >= 1 && rule.steps >= 2 && rule.window >= 1 && rule.bend >= 0,
            "rays and window must be at least 1, steps at least 2 and bend at least 0; got less; "
            "give more");
    const Picture picture = picture_of(image);
    PolarTrace tracer(rule);
    const std::size_t count = circles.shape(0), rays = static_cast<std::size_t>(rule.rays);
    auto found = std::make_unique<float[]>(5 * count * rays);
    std::vector<PolarPoint> points(rays);
    for (std::size_t k = 0; k < count; ++k) {
        const float* circle = circles.data() + 3 * k;
        tracer.trace(picture, circle[0], circle[1], circle[2], points.data());
        for (std::size_t ray = 0; ray < rays; ++ray) {
            const double angle = static_cast<double>(ray) * (2.0 * kPi / rule.rays);
            const PolarPoint& point = points[ray];
            const double away = point.reach * circle[2];
            const float row[5] = {static_cast<float>(circle[0] + away * std::cos(angle)),
                                  static_cast<float>(circle[1] + away * std::sin(angle)),
                                  point.contrast, point.inner, point.outer};
            for (std::size_t q = 0; q < 5; ++q) found[(q * count + k) * rays + ray] = row[q];
        }
    }
    return array_owning<Traces>(std::move(found), {5, count, rays});
}

}  // namespace

void bind_rays(nb::module_& m) {
    m.def(
        "region_border",
        [](Points line, double spacing, int fewest, int most, double smoothing, double margin,
           Pair size) {
            require(line.shape(0) > 0 && 1 <= fewest && fewest <= most && smoothing > 0.0,
                    "line must have points, smoothing be positive and 1 <= fewest <= most; got "
                    "others; give a closed line");
            const RegionBorder b =
                region_border(points_of(line), {spacing, fewest, most, smoothing, margin},
                              size.first, size.second);
            return std::tuple(array_of(b.points), array_of(b.normals),
                              array_copying<Flags>(b.at_edge.data(), {b.at_edge.size()}));
        },
        "line"_a, "spacing"_a, "fewest"_a, "most"_a, "smoothing"_a, "margin"_a, "size"_a,
        "Points spaced evenly round an (n, 2) line, smoothed, with outward normals, and which are "
        "within `margin` of the edge\nof a frame of some (width, height); (0, 0): of none.");
    m.def(
        "running_median",
        [](Line values, int reach) {
            require(reach >= 0, "reach must be at least 0; got less; give a number of places");
            return array_of(running_median({values.data(), values.data() + values.size()}, reach));
        },
        "values"_a, "reach"_a,
        "Values round a closed line, (n,), each the median of those as far as `reach` on either "
        "side.");
    m.def(
        "rim_ends",
        [](Levels dark, Points points, Points normals, double from, double step, int samples,
           double level, double edge, int inside, int beyond) {
            require(samples >= 1 && inside >= 0 && beyond >= 0,
                    "samples must be at least 1, inside and beyond at least 0; got less; give "
                    "numbers of samples");
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
        [](Levels dark, Points points, Points normals, double reach, double step, double beyond) {
            require(
                step > 0.0 && reach >= 0.0 && reach < 1e6 * step && std::fabs(beyond) < 1e6 * step,
                "reach must be at least 0 and less than 1e6 positive steps, as beyond; got "
                "others; give pixels");
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
    m.def(
        "traced_outlines",
        [](Levels image, Circles circles, int rays, int steps, Pair reach, int window, int bend,
           double bending, double clear, double dim) {
            return traced_outlines(
                image, circles,
                {rays, steps, reach.first, reach.second, window, bend, static_cast<float>(bending),
                 static_cast<float>(clear), static_cast<float>(dim)});
        },
        "image"_a, "circles"_a, "rays"_a, "steps"_a, "reach"_a, "window"_a, "bend"_a, "bending"_a,
        "clear"_a, "dim"_a,
        "The closed outline with the most brightening outwards about each of (n, 3) circles of x, "
        "y "
        "and radius, (5, n, rays): x, y,\ncontrast, and the grey levels just inside and outside.");
    m.def(
        "across",
        [](Levels image, Points points, Points normals, int reach, double far, int near,
           double faint, double ended, double undone, double noise,
           std::tuple<double, double, double> halo) {
            require_pairs(points, normals);
            require(reach >= 1 && far > reach && far < 1e6 && std::get<0>(halo) >= 0.0,
                    "reach must be at least 1 and far beyond it; got others; give pixels");
            const auto [halo_reach, halo_dark, halo_core] = halo;
            const Across seen = across(picture_of(image), points_of(points), points_of(normals),
                                       {reach,
                                        far,
                                        near,
                                        faint,
                                        ended,
                                        undone,
                                        noise,
                                        {halo_reach, halo_dark, halo_core}});
            return std::tuple(seen.closed, seen.strength, seen.undone, seen.placed, seen.halo);
        },
        "image"_a, "points"_a, "normals"_a, "reach"_a, "far"_a, "near"_a, "faint"_a, "ended"_a,
        "undone"_a, "noise"_a, "halo"_a,
        "What is seen across an outline, (n, 2) points with outward normals: the share on which "
        "something happens, how much,\nthe share on which it is undone farther out, and how much "
        "of it happens on the outline, and whether it is the light about a dark rim.");
}

}  // namespace pinchoff
