// The collision of `pinchoff --model front-tracking`, written the straightforward way, with other
// means than the engine's: explicit Euler steps along the normals, the curvature of the circle
// through three vertices, vertices put back to even places after every step, the droplet's velocity
// from two positions of its
// outline's centre. It is a yardstick and an independent check.
//
//   g++ -O2 -o front front.cpp
//   ./front [vertices] [steps] [simulation capillary number] [offset] [size ratio] [time step]
//
// Repeats the collision until at least `steps` steps have been taken (once at the least) and
// prints one JSON object. Units: D0 = v = 1; the obstacle's centre is the origin.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <vector>

struct Point {
    double x, y;
};
Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
Point operator*(double s, Point a) { return {s * a.x, s * a.y}; }
double dot(Point a, Point b) { return a.x * b.x + a.y * b.y; }
double cross(Point a, Point b) { return a.x * b.y - a.y * b.x; }
double norm(Point a) { return std::sqrt(dot(a, a)); }

struct Model {
    int vertices = 128;
    double capillary = 20;
    double offset = 0.05;
    double size_ratio = 5.66;
    double time_step = 1e-4;
    double start_distance = 5;
    double time_limit = 30;
    double neck_thickness = 0.167;
    double neck_separation = 0.28;
    double check_every = 0.01;  // time between two looks at the neck
};

struct Result {
    const char* outcome = "captured";
    long steps = 0;
    double symmetry = NAN, contact_time = NAN, contact_speed = NAN, impact_parameter = NAN;
    double minimum_neck = std::numeric_limits<double>::infinity();
    double small_daughter_area = NAN, end_time = 0;
};

using Outline = std::vector<Point>;

double signed_area(const Outline& r) {
    double twice = 0;
    for (size_t i = 0; i < r.size(); i++) twice += cross(r[i], r[(i + 1) % r.size()]);
    return twice / 2;
}

// Centre of the enclosed area.
Point centroid(const Outline& r) {
    Point sum{0, 0};
    for (size_t i = 0; i < r.size(); i++) {
        const Point a = r[i], b = r[(i + 1) % r.size()];
        sum = sum + cross(a, b) / 6 * (a + b);
    }
    return 1 / signed_area(r) * sum;
}

// Centre of the outline itself, whose vertices are even.
Point outline_centre(const Outline& r) {
    Point sum{0, 0};
    for (Point p : r) sum = sum + 1.0 / r.size() * p;
    return sum;
}

// Stokes' flow near a cylinder [paper, the equations for v_f,r and v_f,theta].
Point stokes_flow(Point p, double radius) {
    const double r = norm(p);
    if (r <= radius) return {0, 0};
    const double logarithm = std::log(r / radius);
    const double dipole = 0.5 - 0.5 * radius * radius / (r * r);
    const Point outward = 1 / r * p, around = {-outward.y, outward.x};
    return (logarithm - dipole) * outward.x * outward - (logarithm + dipole) * outward.y * around;
}

// One step of the normals' motion. v_n = u.n + P/Ca_sim (p - curvature), p such that the area's
// rate, the sum of v_n over the outline's length, is zero; no vertex on the obstacle moves into it.
void move_along_normals(Outline& r, const Model& m, double area) {
    const int n = r.size();
    const double radius = 1 / m.size_ratio;
    std::vector<Point> normal(n);
    std::vector<double> own(n), share(n);
    double perimeter = 0;
    for (int i = 0; i < n; i++) perimeter += norm(r[(i + 1) % n] - r[i]);
    for (int i = 0; i < n; i++) {
        const Point before = r[(i + n - 1) % n], after = r[(i + 1) % n], chord = after - before;
        const Point in = r[i] - before, out = after - r[i];
        const double length = norm(chord);
        const double curvature = 2 * cross(in, out) / (norm(in) * norm(out) * length);
        normal[i] = {chord.y / length, -chord.x / length};
        share[i] = length / 2;
        own[i] = dot(stokes_flow(r[i], radius), normal[i]) - perimeter / m.capillary * curvature;
    }
    // A vertex on the obstacle with its normal towards it is held while it would move outwards of
    // the droplet. More are held as the pressure rises: go on until their number stays.
    std::vector<bool> held(n, false);
    double pressure = 0;
    for (bool changed = true; changed;) {
        double flux = 0, length = 0;
        for (int i = 0; i < n; i++) {
            if (held[i]) continue;
            flux += share[i] * own[i];
            length += share[i];
        }
        pressure = -flux / length;
        changed = false;
        for (int i = 0; i < n; i++) {
            const bool touches = norm(r[i]) < radius * (1 + 1e-6) && dot(normal[i], r[i]) < 0;
            if (held[i] || !touches || own[i] + pressure <= 0) continue;
            held[i] = changed = true;
        }
    }
    for (int i = 0; i < n; i++)
        if (!held[i]) r[i] = r[i] + m.time_step * (own[i] + pressure) * normal[i];
    for (Point& p : r)
        if (norm(p) < radius) p = radius / norm(p) * p;
    // What the step's length has changed of the area.
    const double shift = (area - signed_area(r)) / perimeter;
    for (int i = 0; i < n; i++)
        if (!held[i]) r[i] = r[i] + shift * normal[i];
}

