#!/usr/bin/python3
"""Compares the Python module with the same work in C++ (bench_python.cc).

    cmake --build build --target leeway_python bench_python
    PYTHONPATH=build/python python3 python/bench/bench.py build/python/bench_python

Prints least times, in the same run; on a busy machine run it several times. Pin it to two cores: taskset -c 0,1.
"""

import math
import multiprocessing
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
    return min(times)


def in_threads(call, count):
    threads = [threading.Thread(target=call) for _ in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def in_processes(rounds, barrier, times):
    """10 plans at a time, in each of two processes at once: what two threads are compared with."""
    problem = leeway.load(PROBLEM)
    for i in range(rounds):
        barrier.wait()
        start = time.perf_counter()
        for _ in range(10):
            leeway.plan(problem)
        times.put((i, time.perf_counter() - start))


def two_processes(rounds):
    spawn = multiprocessing.get_context("spawn")
    barrier, times = spawn.Barrier(2), spawn.Queue()
    processes = [spawn.Process(target=in_processes, args=(rounds, barrier, times)) for _ in range(2)]
    for process in processes:
        process.start()
    slower = [0.0] * rounds  # of each round the process that ends last
    for _ in range(2 * rounds):
        i, took = times.get()
        slower[i] = max(slower[i], took)
    for process in processes:
        process.join()
    return min(slower)


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
    batch = least(lambda: scene.valid(states), 7)
    print(f"100,000 states in one call: {batch * 1e3:.1f} ms, in C++ {cpp['states'][0] * 1e3:.1f} ms: {batch / cpp['states'][0]:.3f} of it")
    one = least(lambda: scene.valid(states[0]), 20_000)
    print(f"one state: {one * 1e6:.2f} us, in C++ {cpp['state'][0] * 1e6:.2f} us")
    around = math.inf
    for _ in range(500):
        start = time.perf_counter()
        result = leeway.plan(problem)
        around = min(around, time.perf_counter() - start - sum(result.times.values()))
    print(f"a plan, apart from its own times: {around * 1e6:.1f} us, in C++ {cpp['around'][0] * 1e6:.1f} us")

    def many():
        for _ in range(10):
            leeway.plan(problem)

    single = double = math.inf
    for _ in range(60):  # in turns
        single, double = min(single, least(many, 1)), min(double, least(lambda: in_threads(many, 2), 1))
    print(f"10 plans: {single * 1e3:.1f} ms in one thread; twice 10 in two threads {double * 1e3:.1f} ms: {double / single:.2f} of it")
    # What else runs on the machine slows these as much: beyond them, threads would wait for each other.
    apart = two_processes(60)
    print(f"twice 10 in two processes: {apart * 1e3:.1f} ms; threads take {double / apart:.2f} of it")


if __name__ == "__main__":
    main()
