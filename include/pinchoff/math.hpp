// Small vectors and a natural logarithm that compilers turn into SIMD code.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "types.hpp"

// Marks per-vertex physics: empty for a C++ compiler, so that a CUDA one can compile it for both.
#if defined(__CUDACC__)
#define PINCHOFF_HD __host__ __device__
#else
#define PINCHOFF_HD
#endif

// Before a loop whose iterations do not depend on each other, which compilers cannot see where the
// arrays come by pointer.
#if defined(__clang__)
#define PINCHOFF_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define PINCHOFF_INDEPENDENT _Pragma("GCC ivdep")
#else
#define PINCHOFF_INDEPENDENT
#endif

// Each instruction set compiles the headers in a namespace of its own, so that the linker can
// never merge an inline function of one with that of another.
#if !defined(PINCHOFF_ARCH)
#define PINCHOFF_ARCH generic
#endif

namespace pinchoff::inline PINCHOFF_ARCH {

inline constexpr double kPi = 3.14159265358979323846;

struct Vec2 {
    double x, y;
};

PINCHOFF_HD inline Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
PINCHOFF_HD inline Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
PINCHOFF_HD inline Vec2 operator*(double s, Vec2 a) { return {s * a.x, s * a.y}; }
PINCHOFF_HD inline double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
PINCHOFF_HD inline double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }

/// The way from one place to another that belongs to another body: the one function for it. Where
/// space repeats itself, `image` is the shift of the other body's image that is meant.
PINCHOFF_HD inline Vec2 displacement(Vec2 from, Vec2 to, Vec2 image = {0.0, 0.0}) {
    return {to.x + image.x - from.x, to.y + image.y - from.y};
}

/// As many numbers side by side as a register of this instruction set holds, for sums and extremes
/// over an array. Comparisons with a number that is not finite behave as they do for single
/// numbers.
#if defined(__AVX512F__)
inline constexpr int kWidth = 8;
#elif defined(__AVX__)
inline constexpr int kWidth = 4;
#else
inline constexpr int kWidth = 2;
#endif
using Lanes = double __attribute__((vector_size(kWidth * sizeof(double))));

inline Lanes load(const double* from) {
    Lanes lanes;
    std::memcpy(&lanes, from, sizeof lanes);
    return lanes;
}
inline void store(double* to, Lanes lanes) { std::memcpy(to, &lanes, sizeof lanes); }
inline Lanes smaller(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
inline double smaller(double a, double b) { return a < b ? a : b; }
inline double larger(double a, double b) { return a > b ? a : b; }

inline double sum(Lanes a) {
    double total = a[0];
    for (int l = 1; l < kWidth; ++l) total += a[l];
    return total;
}
/// Sum of so many numbers, whole registers first.
inline double sum(const double* values, int count) {
    const int whole = count / kWidth * kWidth;
    Lanes lanes{};
    for (int i = 0; i < whole; i += kWidth) lanes += load(values + i);
    double total = sum(lanes);
    for (int i = whole; i < count; ++i) total += values[i];
    return total;
}

inline double least(Lanes a) {
    double out = a[0];
    for (int l = 1; l < kWidth; ++l) out = smaller(out, a[l]);
    return out;
}
inline double most(Lanes a) {
    double out = a[0];
    for (int l = 1; l < kWidth; ++l) out = larger(out, a[l]);
    return out;
}

/// Sum of the points whose x and y are lanes next to each other, one after the other.
inline Vec2 sum_of_points(Lanes a) {
    using Point = double __attribute__((vector_size(2 * sizeof(double))));
    Point total = __builtin_shufflevector(a, a, 0, 1);
#if defined(__AVX__)
    total += __builtin_shufflevector(a, a, 2, 3);
#endif
#if defined(__AVX512F__)
    total += __builtin_shufflevector(a, a, 4, 5);
    total += __builtin_shufflevector(a, a, 6, 7);
#endif
    return {total[0], total[1]};
}

/// In each lane the sum of the lanes up to it.
inline Lanes running_sum(Lanes a) {
    const Lanes none{};
#if defined(__AVX512F__)
    a += __builtin_shufflevector(none, a, 7, 8, 9, 10, 11, 12, 13, 14);
    a += __builtin_shufflevector(none, a, 6, 7, 8, 9, 10, 11, 12, 13);
    a += __builtin_shufflevector(none, a, 4, 5, 6, 7, 8, 9, 10, 11);
#elif defined(__AVX__)
    a += __builtin_shufflevector(none, a, 3, 4, 5, 6);
    a += __builtin_shufflevector(none, a, 2, 3, 4, 5);
#else
    a += __builtin_shufflevector(none, a, 1, 2);
#endif
    return a;
}

/// Two of the rows of a square of numbers, in which the squares of `Step` that stand across the
/// diagonal change places.
template <int Step, int... Lane>
inline void exchange(Lanes& a, Lanes& b, std::integer_sequence<int, Lane...>) {
    const Lanes first =
        __builtin_shufflevector(a, b, (Lane & Step ? kWidth + Lane - Step : Lane)...);
    b = __builtin_shufflevector(a, b, (Lane & Step ? kWidth + Lane : Lane + Step)...);
    a = first;
}

/// Turn kWidth rows into columns.
template <int Step = 1>
inline void transpose(Lanes* rows) {
    if constexpr (Step < kWidth) {
        for (int i = 0; i < kWidth; ++i)
            if (!(i & Step))
                exchange<Step>(rows[i], rows[i + Step], std::make_integer_sequence<int, kWidth>{});
        transpose<2 * Step>(rows);
    }
}

/// Natural logarithm of a positive, finite, normal number, to about 1 ulp; no branch, no table.
///
/// x = 2^k m with m in [1/√2, √2), and ln m = 2 artanh((m-1)/(m+1)) by a minimax polynomial in
/// the square of the argument. Written with integer operations that AVX2 has for 64-bit lanes,
/// since the vector libraries that compilers call need flags that also remove NaN checks.
PINCHOFF_HD inline double natural_log(double x) {
    constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcdULL;  // bits of 1/√2
    constexpr std::uint64_t kOne = 0x3ff0000000000000ULL;       // bits of 1
    constexpr std::uint64_t kMantissa = 0x000fffffffffffffULL;
    constexpr std::uint64_t kTwo52 = 0x4330000000000000ULL;  // bits of 2^52
    constexpr double kLn2High = 0x1.62e42fefa3800p-1;        // k * kLn2High is exact
    constexpr double kLn2Low = 0x1.ef35793c76730p-45;
    const std::uint64_t shifted = std::bit_cast<std::uint64_t>(x) + (kOne - kRootHalf);
    const double k = std::bit_cast<double>((shifted >> 52) | kTwo52) - (0x1p52 + 1023.0);
    const double m = std::bit_cast<double>((shifted & kMantissa) + kRootHalf);
    const double s = (m - 1.0) / (m + 1.0);
    const double z = s * s;
    double p = 0x1.2f056395f5a67p-4;
    p = p * z + 0x1.39a1bab2e7e3cp-4;
    p = p * z + 0x1.74663ee8bc916p-4;
    p = p * z + 0x1.c71c52095abb5p-4;
    p = p * z + 0x1.24924941f1295p-3;
    p = p * z + 0x1.999999997fdb7p-3;
    p = p * z + 0x1.5555555555592p-2;
    const double two_s = s + s;
    return k * kLn2High + (two_s + (two_s * (z * p) + k * kLn2Low));
}

}  // namespace pinchoff::inline PINCHOFF_ARCH
