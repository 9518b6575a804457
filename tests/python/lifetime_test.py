"""Signals, fork() and the end of the interpreter, each in a process of its own."""

SEALED = """
import os, signal, sys, threading, time
import leeway
problem = leeway.load("problems/unsolvable/sealed.yaml")
def endless():
    leeway.plan(problem, time=1000, iterations=0)
"""


def test_ctrl_c_ends_a_plan(run):
    out = run(SEALED + """
threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
start = time.monotonic()
try:
    endless()
except KeyboardInterrupt:
    print("interrupted", time.monotonic() - start < 20)
""")
    assert out == "interrupted True\n"


def test_ctrl_c_ends_many_plans_and_batches(run):
    out = run(SEALED + """
import numpy
scene = leeway.Scene(leeway.load("problems/shelf/reach.yaml"))
states = numpy.random.default_rng(1).uniform(-1, 1, (3000000, 7))
for call in (lambda: leeway.plan_many([problem] * 3, time=1000, iterations=0, threads=2), lambda: scene.clearances(states)):
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    try:
        call()
    except KeyboardInterrupt:
        print("interrupted")
""")
    assert out == "interrupted\n" * 2


def test_the_interpreter_may_end_during_plans(run):
    run(SEALED + """
for _ in range(3):
    threading.Thread(target=endless, daemon=True).start()
time.sleep(0.3)
print("end", flush=True)
""")


def test_a_call_during_the_end_is_refused(run):
    run(SEALED + """
def again():
    while True:
        try:
            endless()
        except RuntimeError:
            pass
threading.Thread(target=again, daemon=True).start()
time.sleep(0.2)
sys.exit(7)
""", status=7)


def test_a_fork_plans_unless_its_parent_was_planning(run):
    out = run(SEALED + """
shelf = leeway.load("problems/shelf/reach.yaml")
path = leeway.plan(shelf).path
def child(work):
    pid = os.fork()
    if pid == 0:
        try:
            os._exit(work())
        except BaseException as error:
            print(type(error).__name__, error, flush=True)
            os._exit(3)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
print(child(lambda: int(leeway.plan(shelf).path.tobytes() != path.tobytes())), flush=True)
thread = threading.Thread(target=endless, daemon=True)
thread.start()
time.sleep(0.3)
print(child(lambda: bool(leeway.plan(shelf))), flush=True)
""")
    lines = out.splitlines()
    assert lines[0] == "0"
    assert lines[1].startswith("RuntimeError leeway: the process was forked") and lines[2] == "3"


def test_modules_may_be_reloaded_and_objects_die_in_any_order(run):
    run("""
import importlib, leeway
importlib.reload(leeway)
robot = leeway.Robot("robots/arm7/arm7.urdf", "robots/arm7/arm7.srdf", group="arm")
shape = leeway.Shape.mesh("problems/mesh/meshes/tote.obj")
keep = [shape.vertices, leeway.plan(robot, None, "ready", "tucked"), robot]
del robot, shape
import sys
sys.keep = keep
""")
