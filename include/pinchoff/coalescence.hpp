// Contacts of droplets and what becomes of them. Included by island.hpp, which declares these
// functions; the law is in film.hpp, the geometry in join.hpp.
#pragma once

namespace pinchoff {

/// A merged droplet neither breaks nor merges before its bridge has opened past the neck's
/// threshold once: it starts thinner than that, and would be cut at once. A bridge that the flow
/// draws thin again before it has come so far, or that is no longer where the droplet is thinnest,
/// is a place like any other from then on.
inline void Island::open_bridges() {
    for (Droplet& d : droplets_) {
        if (d.bridge == 0) continue;
        const Separation& limit = world_->separation;
        const Neck neck =
            find_neck(d.positions(), {limit.fraction, limit.length * d.ring.diameter});
        d.widest = std::max(d.widest, neck.thickness);
        const bool opens = neck.thickness < neck_threshold(world_->model, d.ring.diameter) &&
                           neck.thickness >= kClosing * d.widest &&
                           at_bridge(neck, d.bridge, d.ring.count);
        if (!opens) d.bridge = 0;
    }
}

/// Notes what one droplet of a pair, whose touches are listed from `first` on, faces the other
/// with.
inline void Island::measure_facing(Look& look, const DropletPair& pair, std::size_t first) const {
    if (first == look.lists.touches.size()) return;
    const Ring &a = droplets_[pair.first].ring, &b = droplets_[pair.second].ring;
    const double length = facing_length(look.lists, first, a, b, pair.image, touch_of(a, b).length);
    if (!(length > 0.0)) return;
    const auto [low, high] = std::minmax(droplets_[pair.first].id, droplets_[pair.second].id);
    look.facings.push_back({low, high, 0.5 * length});
}

inline int Island::index_of(int id) const {
    for (std::size_t i = 0; i < droplets_.size(); ++i)
        if (droplets_[i].id == id) return static_cast<int>(i);
    return -1;
}

/// Whether two droplets that touch, or that part at this share of the clock, now merge.
inline bool Island::merges(const Film& film, double share) const {
    const bool drained =
        film.clock >= share * film.needed || !(world_->coalescence.film_time > 0.0);
    if (!drained || film.cut || film.refused) return false;
    const int i = index_of(film.first), j = index_of(film.second);
    return i >= 0 && j >= 0 && droplets_[i].bridge == 0 && droplets_[j].bridge == 0;
}

/// Contacts of droplets: whether any begins, ends or has drained. The facings are summed, over both
/// sides and all images, to one for each pair.
inline Finding Island::look_at_films(Look& look) const {
    Finding found;
    if (!world_->coalescence.follows) return found;
    std::vector<Facing>& pairs = look.facings;
    std::ranges::sort(pairs, [](const Facing& a, const Facing& b) {
        if (a.droplet != b.droplet) return a.droplet < b.droplet;
        return a.other != b.other ? a.other < b.other : a.length < b.length;
    });
    std::size_t kept = 0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        const bool same = kept > 0 && pairs[kept - 1].droplet == pairs[k].droplet &&
                          pairs[kept - 1].other == pairs[k].other;
        if (same) pairs[kept - 1].length += pairs[k].length;
        else pairs[kept++] = pairs[k];
    }
    pairs.resize(kept);
    found.happened = pairs.size() != films_.size();
    for (std::size_t k = 0; k < films_.size() && !found.happened; ++k)
        found.happened = films_[k].first != pairs[k].droplet ||
                         films_[k].second != pairs[k].other || merges(films_[k], 1.0);
    return found;
}

/// Ends contacts, begins others, and merges two droplets whose film has drained. Of several such
/// pairs the others are seen at the next look, which comes at the same instant.
inline void Island::tend_films(const Finding&) {
    std::vector<Film> parted;
    std::erase_if(films_, [&](const Film& film) {
        const bool touches = std::ranges::any_of(look_.facings, [&](const Facing& f) {
            return f.droplet == film.first && f.other == film.second;
        });
        if (!touches) parted.push_back(film);
        return !touches;
    });
    const std::vector<Facing> facings = look_.facings;
    for (const Facing& f : facings) begin_film(f);
    handed_down_.clear();
    for (const Film& film : parted)
        if (!(merges(film, 1.0 - world_->coalescence.separation) && merge(film)))
            note_film(FilmStage::parted, film);
    for (Film& film : films_)
        if (merges(film, 1.0)) {
            film.refused = true;
            merge(Film(film));
            return;
        }
}

