// The film of fluid between two droplets that touch: how fast it drains, and when they merge.
//
// Draining follows Reynolds: two faces of length L, pressed together by the Laplace pressure, take
// a time ∝ L², here t_d/t0 = K Ca_sim (L/D_h)² D_h/D0 with the harmonic mean D_h of the diameters.
// The clock C = ∫ dt/t_d runs while they touch, and at 1 they merge. K stands for the thickness at
// which films rupture and for all that is three-dimensional: it is fitted, not predicted. When they
// are pulled apart they merge from 1 - s on (Bremond, Thiam and Bibette, Phys. Rev. Lett. 100,
// 024501 (2008): faces that separate draw out nipples that meet).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "math.hpp"
#include "model.hpp"
#include "random.hpp"

namespace pinchoff {

/// How droplets merge.
struct Coalescence {
    bool follows = false;  // whether contacts of droplets are followed at all
    double film_time = std::numeric_limits<double>::infinity();  // K Ca_sim, t0
    double separation = 0;    // s: by how much less than a whole clock merges those that part
    bool stochastic = false;  // 1/t_d is a rate
    std::uint64_t seed = 0;
};

/// One contact of two droplets.
struct Film {
    int first, second;    // their numbers, the lower one first
    double since = 0;     // when it began, t0
    double harmonic = 1;  // D_h, D0
    double least = 0;     // the length that two round droplets in touch face each other with, D0
    double clock = 0;     // C
    double needed = 1;    // the clock at which they merge
    double length = 0;    // L at the last look, D0
    double longest = 0;
    bool cut = false;      // two halves of a droplet that have not parted yet: no film, no contact
    bool refused = false;  // merging them was tried and refused
};

/// The order in which films are kept.
inline bool earlier(const Film& a, const Film& b) {
    return a.first != b.first ? a.first < b.first : a.second < b.second;
}

/// Length over which two circles that touch are within a vertex spacing of each other. Droplets
/// that face each other with less have not been pressed yet.
inline double least_length(double spacing, double harmonic) {
    return std::sqrt(2.0 * spacing * harmonic);
}

/// 1/t_d.
inline double draining_rate(const Film& film, const Coalescence& how) {
    const double length = std::max(film.length, film.least);
    return film.harmonic / (how.film_time * length * length);
}

/// The clock at which two droplets merge: 1, or, where 1/t_d is a rate, a number with an
/// exponential distribution that depends on the seed, the droplets and the count of their contacts
/// alone.
inline double clock_needed(const Coalescence& how, std::uint64_t one, std::uint64_t other,
                           int meeting) {
    if (!how.stochastic) return 1.0;
    std::uint64_t z = how.seed;
    for (const std::uint64_t part :
         {std::min(one, other), std::max(one, other), static_cast<std::uint64_t>(meeting)})
        z = mixed(z ^ part);
    return -std::log1p(-fraction_of(z));
}

enum class FilmStage { touched, parted, merged, unmerged };

/// What happened to a contact.
struct FilmEvent {
    FilmStage stage;
    double time;
    Film film;
    int into;         // merged: number of the droplet that came of it
    double areas[2];  // of the two
    Vec2 place;
    Guard guard;  // unmerged: what was wrong with the droplet that would have come of it
    double value;
};

/// A bridge this much thinner than it has been is no longer opening; far more than what vertices
/// that slide change of a chord between them.
inline constexpr double kClosing = 0.8;
/// How far vertices may move between two looks at a bridge that has not opened, in their spacing.
inline constexpr double kBridgeRoom = 0.25;

}  // namespace pinchoff
