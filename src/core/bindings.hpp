// What the binding files share: array types in and out.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

#include "kernels.hpp"
#include "pinchoff/math.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace pinchoff {

using Points = nb::ndarray<const double, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;
using Pair = std::pair<double, double>;
using Vector = nb::ndarray<nb::numpy, double, nb::ndim<1>>;
using Matrix = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

inline Vec2 vec(const Pair& p) { return {p.first, p.second}; }

inline std::vector<Vec2> points_of(Points points) {
    const double* d = points.data();
    std::vector<Vec2> r(points.shape(0));
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = {d[2 * i], d[2 * i + 1]};
    return r;
}

/// A NumPy array that takes over its values.
template <class Array>
Array array_owning(std::unique_ptr<typename Array::Scalar[]> values,
                   std::initializer_list<std::size_t> shape) {
    using Scalar = typename Array::Scalar;
    nb::capsule owner(values.get(), [](void* p) noexcept { delete[] static_cast<Scalar*>(p); });
    return Array(values.release(), shape, owner);
}

/// A NumPy array of a copy of the values.
template <class Array, class Value>
Array array_copying(const Value* values, std::initializer_list<std::size_t> shape) {
    std::size_t count = 1;
    for (const std::size_t side : shape) count *= side;
    auto copy = std::make_unique<typename Array::Scalar[]>(count);
    std::copy_n(values, count, copy.get());
    return array_owning<Array>(std::move(copy), shape);
}

inline Matrix matrix_of(const double* values, std::size_t rows, std::size_t columns) {
    return array_copying<Matrix>(values, {rows, columns});
}

inline Matrix array_of(const std::vector<Vec2>& r) {
    static_assert(sizeof(Vec2) == 2 * sizeof(double));
    return matrix_of(r.empty() ? nullptr : &r[0].x, r.size(), 2);
}

inline Vector array_of(const std::vector<double>& values) {
    return array_copying<Vector>(values.data(), {values.size()});
}

void bind_geometry(nb::module_& m);
void bind_flows(nb::module_& m);
void bind_collision(nb::module_& m);
void bind_inspection(nb::module_& m);
void bind_emulsion(nb::module_& m);
void bind_rays(nb::module_& m);

}  // namespace pinchoff