/// Begins the contact of a pair that has none yet. What came of other droplets takes over the film
/// that those had.
inline void Island::begin_film(const Facing& f) {
    Film film{f.droplet, f.other, time()};
    const auto place = std::ranges::lower_bound(films_, film, earlier);
    if (place != films_.end() && !earlier(film, *place)) return;
    Droplet &a = droplets_[index_of(f.droplet)], &b = droplets_[index_of(f.other)];
    film.harmonic = 2.0 * a.ring.diameter * b.ring.diameter / (a.ring.diameter + b.ring.diameter);
    film.least = least_length(touch_of(a.ring, b.ring).length, film.harmonic);
    film.length = film.longest = f.length;
    const Film* inherited = nullptr;
    for (const Film& old : handed_down_)
        if (old.first == film.first && old.second == film.second &&
            (inherited == nullptr || old.clock > inherited->clock))
            inherited = &old;
    if (inherited != nullptr) {
        film.clock = inherited->clock;
        film.needed = inherited->needed;
        film.cut = inherited->cut;
    } else {
        const int meeting = a.key < b.key ? a.meetings : b.meetings;
        film.needed = clock_needed(world_->coalescence, a.key, b.key, meeting);
    }
    ++a.meetings;
    ++b.meetings;
    films_.insert(place, film);
    note_film(FilmStage::touched, film);
}

/// The lengths that clocks run with until the next look.
inline void Island::measure_films() {
    handed_down_.clear();
    for (std::size_t k = 0; k < films_.size(); ++k) {
        Film& film = films_[k];
        film.length = look_.facings[k].length;
        film.longest = std::max(film.longest, film.length);
    }
}

inline void Island::run_clocks(std::int64_t steps) {
    for (Film& film : films_)
        if (!film.cut)
            film.clock +=
                static_cast<double>(steps) * time_step_ * draining_rate(film, world_->coalescence);
}

/// Steps after which the first film will have drained.
inline std::int64_t Island::steps_to_merge() const {
    double least = kLongestBlock;
    for (const Film& film : films_) {
        if (film.cut || film.refused || film.clock >= film.needed) continue;
        const double rate = draining_rate(film, world_->coalescence);
        least = std::min(least, (film.needed - film.clock) / (rate * time_step_));
    }
    return std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(least)));
}

/// The shift of one droplet's image that is next to another.
inline Vec2 Island::nearest_image(int i, int j) const {
    const Droplet &a = droplets_[i], &b = droplets_[j];
    Vec2 nearest{0, 0};
    if (!world_->period.any()) return nearest;
    const double margin = 2.0 * touch_of(a.ring, b.ring).length;
    double least2 = std::numeric_limits<double>::infinity();
    const std::vector<Vec2> of_a = a.positions(), of_b = b.positions();
    for_overlapping_images(grown(look_.droplets[i].survey.box, margin),
                           look_.droplets[j].survey.box, world_->period, [&](Vec2 image) {
                               for (const Vec2& r : of_a) {
                                   const double d2 =
                                       near_edge(of_b, displacement(image, r)).distance2;
                                   if (d2 < least2) {
                                       least2 = d2;
                                       nearest = image;
                                   }
                               }
                           });
    return nearest;
}

/// What would be wrong with a droplet that two would make: it holds an obstacle, which it would
/// close round, or its outline crosses itself.
inline Guard Island::wrong_with(const Droplet& merged, double& value) const {
    const Ring& ring = merged.ring;
    Survey seen;
    world_->kernels.survey(ring, seen);
    std::vector<ObstacleImage> near;
    world_->obstacles.find(seen.box, 0.0, near);
    for (const ObstacleImage& image : near) {
        const Obstacle o = world_->obstacles.seen(image);
        const double edge = std::sqrt(world_->kernels.edge_distance2(ring, o.x, o.y));
        value = 1.0 - (world_->kernels.contains(ring, o.x, o.y) ? -edge : edge) / o.radius;
        if (value > limit_of(Guard::penetration)) return Guard::penetration;
    }
    value = 0;
    if (world_->kernels.self_intersects(ring.x, ring.y, ring.count))
        return Guard::self_intersection;
    return Guard::none;
}

