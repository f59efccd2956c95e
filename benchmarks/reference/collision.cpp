// The same collision as `pinchoff`, written the straightforward way: one file, one array of
// structs, one loop after another. It is the yardstick of benchmarks/speed.py and, because it
// shares no line with the engine, an independent check of its results.
//
//   g++ -O2 -o collision collision.cpp
//   ./collision [vertices] [steps] [simulation capillary number] [offset] [size ratio] [time step]
//               [line tension] [edge stiffness] [evenly]
//
// With `evenly` 1 the vertices are put back to even places along the outline after every step: what
// the edge springs are for, without them.
//
// Repeats the collision until at least `steps` steps have been taken (once at the least) and
// prints one JSON object. Units: D0 = v = M = 1; the obstacle's centre is the origin.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <vector>

struct Vertex {
    double x, y;
    double vx, vy;
    double fx, fy;  // every force but the part of the drag that depends on the velocity
};

struct Model {
    int vertices = 64;
    double capillary = 20;
    double offset = 0.05;
    double size_ratio = 5.66;
    double time_step = 1e-4;
    double line_tension = 80;
    double edge_stiffness = 3 * 80.0;
    double area_stiffness = 5e3 * 80.0;
    double wall_stiffness = 1.25 * 80.0;
    double start_distance = 5;
    double time_limit = 30;
    double neck_thickness = 0.167;
    double neck_separation = 0.28;
    long check_every = 100;
    bool evenly = false;
};

struct Result {
    const char* outcome = "captured";
    long steps = 0;
    double symmetry = NAN, contact_time = NAN, contact_speed = NAN, impact_parameter = NAN;
    double minimum_neck = std::numeric_limits<double>::infinity();
    double end_time = 0;
};

using Droplet = std::vector<Vertex>;

double signed_area(const Droplet& d) {
    const int n = d.size();
    double twice = 0;
    for (int i = 0; i < n; i++) {
        const Vertex &a = d[i], &b = d[(i + 1) % n];
        twice += a.x * b.y - b.x * a.y;
    }
    return twice / 2;
}

// Stokes' flow near a cylinder [paper, the equations for v_f,r and v_f,theta].
void stokes_flow(double x, double y, double radius, double& u, double& v) {
    const double r = std::sqrt(x * x + y * y);
    u = v = 0;
    if (r <= radius) return;
    const double cosine = x / r, sine = y / r;
    const double logarithm = std::log(r / radius);
    const double dipole = 0.5 - 0.5 * radius * radius / (r * r);
    const double radial = (logarithm - dipole) * cosine;
    const double tangential = -(logarithm + dipole) * sine;
    u = radial * cosine - tangential * sine;
    v = radial * sine + tangential * cosine;
}

// Fills the forces; true when a vertex feels the wall [paper, eqns for U_s, U_gamma, U_w, F_f].
bool compute_forces(Droplet& d, const Model& m, double equilibrium_area, double equilibrium_edge) {
    const int n = d.size();
    const double radius = 1 / m.size_ratio, drag = m.capillary * m.line_tension;
    const double pressure = -m.area_stiffness * (signed_area(d) - equilibrium_area);
    for (int i = 0; i < n; i++) {
        const Vertex &before = d[(i + n - 1) % n], &after = d[(i + 1) % n];
        d[i].fx = pressure * 0.5 * (after.y - before.y);
        d[i].fy = pressure * 0.5 * (before.x - after.x);
    }
    for (int i = 0; i < n; i++) {
        Vertex &a = d[i], &b = d[(i + 1) % n];
        const double dx = b.x - a.x, dy = b.y - a.y;
        const double length = std::sqrt(dx * dx + dy * dy);
        const double tension =
            (m.edge_stiffness * n * (length - equilibrium_edge) + m.line_tension) / length;
        a.fx += tension * dx;
        a.fy += tension * dy;
        b.fx -= tension * dx;
        b.fy -= tension * dy;
    }
    bool touches = false;
    for (Vertex& c : d) {
        const double r = std::sqrt(c.x * c.x + c.y * c.y);
        const double overlap = 1 - 2 * (r - radius) / equilibrium_edge;
        if (overlap > 0) {
            touches = true;
            const double repulsion = m.wall_stiffness * overlap * 2 / equilibrium_edge;
            c.fx += repulsion * c.x / r;
            c.fy += repulsion * c.y / r;
        }
        double u, v;
        stokes_flow(c.x, c.y, radius, u, v);
        c.fx += drag / n * u;
        c.fy += drag / n * v;
    }
    return touches;
}

// Thinnest chord whose shorter arc exceeds the fraction `separation` of the perimeter.
double neck(const Droplet& d, double separation) {
    const int n = d.size();
    std::vector<double> arc(n + 1, 0.0);
    for (int i = 0; i < n; i++) {
        const Vertex &a = d[i], &b = d[(i + 1) % n];
        arc[i + 1] = arc[i] + std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
    }
    double thinnest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < n; i++) {
        for (int j = i + 1; j < n; j++) {
            const double one_way = arc[j] - arc[i];
            const double shorter = std::fmin(one_way, arc[n] - one_way);
            if (shorter <= separation * arc[n]) continue;
            const double dx = d[j].x - d[i].x, dy = d[j].y - d[i].y;
            const double distance = std::sqrt(dx * dx + dy * dy);
            if (distance < thinnest) thinnest = distance;
        }
    }
    return thinnest;
}

