#!/usr/bin/env python3
"""Derives the numbers of collision/sine_cosine.cc: minimax polynomials by Remez exchange, pi/2 in parts, 2/pi in words.

Needs mpmath. Prints each polynomial with its error before and after its coefficients are rounded to doubles.
"""
from mpmath import cos, factorial, floor, frexp, ldexp, log, lu_solve, matrix, mp, mpf, pi

mp.prec = 300
TERMS = 6
END = (pi / 4 + mpf(2) ** -20) ** 2  # the polynomials are in z = r^2, up to here


def sine_rest(z):
    """(sin r - r) / r^3, as a series: the closed form cancels."""
    return sum((-1) ** (k + 1) * z**k / factorial(2 * k + 3) for k in range(40))


def cosine_rest(z):
    """(cos r - 1 + r^2 / 2) / r^4."""
    return sum((-1) ** k * z**k / factorial(2 * k + 4) for k in range(40))


def value(coefficients, z):
    return sum(mpf(c) * z**k for k, c in enumerate(coefficients))


def extrema(error, count):
    """The largest deviation in each run of equal sign on a fine grid, the last `count` of them."""
    grid = [END * i / 1500 for i in range(1, 1501)]
    values = [error(z) for z in grid]
    found, begin = [], 0
    while begin < len(grid):
        end = begin
        while end < len(grid) and (values[end] >= 0) == (values[begin] >= 0):
            end += 1
        found.append(grid[max(range(begin, end), key=lambda i: abs(values[i]))])
        begin = end
    return found[-count:]


def remez(function, weight):
    """Coefficients that minimise max |weight (polynomial - function)| over (0, END]."""
    points = [END * (1 - cos(pi * (i + mpf(1) / 2) / (TERMS + 1))) / 2 for i in range(TERMS + 1)]
    for _ in range(30):
        system, right = matrix(TERMS + 1, TERMS + 1), matrix(TERMS + 1, 1)
        for i, z in enumerate(points):
            for k in range(TERMS):
                system[i, k] = z**k
            system[i, TERMS] = (-1) ** i / weight(z)
            right[i] = function(z)
        solution = lu_solve(system, right)
        coefficients = [solution[k] for k in range(TERMS)]
        new = extrema(lambda z: weight(z) * (value(coefficients, z) - function(z)), TERMS + 1)
        if len(new) < TERMS + 1:
            break
        moved = max(abs(a - b) for a, b in zip(new, points))
        points = new
        if moved < END / 1000:
            break
    return coefficients


def largest(function, weight, coefficients):
    return max(abs(weight(END * i / 2000) * (value(coefficients, END * i / 2000) - function(END * i / 2000)))
               for i in range(1, 2001))


def chop(x, bits):
    mantissa, exponent = frexp(x)
    return ldexp(floor(ldexp(mantissa, bits)), int(exponent) - bits)


# The error counts relative to the value: r^3 p against r, z^2 q against about 1.
for name, function, weight in (("sine", sine_rest, lambda z: z), ("cosine", cosine_rest, lambda z: z * z)):
    exact = remez(function, weight)
    rounded = [float(c) for c in exact]
    print(f"{name}: 2^{float(log(largest(function, weight, exact), 2)):.2f},"
          f" rounded 2^{float(log(largest(function, weight, rounded), 2)):.2f}")
    for c in rounded:
        print("   ", c.hex())

part1 = chop(pi / 2, 33)
part2 = chop(pi / 2 - part1, 33)
print("pi/2 in parts:", float(part1).hex(), float(part2).hex(), float(pi / 2 - part1 - part2).hex())
print("pi/2 in two doubles:", float(pi / 2).hex(), float(pi / 2 - mpf(float(pi / 2))).hex())
print("2/pi:", float(2 / pi).hex())

mp.prec = 1600
rest, words = 2 / pi, []
for _ in range(20):
    rest *= mpf(2) ** 64
    words.append(int(floor(rest)))
    rest -= words[-1]
print(", ".join(f"0x{w:016x}u" for w in words))