// Vertices to even places along the outline, on the parabola through each and its neighbours.
void space_evenly(Outline& r) {
    const int n = r.size();
    std::vector<double> arc(n + 1, 0.0);
    for (int i = 0; i < n; i++) arc[i + 1] = arc[i] + norm(r[(i + 1) % n] - r[i]);
    double mean = 0;
    for (int i = 0; i < n; i++) mean += (arc[n] * i / n - arc[i]) / n;
    const Outline old = r;
    for (int i = 0; i < n; i++) {
        const double s = arc[n] * i / n - arc[i] - mean;
        const Point before = old[(i + n - 1) % n], after = old[(i + 1) % n];
        const double a = norm(old[i] - before), b = norm(after - old[i]);
        const Point in = 1 / a * (old[i] - before), out = 1 / b * (after - old[i]);
        const Point bend = 2 / (a + b) * (out - in), along = 1 / (a + b) * (b * in + a * out);
        r[i] = old[i] + s * along + s * s / 2 * bend;
    }
}

// Whether the chord from i to j lies inside: it leaves both ends to the inside, crosses no edge.
bool inside(const Outline& r, int i, int j) {
    const int n = r.size();
    const Point chord = r[j] - r[i];
    if (cross(r[(i + 1) % n] - r[(i + n - 1) % n], chord) <= 0) return false;
    if (cross(r[(j + 1) % n] - r[(j + n - 1) % n], chord) >= 0) return false;
    for (int k = 0; k < n; k++) {
        const Point a = r[k], b = r[(k + 1) % n];
        if (cross(chord, a - r[i]) * cross(chord, b - r[i]) < 0 &&
            cross(b - a, r[i] - a) * cross(b - a, r[j] - a) < 0)
            return false;
    }
    return true;
}

struct Neck {
    double thickness = std::numeric_limits<double>::infinity();
    int first = 0, second = 0;
};

// Thinnest chord inside whose shorter arc exceeds the fraction `separation` of the perimeter.
Neck thinnest_neck(const Outline& r, double separation) {
    const int n = r.size();
    std::vector<double> arc(n + 1, 0.0);
    for (int i = 0; i < n; i++) arc[i + 1] = arc[i] + norm(r[(i + 1) % n] - r[i]);
    Neck neck;
    for (int i = 0; i < n; i++) {
        for (int j = i + 1; j < n; j++) {
            const double one_way = arc[j] - arc[i];
            if (std::fmin(one_way, arc[n] - one_way) <= separation * arc[n]) continue;
            const double distance = norm(r[j] - r[i]);
            if (distance < neck.thickness && inside(r, i, j)) neck = {distance, i, j};
        }
    }
    return neck;
}

double distance_of_edges(const Outline& r) {
    double nearest = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < r.size(); i++) {
        const Point a = r[i], e = r[(i + 1) % r.size()] - a;
        const double t = std::fmin(std::fmax(-dot(a, e) / dot(e, e), 0), 1);
        nearest = std::fmin(nearest, norm(a + t * e));
    }
    return nearest;
}