// Centre of the enclosed area.
void centroid(const Droplet& d, double& x, double& y) {
    const int n = d.size();
    x = y = 0;
    for (int i = 0; i < n; i++) {
        const Vertex &a = d[i], &b = d[(i + 1) % n];
        x += (a.x + b.x) * (a.x * b.y - b.x * a.y) / 6;
        y += (a.y + b.y) * (a.x * b.y - b.x * a.y) / 6;
    }
    x /= signed_area(d);
    y /= signed_area(d);
}

// Velocity of the droplet's centre of mass: the mass sits on the vertices, the same on each.
void mean_velocity(const Droplet& d, double& vx, double& vy) {
    vx = vy = 0;
    for (const Vertex& p : d) {
        vx += p.vx / d.size();
        vy += p.vy / d.size();
    }
}

// S = 1 - |A_left - A_right| / A about the line through the origin along (vx, vy) [eq. symdef].
double symmetry(const Droplet& d, double vx, double vy) {
    const int n = d.size();
    const double speed = std::sqrt(vx * vx + vy * vy), c = vx / speed, s = vy / speed;
    double left = 0;  // the area above the line, in the frame where the line is the x axis
    for (int i = 0; i < n; i++) {
        const Vertex &a = d[i], &b = d[(i + 1) % n];
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
    const double area = signed_area(d);
    return 1 - std::fabs(2 * left - area) / area;
}

// Vertices to even places along the outline, on the parabola through each and its neighbours, with
// the velocity that the outline has there.
void space_evenly(Droplet& d) {
    const int n = d.size();
    std::vector<double> arc(n + 1, 0.0);
    for (int i = 0; i < n; i++)
        arc[i + 1] = arc[i] + std::hypot(d[(i + 1) % n].x - d[i].x, d[(i + 1) % n].y - d[i].y);
    double mean = 0;
    for (int i = 0; i < n; i++) mean += (arc[n] * i / n - arc[i]) / n;
    const Droplet old = d;
    for (int i = 0; i < n; i++) {
        const double s = arc[n] * i / n - arc[i] - mean;
        const Vertex &p = old[(i + n - 1) % n], &q = old[i], &r = old[(i + 1) % n];
        const double a = std::hypot(q.x - p.x, q.y - p.y), b = std::hypot(r.x - q.x, r.y - q.y);
        const auto moved = [&](double before, double here, double after) {
            const double in = (here - before) / a, out = (after - here) / b;
            return here + s * (b * in + a * out) / (a + b) + s * s * (out - in) / (a + b);
        };
        d[i].x = moved(p.x, q.x, r.x);
        d[i].y = moved(p.y, q.y, r.y);
        d[i].vx = moved(p.vx, q.vx, r.vx);
        d[i].vy = moved(p.vy, q.vy, r.vy);
    }
}

Result collide(const Model& m) {
    const double pi = std::acos(-1.0), radius = 1 / m.size_ratio, dt = m.time_step;
    const double drag = m.capillary * m.line_tension, area = pi / 4;
    const double edge = std::sqrt(4 * area * std::tan(pi / m.vertices) / m.vertices);
    const int n = m.vertices;
    Droplet d(n);
    for (int i = 0; i < n; i++) {
        const double corner = edge / (2 * std::sin(pi / n)), angle = 2 * pi * (i + 0.5) / n;
        d[i].x = -m.start_distance + corner * std::cos(angle);
        d[i].y = m.offset + corner * std::sin(angle);
        d[i].vx = d[i].vy = 0;
    }
    Result result;
    compute_forces(d, m, area, edge);
    const long last = std::lround(m.time_limit / dt);
    while (result.steps < last) {
        // Velocity Verlet, mass 1/n a vertex; the drag's velocity is implicit in the second half,
        // which keeps the scheme second order in the time step.
        for (Vertex& p : d) {
            p.vx += dt / 2 * (n * p.fx - drag * p.vx);
            p.vy += dt / 2 * (n * p.fy - drag * p.vy);
            p.x += dt * p.vx;
            p.y += dt * p.vy;
        }
        if (m.evenly) space_evenly(d);
        const bool touches = compute_forces(d, m, area, edge);
        for (Vertex& p : d) {
            p.vx = (p.vx + dt / 2 * n * p.fx) / (1 + dt / 2 * drag);
            p.vy = (p.vy + dt / 2 * n * p.fy) / (1 + dt / 2 * drag);
        }
        result.steps++;
        result.end_time = result.steps * dt;
        if (touches && std::isnan(result.contact_time)) {
            double x, y, vx, vy;
            centroid(d, x, y);
            mean_velocity(d, vx, vy);
            result.contact_time = result.end_time;
            result.contact_speed = std::sqrt(vx * vx + vy * vy);
            result.impact_parameter = std::fabs(x * vy - y * vx) / result.contact_speed;
            result.symmetry = symmetry(d, vx, vy);
        }
        if (result.steps % m.check_every != 0) continue;
        const double thickness = neck(d, m.neck_separation);
        result.minimum_neck = std::fmin(result.minimum_neck, thickness);
        if (thickness < m.neck_thickness) {
            result.outcome = "broke";
            return result;
        }
        bool past = true;
        for (const Vertex& p : d) past = past && p.x > radius + 0.5;
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
    if (count > 7) m.line_tension = std::atof(argument[7]);
    m.edge_stiffness = (count > 8 ? std::atof(argument[8]) : 3.0) * m.line_tension;
    m.area_stiffness = 5e3 * m.line_tension;
    m.wall_stiffness = 1.25 * m.line_tension;
    if (count > 9) m.evenly = std::atoi(argument[9]) != 0;
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
    print_number("end_time", result.end_time);
    print_number("steps", result.steps);
    print_number("seconds", seconds.count());
    print_number("vertex_updates_per_s", updates / seconds.count());
    std::printf("}\n");
}
