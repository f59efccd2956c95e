"""The collision of `collision.cpp` in NumPy, one array operation after another.

Usage: python collision_numpy.py [vertices] [steps] [simulation capillary number] [offset]
[size ratio] [time step]; prints one JSON object. It stops after `steps` steps when that is not 0,
because a whole collision takes some 8 s.
"""

import json
import sys
import time

import numpy as np

LINE_TENSION = 80.0
EDGE_STIFFNESS = 3 * LINE_TENSION
AREA_STIFFNESS = 5e3 * LINE_TENSION
WALL_STIFFNESS = 1.25 * LINE_TENSION
START_DISTANCE = 5.0
TIME_LIMIT = 30.0
NECK_THICKNESS = 0.167
NECK_SEPARATION = 0.28
CHECK_EVERY = 100


def signed_area(x, y):
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


def stokes_flow(x, y, r, radius):
    cosine, sine = x / r, y / r
    logarithm = np.log(r / radius)
    dipole = 0.5 - 0.5 * (radius / r) ** 2
    radial = (logarithm - dipole) * cosine
    tangential = -(logarithm + dipole) * sine
    flow = np.stack([radial * cosine - tangential * sine, radial * sine + tangential * cosine])
    return np.where(r > radius, flow, 0.0)


def compute_forces(position, drag, radius, rest_area, rest_length):
    """Forces (2, n) without the drag's velocity part, and whether a vertex feels the wall."""
    n = position.shape[1]
    before, after = np.roll(position, 1, axis=1), np.roll(position, -1, axis=1)
    pressure = -AREA_STIFFNESS * (signed_area(*position) - rest_area)
    force = 0.5 * pressure * np.stack([after[1] - before[1], before[0] - after[0]])
    edge = after - position
    length = np.sqrt(edge[0] ** 2 + edge[1] ** 2)
    pull = edge * ((EDGE_STIFFNESS * n * (length - rest_length) + LINE_TENSION) / length)
    force += pull - np.roll(pull, 1, axis=1)
    r = np.sqrt(position[0] ** 2 + position[1] ** 2)
    overlap = np.maximum(0.0, 1 - 2 * (r - radius) / rest_length)
    force += position * (WALL_STIFFNESS * overlap * 2 / rest_length / r)
    force += drag / n * stokes_flow(*position, r, radius)
    return force, overlap.any()


def neck(position):
    edge = np.roll(position, -1, axis=1) - position
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*edge))])
    one_way = np.abs(arc[:-1, None] - arc[None, :-1])
    shorter = np.minimum(one_way, arc[-1] - one_way)
    difference = position[:, :, None] - position[:, None, :]
    distance = np.sqrt((difference**2).sum(axis=0))
    return distance[shorter > NECK_SEPARATION * arc[-1]].min(initial=np.inf)


def symmetry(position, velocity):
    """S about the line through the origin along `velocity` [paper, eq. symdef]."""
    c, s = velocity / np.hypot(*velocity)
    x, y = np.array([[c, s], [-s, c]]) @ position
    x2, y2 = np.roll(x, -1), np.roll(y, -1)
    crosses = y * y2 < 0
    crossing = x - y * (x2 - x) / np.where(crosses, y2 - y, 1.0)
    xa, xb = np.where(crosses & (y < 0), crossing, x), np.where(crosses & (y2 < 0), crossing, x2)
    left = -0.5 * ((xb - xa) * (np.maximum(y, 0) + np.maximum(y2, 0))).sum()
    area = signed_area(x, y)
    return 1 - abs(2 * left - area) / area


def collide(vertices, capillary, offset, size_ratio, time_step, most_steps):
    n, dt, radius = vertices, time_step, 1 / size_ratio
    drag, area = capillary * LINE_TENSION, np.pi / 4
    edge = np.sqrt(4 * area * np.tan(np.pi / n) / n)
    angle = 2 * np.pi * (np.arange(n) + 0.5) / n
    r = edge / (2 * np.sin(np.pi / n)) * np.stack([np.cos(angle), np.sin(angle)])
    r += [[-START_DISTANCE], [offset]]
    v = np.zeros_like(r)
    result = {"outcome": "captured", "symmetry": None, "contact_time": None}
    force, _ = compute_forces(r, drag, radius, area, edge)
    thinnest = np.inf
    for step in range(1, most_steps + 1):
        v += dt / 2 * (n * force - drag * v)
        r += dt * v
        force, touches = compute_forces(r, drag, radius, area, edge)
        v = (v + dt / 2 * n * force) / (1 + dt / 2 * drag)
        if touches and result["contact_time"] is None:
            result |= {"symmetry": symmetry(r, v.mean(axis=1)), "contact_time": step * dt}
        if step % CHECK_EVERY:
            continue
        thinnest = min(thinnest, neck(r))
        if thinnest < NECK_THICKNESS:
            result["outcome"] = "broke"
            break
        if r[0].min() > radius + 0.5:
            result["outcome"] = "slipped"
            break
    return result | {"minimum_neck": thinnest, "steps": step}


def main(arguments):
    kinds = (int, int, float, float, float, float)
    given = [kind(text) for kind, text in zip(kinds, arguments, strict=False)]
    defaults = [64, 0, 20.0, 0.05, 5.66, 1e-4]
    vertices, steps, *model = given + defaults[len(given) :]
    start = time.perf_counter()
    result = collide(vertices, *model, steps or round(TIME_LIMIT / model[-1]))
    seconds = time.perf_counter() - start
    result["seconds"] = seconds
    result["vertex_updates_per_s"] = result["steps"] * vertices / seconds
    print(json.dumps(result))


if __name__ == "__main__":
    main(sys.argv[1:])
