#!/usr/bin/env python3
"""Compares the Python module with the same work in C++ (bench_python.cc).

    cmake --build build --target leeway_python bench_python
    PYTHONPATH=build/python python3 python/bench/bench.py build/python/bench_python

Prints least times, in the same run; on a busy machine run it several times. Pin it to two cores: taskset -c 0,1.
"""

import subprocess
import sys
import tempfile
import threading
import time

import numpy as np

import leeway

PROBLEM = "problems/table/posts.yaml"


def least(call, rounds):
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times), sorted(times)[len(times) // 2]


def in_threads(call, count):
    threads = [threading.Thread(target=call) for _ in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def main():
    problem = leeway.load(PROBLEM)
    robot, scene = problem.robot, leeway.Scene(problem)
    states = np.random.default_rng(1).uniform(robot.lower, robot.upper, (100_000, len(robot.joint_names)))
    with tempfile.NamedTemporaryFile() as file:
        states.tofile(file)
        file.flush()
        lines = subprocess.run([sys.argv[1], PROBLEM, file.name], capture_output=True, text=True, check=True).stdout.splitlines()
    cpp = {line.split()[0]: [float(x) for x in line.split()[1:]] for line in lines}
    assert scene.valid(states).sum() == cpp["valid"][0]
    batch = least(lambda: scene.valid(states), 7)[0]
    print(f"100,000 states in one call: {batch * 1e3:.1f} ms, in C++ {cpp['states'][0] * 1e3:.1f} ms: {batch / cpp['states'][0]:.3f} of it")
    one = least(lambda: scene.valid(states[0]), 20_000)
    print(f"one state: {one[1] * 1e6:.2f} us, in C++ {cpp['state'][1] * 1e6:.2f} us")
    plan = least(lambda: leeway.plan(problem), 300)
    print(f"a plan: {plan[1] * 1e6:.1f} us, in C++ {cpp['plan'][1] * 1e6:.1f} us: {(plan[1] - cpp['plan'][1]) * 1e6:.1f} us more")

    def many():
        for _ in range(200):
            leeway.plan(problem)

    single, double = least(many, 5)[0], least(lambda: in_threads(many, 2), 5)[0]
    print(f"200 plans: {single * 1e3:.0f} ms in one thread; twice 200 in two threads {double * 1e3:.0f} ms: {double / single:.2f} of it")


if __name__ == "__main__":
    main()
