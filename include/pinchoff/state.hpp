// What a run of many droplets goes on from, as numbers, and the way back.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "inlet.hpp"
#include "island.hpp"
#include "records.hpp"

namespace pinchoff {

/// Appends numbers to a state.
class StateWriter {
public:
    std::vector<double> numbers;

    template <class... Number>
    void put(Number... values) {
        (numbers.push_back(static_cast<double>(values)), ...);
    }

    /// Both halves of a number that no double holds.
    void put_bits(std::uint64_t bits) { put(bits >> 32, bits & 0xffffffffULL); }

    void put(const Balance& balance) {
        const auto* first = reinterpret_cast<const double*>(&balance);
        numbers.insert(numbers.end(), first, first + kBalanceFields);
    }

    void put(const Inflow& inflow) {
        put_bits(inflow.random.state);
        put(inflow.credit, inflow.next_diameter, inflow.waited);
    }

    void put(const Film& f) {
        put(f.first, f.second, f.since, f.harmonic, f.least, f.clock, f.needed, f.length, f.longest,
            f.cut, f.refused);
    }

    void put(const Droplet& d) {
        const Ring& r = d.ring;
        put(d.id, d.generation, r.count, d.contacted.size(), r.rest_area, d.lag, d.mended,
            d.seen.neck_room, d.seen.thinnest);
        put_bits(d.key);
        put(d.meetings, d.bridge, d.widest);
        for (const int obstacle : d.contacted) put(obstacle);
        for (const double* a : {r.x, r.y, r.vx, r.vy})
            numbers.insert(numbers.end(), a, a + r.count);
    }
};

/// Takes them from a state in the same order; throws where they cannot be one.
class StateReader {
public:
    explicit StateReader(std::span<const double> state)
        : next_(state.data()), end_(next_ + state.size()) {}

    double number() {
        if (next_ == end_) throw std::invalid_argument("a state that is cut short");
        return *next_++;
    }

    std::int64_t whole() {
        const double n = number();
        if (!(std::abs(n) < 0x1p62)) throw std::invalid_argument("a state without its counts");
        return static_cast<std::int64_t>(n);
    }

    int small() { return static_cast<int>(whole()); }

    /// A count of things of which each is at least one number that follows.
    std::size_t count(std::int64_t least = 0) {
        const std::int64_t n = whole();
        if (n < least || n > end_ - next_)
            throw std::invalid_argument("a state without its counts");
        return static_cast<std::size_t>(n);
    }

    std::uint64_t bits() {
        const auto upper = static_cast<std::uint64_t>(whole());
        return upper << 32 | static_cast<std::uint64_t>(whole());
    }

    void read(Balance& balance) {
        auto* field = reinterpret_cast<double*>(&balance);
        for (int i = 0; i < kBalanceFields; ++i) field[i] = number();
    }

    void read(Inflow& inflow) {
        inflow.random.state = bits();
        inflow.credit = number();
        inflow.next_diameter = number();
        inflow.waited = number();
    }

    void read(Film& f) {
        f.first = small();
        f.second = small();
        for (double* value :
             {&f.since, &f.harmonic, &f.least, &f.clock, &f.needed, &f.length, &f.longest})
            *value = number();
        f.cut = number() != 0.0;
        f.refused = number() != 0.0;
    }

    Droplet droplet(const Model& model) {
        const int id = small(), generation = small();
        const std::size_t vertices = count(3), contacted = count();
        const double rest_area = number(), lag = number(), mended = number();
        const double neck_room = number(), thinnest = number();
        const std::uint64_t key = bits();
        const int meetings = small(), bridge = small();
        const double widest = number();
        std::vector<int> met(contacted);
        for (int& obstacle : met) obstacle = small();
        std::vector<Vec2> r(vertices), v(vertices);
        for (Vec2& p : r) p.x = number();
        for (Vec2& p : r) p.y = number();
        for (Vec2& p : v) p.x = number();
        for (Vec2& p : v) p.y = number();
        Droplet d(model, rest_area, r, v);
        d.id = id;
        d.generation = generation;
        d.lag = lag;
        d.mended = mended;
        d.contacted = std::move(met);
        d.key = key;
        d.meetings = meetings;
        d.bridge = bridge;
        d.widest = widest;
        d.seen.neck_room = neck_room;
        d.seen.thinnest = thinnest;
        return d;
    }

private:
    const double *next_, *end_;
};

}  // namespace pinchoff