/// Joins two droplets to one, which keeps their area, mass and momentum; whether it could be done.
inline bool Island::merge(const Film& film) {
    list_contacts();
    set_lags(0.0);
    const int i = index_of(film.first), j = index_of(film.second);
    const Droplet &a = droplets_[i], &b = droplets_[j];
    const Vec2 image = nearest_image(i, j);
    const Shape one{a.positions(), a.velocities()};
    Shape other{b.positions(), b.velocities()};
    for (Vec2& r : other.r) r = r + image;
    const double rest_area = a.ring.rest_area + b.ring.rest_area;
    const int count = world_->vertices_for(std::sqrt(rest_area / kReferenceArea),
                                           perimeter(one.r) + perimeter(other.r));
    const Vec2 velocity =
        1.0 / rest_area * (a.ring.rest_area * mean(one.v) + b.ring.rest_area * mean(other.v));
    Guard guard = Guard::none;
    double value = 0;
    // Along all that they face each other with; where that does not serve, at one place.
    for (const double within : {touch_of(a.ring, b.ring).length, 0.0}) {
        Joined joined = join(one, other, within, count);
        const Vec2 correction = velocity - mean(joined.shape.v);
        for (Vec2& v : joined.shape.v) v = v + correction;
        Droplet merged = heir(a, Droplet(world_->model, rest_area, joined.shape.r, joined.shape.v));
        merged.bridge = joined.bridge;
        const Guard wrong = wrong_with(merged, value);
        if (guard == Guard::none) guard = wrong;
        if (wrong != Guard::none) continue;
        merged.generation = 0;
        merged.key = mixed(std::min(a.key, b.key) ^ mixed(std::max(a.key, b.key)));
        for (const int o : b.contacted)
            if (!merged.has_met(o)) merged.meet(o);
        merged.travel = std::min(a.travel - a.travelled, b.travel - b.travelled);
        merged.travelled = 0;
        merged.mended = std::max(a.mended, b.mended);
        replace_by_merged(film, std::move(merged));
        return true;
    }
    note_film(FilmStage::unmerged, film, guard, value);
    set_lags(0.5 * time_step_);
    return false;
}

/// Puts the droplet that came of two in their place.
inline void Island::replace_by_merged(const Film& film, Droplet merged) {
    note_film(FilmStage::merged, film);
    const std::size_t noted = film_events_.size() - 1;
    std::erase_if(films_, [&](const Film& f) { return !earlier(f, film) && !earlier(film, f); });
    std::vector<Film> before;
    for (const int id : {film.first, film.second}) {
        const std::vector<Film> ended = end_films(id);
        remove(index_of(id));
        before.insert(before.end(), ended.begin(), ended.end());
    }
    const int id = add(std::move(merged));
    film_events_[noted].into = id;
    for (const int parent : {film.first, film.second}) hand_down(before, parent, id);
    settle_heirs();
}

/// Ends the contacts of a droplet that is about to go; returns them.
inline std::vector<Film> Island::end_films(int id) {
    std::vector<Film> ended;
    std::erase_if(films_, [&](const Film& film) {
        if (film.first != id && film.second != id) return false;
        ended.push_back(film);
        return true;
    });
    for (const Film& film : ended) note_film(FilmStage::parted, film);
    return ended;
}

/// The films that a droplet had are its heir's, where that still touches.
inline void Island::hand_down(const std::vector<Film>& films, int from, int to) {
    for (Film film : films) {
        if (film.first != from && film.second != from) continue;
        const int other = film.first == from ? film.second : film.first;
        film.first = std::min(to, other);
        film.second = std::max(to, other);
        handed_down_.push_back(film);
    }
}

inline void Island::note_film(FilmStage stage, const Film& film, Guard guard, double value) {
    if (film.cut) return;
    const int i = index_of(film.first), j = index_of(film.second);
    FilmEvent event{stage, time(), film, kNoNumber, {0, 0}, {0, 0}, guard, value};
    if (i >= 0 && j >= 0) {
        const Ring &a = droplets_[i].ring, &b = droplets_[j].ring;
        const Vec2 from{mean(a.x, a.count), mean(a.y, a.count)};
        const Vec2 to = Vec2{mean(b.x, b.count), mean(b.y, b.count)} + nearest_image(i, j);
        event.place = from + a.diameter / (a.diameter + b.diameter) * (to - from);
        event.areas[0] = a.rest_area;
        event.areas[1] = b.rest_area;
    }
    film_events_.push_back(event);
}

}  // namespace pinchoff
