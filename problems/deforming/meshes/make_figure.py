#!/usr/bin/env python3
"""Writes figure.obj: a standing figure of closed tubes, arms held out to the sides, 1.7 m tall, z up, facing x.

    problems/deforming/meshes/make_figure.py > problems/deforming/meshes/figure.obj
"""
import math

SIDES = 10


def tube(a, b, radii, rings):
    """A closed tube from a to b; `radii` from end to end, linear between."""
    axis = [q - p for p, q in zip(a, b)]
    length = math.sqrt(sum(c * c for c in axis))
    w = [c / length for c in axis]
    helper = [1, 0, 0] if abs(w[0]) < 0.5 else [0, 1, 0]
    u = [helper[1] * w[2] - helper[2] * w[1], helper[2] * w[0] - helper[0] * w[2], helper[0] * w[1] - helper[1] * w[0]]
    norm = math.sqrt(sum(c * c for c in u))
    u = [c / norm for c in u]
    v = [w[1] * u[2] - w[2] * u[1], w[2] * u[0] - w[0] * u[2], w[0] * u[1] - w[1] * u[0]]
    vertices, faces = [list(a)], []
    for i in range(rings):
        t = i / (rings - 1)
        k = t * (len(radii) - 1)
        j = min(int(k), len(radii) - 2)
        radius = radii[j] + (k - j) * (radii[j + 1] - radii[j])
        inset = 0.5 * radius * ((1 if i == 0 else 0) - (1 if i == rings - 1 else 0)) * 0.4
        for s in range(SIDES):
            angle = 2 * math.pi * s / SIDES
            vertices.append([a[c] + (t * length + inset) * w[c] + radius * (math.cos(angle) * u[c] + math.sin(angle) * v[c])
                             for c in range(3)])
    vertices.append(list(b))
    last = len(vertices) - 1
    for s in range(SIDES):
        n = (s + 1) % SIDES
        faces.append([0, 1 + n, 1 + s])
        for i in range(rings - 1):
            p, q = 1 + i * SIDES + s, 1 + i * SIDES + n
            faces += [[p, q, q + SIDES], [p, q + SIDES, p + SIDES]]
        faces.append([last, last - SIDES + s, last - SIDES + n])
    return vertices, faces


PARTS = [
    ([0, 0, 0.85], [0, 0, 1.45], [0.15, 0.13, 0.17], 10),  # trunk
    ([0, 0, 1.5], [0, 0, 1.72], [0.05, 0.1, 0.1, 0.06], 6),  # head
    ([0, 0.2, 1.38], [0, 0.82, 1.38], [0.055, 0.045, 0.04, 0.035, 0.045], 16),  # left arm
    ([0, -0.2, 1.38], [0, -0.82, 1.38], [0.055, 0.045, 0.04, 0.035, 0.045], 16),  # right arm
    ([0, 0.1, 0.83], [0, 0.1, 0.02], [0.08, 0.055, 0.05], 10),  # left leg
    ([0, -0.1, 0.83], [0, -0.1, 0.02], [0.08, 0.055, 0.05], 10),  # right leg
]

print("# A standing figure; written by make_figure.py beside this file.")
base = 1
for a, b, radii, rings in PARTS:
    vertices, faces = tube(a, b, radii, rings)
    for x in vertices:
        print("v " + " ".join(f"{c:.4f}" for c in x))
    for f in faces:
        print("f " + " ".join(str(base + i) for i in f))
    base += len(vertices)
