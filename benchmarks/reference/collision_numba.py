"""The collision of `collision.cpp` as loops under numba: what a researcher writes in an afternoon.

Usage: python collision_numba.py [vertices] [steps] [simulation capillary number] [offset]
[size ratio] [time step]; prints one JSON object, compilation excluded from the time.
"""

import json
import math
import sys
import time

import numpy as np
from numba import njit

LINE_TENSION = 80.0
EDGE_STIFFNESS = 3 * LINE_TENSION
AREA_STIFFNESS = 5e3 * LINE_TENSION
WALL_STIFFNESS = 1.25 * LINE_TENSION
START_DISTANCE = 5.0
TIME_LIMIT = 30.0
NECK_THICKNESS = 0.167
NECK_SEPARATION = 0.28
CHECK_EVERY = 100
OUTCOMES = ("captured", "slipped", "broke")


@njit
def signed_area(r):
    twice = 0.0
    for i in range(len(r)):
        j = (i + 1) % len(r)
        twice += r[i, 0] * r[j, 1] - r[j, 0] * r[i, 1]
    return twice / 2


@njit
def compute_forces(r, force, drag, radius, rest_area, rest_length):
    n = len(r)
    pressure = -AREA_STIFFNESS * (signed_area(r) - rest_area)
    for i in range(n):
        before, after = (i - 1) % n, (i + 1) % n
        force[i, 0] = pressure * 0.5 * (r[after, 1] - r[before, 1])
        force[i, 1] = pressure * 0.5 * (r[before, 0] - r[after, 0])
    touches = False
    for i in range(n):
        j = (i + 1) % n
        dx, dy = r[j, 0] - r[i, 0], r[j, 1] - r[i, 1]
        length = math.sqrt(dx * dx + dy * dy)
        tension = (EDGE_STIFFNESS * n * (length - rest_length) + LINE_TENSION) / length
        force[i, 0] += tension * dx
        force[i, 1] += tension * dy
        force[j, 0] -= tension * dx
        force[j, 1] -= tension * dy
        x, y = r[i, 0], r[i, 1]
        distance = math.sqrt(x * x + y * y)
        overlap = 1 - 2 * (distance - radius) / rest_length
        if overlap > 0:
            touches = True
            repulsion = WALL_STIFFNESS * overlap * 2 / rest_length
            force[i, 0] += repulsion * x / distance
            force[i, 1] += repulsion * y / distance
        if distance > radius:
            cosine, sine = x / distance, y / distance
            logarithm = math.log(distance / radius)
            dipole = 0.5 - 0.5 * radius * radius / (distance * distance)
            radial = (logarithm - dipole) * cosine
            tangential = -(logarithm + dipole) * sine
            force[i, 0] += drag / n * (radial * cosine - tangential * sine)
            force[i, 1] += drag / n * (radial * sine + tangential * cosine)
    return touches


@njit
def neck(r):
    n = len(r)
    arc = np.zeros(n + 1)
    for i in range(n):
        j = (i + 1) % n
        arc[i + 1] = arc[i] + math.hypot(r[j, 0] - r[i, 0], r[j, 1] - r[i, 1])
    thinnest = np.inf
    for i in range(n):
        for j in range(i + 1, n):
            one_way = arc[j] - arc[i]
            if min(one_way, arc[n] - one_way) > NECK_SEPARATION * arc[n]:
                dx, dy = r[j, 0] - r[i, 0], r[j, 1] - r[i, 1]
                thinnest = min(thinnest, math.sqrt(dx * dx + dy * dy))
    return thinnest


@njit
def symmetry(r, velocity):
    """S about the line through the origin along `velocity` [paper, eq. symdef]."""
    c, s = velocity / math.hypot(velocity[0], velocity[1])
    left = 0.0
    for i in range(len(r)):
        j = (i + 1) % len(r)
        xa, ya = c * r[i, 0] + s * r[i, 1], c * r[i, 1] - s * r[i, 0]
        xb, yb = c * r[j, 0] + s * r[j, 1], c * r[j, 1] - s * r[j, 0]
        if ya <= 0 and yb <= 0:
            continue
        if ya * yb < 0:
            crossing = xa - ya * (xb - xa) / (yb - ya)
            if ya < 0:
                xa, ya = crossing, 0.0
            else:
                xb, yb = crossing, 0.0
        left -= (xb - xa) * (ya + yb) / 2
    area = signed_area(r)
    return 1 - abs(2 * left - area) / area


@njit
def collide(vertices, capillary, offset, size_ratio, time_step):
    n, dt, radius = vertices, time_step, 1 / size_ratio
    drag, area = capillary * LINE_TENSION, math.pi / 4
    edge = math.sqrt(4 * area * math.tan(math.pi / n) / n)
    corner = edge / (2 * math.sin(math.pi / n))
    r, v, force = np.empty((n, 2)), np.zeros((n, 2)), np.empty((n, 2))
    for i in range(n):
        angle = 2 * math.pi * (i + 0.5) / n
        r[i, 0] = -START_DISTANCE + corner * math.cos(angle)
        r[i, 1] = offset + corner * math.sin(angle)
    contact_time, contact_symmetry, thinnest = np.nan, np.nan, np.inf
    compute_forces(r, force, drag, radius, area, edge)
    step = 0
    while step < round(TIME_LIMIT / dt):
        for i in range(n):
            for k in range(2):
                v[i, k] += dt / 2 * (n * force[i, k] - drag * v[i, k])
                r[i, k] += dt * v[i, k]
        touches = compute_forces(r, force, drag, radius, area, edge)
        for i in range(n):
            for k in range(2):
                v[i, k] = (v[i, k] + dt / 2 * n * force[i, k]) / (1 + dt / 2 * drag)
        step += 1
        if touches and math.isnan(contact_time):
            contact_time = step * dt
            contact_symmetry = symmetry(r, v.sum(axis=0) / n)
        if step % CHECK_EVERY:
            continue
        thickness = neck(r)
        thinnest = min(thinnest, thickness)
        if thickness < NECK_THICKNESS:
            return 2, contact_symmetry, contact_time, thinnest, step
        if r[:, 0].min() > radius + 0.5:
            return 1, contact_symmetry, contact_time, thinnest, step
    return 0, contact_symmetry, contact_time, thinnest, step


def main(arguments):
    kinds = (int, int, float, float, float, float)
    given = [kind(text) for kind, text in zip(kinds, arguments, strict=False)]
    defaults = [64, 0, 20.0, 0.05, 5.66, 1e-4]
    vertices, steps, *model = given + defaults[len(given) :]
    collide(16, *model[:3], 1e-3)  # compile
    taken, start = 0, time.perf_counter()
    while taken == 0 or taken < steps:
        outcome, at_contact, contact_time, thinnest, count = collide(vertices, *model)
        taken += count
    seconds = time.perf_counter() - start
    result = {
        "outcome": OUTCOMES[outcome],
        "symmetry": at_contact,
        "contact_time": contact_time,
        "minimum_neck": thinnest,
        "steps": count,
        "seconds": seconds,
        "vertex_updates_per_s": taken * vertices / seconds,
    }
    print(json.dumps({k: None if v != v else v for k, v in result.items()}))


if __name__ == "__main__":
    main(sys.argv[1:])