// S = 1 - |A_left - A_right| / A about the line through the origin along v [eq. symdef].
double symmetry(const Outline& r, Point v) {
    const double c = v.x / norm(v), s = v.y / norm(v);
    double left = 0;  // the area above the line, in the frame where the line is the x axis
    for (size_t i = 0; i < r.size(); i++) {
        const Point a = r[i], b = r[(i + 1) % r.size()];
        double xa = c * a.x + s * a.y, ya = c * a.y - s * a.x;
        double xb = c * b.x + s * b.y, yb = c * b.y - s * b.x;
        if (ya <= 0 && yb <= 0) continue;
        if (ya * yb < 0) {
            const double crossing = xa - ya * (xb - xa) / (yb - ya);
            if (ya < 0) xa = crossing, ya = 0;
            else xb = crossing, yb = 0;
        }
        left -= (xb - xa) * (ya + yb) / 2;
    }
    const double area = signed_area(r);
    return 1 - std::fabs(2 * left - area) / area;
}

Result collide(const Model& m) {
    const double pi = std::acos(-1.0), radius = 1 / m.size_ratio, dt = m.time_step, area = pi / 4;
    const int n = m.vertices;
    Outline r(n);
    const double corner = std::sqrt(2 * area / n / std::sin(2 * pi / n));
    for (int i = 0; i < n; i++)
        r[i] = {-m.start_distance + corner * std::cos(2 * pi * (i + 0.5) / n),
                m.offset + corner * std::sin(2 * pi * (i + 0.5) / n)};
    Result result;
    const long last = std::lround(m.time_limit / dt);
    const long every = std::lround(m.check_every / dt);
    Point centre = outline_centre(r);
    while (result.steps < last) {
        move_along_normals(r, m, area);
        space_evenly(r);
        result.steps++;
        result.end_time = result.steps * dt;
        const Point now = outline_centre(r), velocity = 1 / dt * (now - centre);
        centre = now;
        if (std::isnan(result.contact_time) && distance_of_edges(r) <= radius * (1 + 1e-9)) {
            result.contact_time = result.end_time;
            result.contact_speed = norm(velocity);
            result.impact_parameter = std::fabs(cross(centroid(r), velocity)) / norm(velocity);
            result.symmetry = symmetry(r, velocity);
        }
        if (result.steps % every != 0) continue;
        const Neck neck = thinnest_neck(r, m.neck_separation);
        result.minimum_neck = std::fmin(result.minimum_neck, neck.thickness);
        if (neck.thickness < m.neck_thickness) {
            const Outline part(r.begin() + neck.first, r.begin() + neck.second + 1);
            result.small_daughter_area = std::fmin(signed_area(part), area - signed_area(part));
            result.outcome = "broke";
            return result;
        }
        bool past = true;
        for (const Point& p : r) past = past && p.x > radius + 0.5;
        if (past) {
            result.outcome = "slipped";
            return result;
        }
    }
    return result;
}

void print_number(const char* name, double value) {
    std::printf(", \"%s\": ", name);
    if (std::isfinite(value)) std::printf("%.15g", value);
    else std::printf("null");  // JSON knows no NaN
}

int main(int count, char** argument) {
    Model m;
    long steps = 0, taken = 0;
    if (count > 1) m.vertices = std::atoi(argument[1]);
    if (count > 2) steps = std::atol(argument[2]);
    if (count > 3) m.capillary = std::atof(argument[3]);
    if (count > 4) m.offset = std::atof(argument[4]);
    if (count > 5) m.size_ratio = std::atof(argument[5]);
    if (count > 6) m.time_step = std::atof(argument[6]);
    Result result;
    const auto start = std::chrono::steady_clock::now();
    do {
        result = collide(m);
        taken += result.steps;
    } while (taken < steps);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    const double updates = static_cast<double>(taken) * m.vertices;
    std::printf("{\"outcome\": \"%s\"", result.outcome);
    print_number("symmetry", result.symmetry);
    print_number("impact_parameter", result.impact_parameter);
    print_number("contact_time", result.contact_time);
    print_number("contact_speed", result.contact_speed);
    print_number("minimum_neck", result.minimum_neck);
    print_number("small_daughter_area", result.small_daughter_area);
    print_number("end_time", result.end_time);
    print_number("steps", result.steps);
    print_number("seconds", seconds.count());
    print_number("vertex_updates_per_s", updates / seconds.count());
    std::printf("}\n");
}
