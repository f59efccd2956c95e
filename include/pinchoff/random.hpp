// Random numbers that are the same everywhere, from one number each (SplitMix64).
#pragma once

#include <cstdint>

namespace pinchoff {

inline constexpr std::uint64_t kGoldenStep = 0x9e3779b97f4a7c15ULL;

/// Scrambles a number so that numbers next to each other have nothing in common.
inline std::uint64_t mixed(std::uint64_t z) {
    z += kGoldenStep;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

/// From 0 to less than 1, with all the bits that a double holds.
inline double fraction_of(std::uint64_t z) { return static_cast<double>(z >> 11) * 0x1p-53; }

/// A sequence whose state is one number.
class Random {
public:
    explicit Random(std::uint64_t seed) : state(seed) {}

    double uniform() {
        const std::uint64_t z = mixed(state);
        state += kGoldenStep;
        return fraction_of(z);
    }

    std::uint64_t state;
};

}  // namespace pinchoff
