#include "python/bindings/deforming.h"

#include <cmath>
#include <limits>

#include "leeway/collision/shape.h"
#include "python/base/busy.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/shapes.h"

namespace leeway::python {
namespace {

using collision::Deformable;
using collision::DeformableSnapshot;
using collision::UpdateStatus;
using collision::VertexMotion;

/// A deforming mesh that Python updates, one thread at a time. All but `deformable` is read and
/// written with the interpreter's lock held, so that other threads see the last good state.
struct Body {
  Deformable deformable;
  std::shared_ptr<const DeformableSnapshot> snapshot;
  collision::UpdateStatistics statistics;
  bool busy = false;

  explicit Body(Deformable made)
      : deformable(std::move(made)),
        snapshot(deformable.snapshot()),
        statistics(deformable.statistics()) {}
};

constexpr char kBusyDeformable[] = "another thread is updating this Deformable";

void take(Body& body, UpdateStatus status) {
  if (status == UpdateStatus::kUpdated) {
    body.snapshot = body.deformable.snapshot();
    body.statistics = body.deformable.statistics();
    return;
  }
  std::string message = collision::toString(status);
  if (status == UpdateStatus::kNotFinite)
    message += ": vertex " + std::to_string(body.deformable.badVertex());
  throw py::value_error(message + "; the last good state stays");
}

void update(Body& self, const py::object& vertices, double time, const py::object& bound) {
  const Busy busy(self.busy, kBusyDeformable);
  const double speed_bound = speedBoundOf(bound);
  const py::array_t<double, py::array::c_style> given =
      py::array_t<double, py::array::c_style>::ensure(vertices);
  const auto count = static_cast<py::ssize_t>(self.deformable.mesh()->vertexCount());
  if (!given || given.ndim() != 2 || given.shape(0) != count || given.shape(1) != 3) {
    PyErr_Clear();
    throw py::value_error("vertices are not an array of numbers of shape (" +
                          std::to_string(count) + ", 3)");
  }
  // The only copy, straight to where the update reads them.
  const std::span<Eigen::Vector3d> next = self.deformable.nextVertices();
  std::copy(given.data(), given.data() + given.size(), next.front().data());
  take(self, released([&] { return self.deformable.commit(time, speed_bound); }));
}

void follow(Body& self, double time) {
  const Busy busy(self.busy, kBusyDeformable);
  take(self, released([&] { return self.deformable.update(time); }));
}

Body makeBody(const py::object& vertices, const py::object& faces, const py::object& motion,
              const py::object& strategy, int expected_queries) {
  const auto mesh = deformableMesh(vertices, faces);
  const auto moves = motionOf(motion);
  collision::DeformOptions options;
  options.strategy = strategyOf(strategy);
  options.expected_queries = expected_queries;
  return released([&] { return Body(Deformable(mesh, moves, options)); });
}

std::vector<double> increasingTimes(const py::object& value) {
  Rows times = scalars(value, "times");
  if (times.shape.size() != 1) throw py::value_error("times are no row of numbers");
  return times.values;
}

/// As many numbers as `count`; without a value so many times `otherwise`.
std::vector<double> row(const py::object& value, const char* name, std::size_t count,
                        double otherwise) {
  if (value.is_none()) return std::vector<double>(count, otherwise);
  return numbers(value, name, count);
}

/// Points of shape (count, n, 3), as `count` lists.
std::vector<std::vector<Eigen::Vector3d>> pointLists(const py::object& value, const char* name,
                                                     const char* shape) {
  const Rows given = rows(value, name, 3, 3);
  if (given.shape.size() != 2)
    throw py::value_error(std::string(name) + " do not have shape " + shape);
  std::vector<std::vector<Eigen::Vector3d>> lists(static_cast<std::size_t>(given.shape[0]));
  const auto length = static_cast<std::size_t>(given.shape[1]);
  for (std::size_t i = 0; i < given.count(); ++i)
    lists[i / length].push_back(Eigen::Vector3d::Map(given.row(i).data()));
  return lists;
}

collision::Interpolation interpolation(bool smooth) {
  return smooth ? collision::Interpolation::kSmooth : collision::Interpolation::kLinear;
}

Motion cache(const py::object& times, const py::object& positions) {
  collision::CacheMotion motion;
  motion.times = increasingTimes(times);
  const Rows frames = rows(positions, "positions", 3, 3);
  if (frames.shape.size() != 2 || frames.shape[0] != static_cast<py::ssize_t>(motion.times.size()))
    throw py::value_error("positions do not have shape (times, vertices, 3) with " +
                          std::to_string(motion.times.size()) + " times");
  motion.vertex_count = static_cast<int>(frames.shape[1]);
  for (std::size_t i = 0; i < frames.count(); ++i)
    motion.positions.push_back(Eigen::Vector3d::Map(frames.row(i).data()));
  return {VertexMotion::cache(std::move(motion))};
}

Motion morph(const py::object& references, const py::object& times, const py::object& weights,
             bool smooth) {
  collision::MorphMotion motion;
  motion.references = pointLists(references, "references", "(references, vertices, 3)");
  motion.interpolation = interpolation(smooth);
  const std::size_t count = motion.references.size();
  const std::vector<double> keys = increasingTimes(times);
  const Rows shares = rows(weights, "weights", count, 2);
  if (shares.shape.size() != 1 || shares.count() != keys.size())
    throw py::value_error("weights do not have shape (times, references)");
  for (std::size_t i = 0; i < keys.size(); ++i)
    motion.keys.push_back({keys[i], {shares.row(i).begin(), shares.row(i).end()}});
  return {VertexMotion::morph(std::move(motion))};
}

Motion wave(const py::object& rest, const py::object& direction, const py::object& amplitude,
            double wavelength, double frequency, double phase) {
  collision::WavesMotion motion;
  motion.rest = points(rest, "rest");
  motion.waves.push_back({vector3(direction, "direction"), vector3(amplitude, "amplitude"),
                          wavelength, frequency, phase});
  return {VertexMotion::waves(std::move(motion))};
}

Motion waves(const py::object& rest, const py::object& directions, const py::object& amplitudes,
             const py::object& wavelengths, const py::object& frequencies, const py::object& phases,
             const py::object& pinned) {
  collision::WavesMotion motion;
  motion.rest = points(rest, "rest");
  const std::vector<Eigen::Vector3d> travel = points(directions, "directions");
  const std::vector<Eigen::Vector3d> height = points(amplitudes, "amplitudes");
  if (travel.size() != height.size())
    throw py::value_error("amplitudes are " + std::to_string(height.size()) + "; one of each of " +
                          std::to_string(travel.size()) + " directions is expected");
  const std::vector<double> lengths = row(wavelengths, "wavelengths", travel.size(), 0);
  const std::vector<double> rates = row(frequencies, "frequencies", travel.size(), 0);
  const std::vector<double> shifts = row(phases, "phases", travel.size(), 0);
  for (std::size_t i = 0; i < travel.size(); ++i)
    motion.waves.push_back({travel[i], height[i], lengths[i], rates[i], shifts[i]});
  if (!pinned.is_none()) {
    const auto edge = py::list(pinned);
    if (edge.size() != 3)
      throw py::value_error("pinned holds " + std::to_string(edge.size()) +
                            " values; (point, direction, length) is expected");
    motion.pinned = {vector3(edge[0], "pinned point"), vector3(edge[1], "pinned direction"),
                     number(edge[2], "pinned length")};
  }
  return {VertexMotion::waves(std::move(motion))};
}

Motion lattice(const py::object& rest, const py::object& lower, const py::object& upper,
               const py::object& times, const py::object& control_points, bool smooth) {
  collision::LatticeMotion motion;
  motion.rest = points(rest, "rest");
  motion.box_lower = vector3(lower, "lower");
  motion.box_upper = vector3(upper, "upper");
  motion.interpolation = interpolation(smooth);
  const std::vector<double> keys = increasingTimes(times);
  const Rows grid = rows(control_points, "control_points", 3, 5);
  if (grid.shape.size() != 4 || grid.shape[0] != static_cast<py::ssize_t>(keys.size()))
    throw py::value_error("control_points do not have shape (times, x, y, z, 3) with " +
                          std::to_string(keys.size()) + " times");
  std::size_t along[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    along[axis] = static_cast<std::size_t>(grid.shape[axis + 1]);
    if (along[axis] < 2 || along[axis] > 17)
      throw py::value_error("control_points have " + std::to_string(along[axis]) + " along axis " +
                            std::to_string(axis) + "; 2 to 17 are expected");
    motion.cells[axis] = static_cast<int>(along[axis]) - 1;
  }
  for (std::size_t t = 0; t < keys.size(); ++t) {
    motion.keys.push_back({keys[t], {}});
    for (std::size_t z = 0; z < along[2]; ++z)
      for (std::size_t y = 0; y < along[1]; ++y)
        for (std::size_t x = 0; x < along[0]; ++x)
          motion.keys[t].control_points.push_back(Eigen::Vector3d::Map(
              grid.row(((t * along[0] + x) * along[1] + y) * along[2] + z).data()));
  }
  return {VertexMotion::lattice(std::move(motion))};
}

collision::SkinnedMotion::BonePose bonePose(std::span<const double> values) {
  return {{values[0], values[1], values[2]}, {values[3], values[4], values[5], values[6]}};
}

Motion skinned(const py::object& rest, const py::object& parents, const py::object& rest_poses,
               const py::object& weights, const py::object& times, const py::object& poses,
               bool smooth) {
  collision::SkinnedMotion motion;
  motion.rest = points(rest, "rest");
  motion.interpolation = interpolation(smooth);
  const Rows stands = rows(rest_poses, "rest_poses", 7, 2);
  if (stands.shape.size() != 1) throw py::value_error("rest_poses do not have shape (bones, 7)");
  const std::size_t bones = stands.count();
  const std::vector<double> above = numbers(parents, "parents", bones);
  for (std::size_t b = 0; b < bones; ++b) {
    if (above[b] != std::floor(above[b]) || above[b] < -1 || above[b] >= static_cast<double>(b))
      throw py::value_error("parents[" + std::to_string(b) + "] is " + text(above[b]) +
                            "; an earlier bone or -1 is expected");
    motion.bones.push_back({static_cast<int>(above[b]), bonePose(stands.row(b))});
  }
  const Rows shares = rows(weights, "weights", bones, 2);
  if (shares.shape.size() != 1 || shares.count() != motion.rest.size())
    throw py::value_error("weights do not have shape (vertices, bones)");
  for (std::size_t v = 0; v < shares.count(); ++v)
    for (std::size_t b = 0; b < bones; ++b)
      if (const double weight = shares.row(v)[b]; weight != 0)
        motion.weights.push_back({static_cast<int>(v), static_cast<int>(b), weight});
  const std::vector<double> keys = increasingTimes(times);
  const Rows placed = rows(poses, "poses", 7, 3);
  if (placed.shape.size() != 2 || placed.shape[0] != static_cast<py::ssize_t>(keys.size()) ||
      placed.shape[1] != static_cast<py::ssize_t>(bones))
    throw py::value_error("poses do not have shape (times, bones, 7)");
  for (std::size_t t = 0; t < keys.size(); ++t) {
    motion.keys.push_back({keys[t], {}});
    for (std::size_t b = 0; b < bones; ++b)
      motion.keys[t].poses.push_back(bonePose(placed.row(t * bones + b)));
  }
  return {VertexMotion::skinned(std::move(motion))};
}

Motion reduced(const py::object& rest, const py::object& modes, const py::object& amplitudes,
               const py::object& frequencies, const py::object& phases, const py::object& times,
               const py::object& coordinates, bool smooth) {
  collision::ReducedMotion motion;
  motion.rest = points(rest, "rest");
  motion.modes = pointLists(modes, "modes", "(modes, vertices, 3)");
  motion.interpolation = interpolation(smooth);
  const std::size_t count = motion.modes.size();
  if (frequencies.is_none() == coordinates.is_none())
    throw py::value_error("either frequencies, or times and coordinates are expected");
  if (!frequencies.is_none()) {
    const std::vector<double> rates = numbers(frequencies, "frequencies", count);
    const std::vector<double> sizes = row(amplitudes, "amplitudes", count, 1);
    const std::vector<double> shifts = row(phases, "phases", count, 0);
    for (std::size_t i = 0; i < count; ++i)
      motion.harmonics.push_back({sizes[i], rates[i], shifts[i]});
    return {VertexMotion::reduced(std::move(motion))};
  }
  const std::vector<double> keys = increasingTimes(times);
  const Rows given = rows(coordinates, "coordinates", count, 2);
  if (given.shape.size() != 1 || given.count() != keys.size())
    throw py::value_error("coordinates do not have shape (times, modes)");
  for (std::size_t i = 0; i < keys.size(); ++i)
    motion.keys.push_back({keys[i], {given.row(i).begin(), given.row(i).end()}});
  return {VertexMotion::reduced(std::move(motion))};
}

void defineMotion(py::module_& module) {
  py::class_<Motion> motion(module, "Motion",
                            "Where the vertices of a mesh are at any time: constant. With it, "
                            "execution looks ahead, and updates read fewer vertices.");
  defineStatic(motion, "cache", "(times, positions)",
               "Recorded positions (times, vertices, 3) [m] at increasing `times` [s], linear in "
               "between, held before and after.",
               cache);
  defineStatic(motion, "morph", "(references, times, weights, *, smooth=False)",
               "Blends references (references, vertices, 3) [m] by weights (times, references) at "
               "`times` [s].",
               morph);
  defineStatic(motion, "wave", "(rest, direction, amplitude, wavelength, frequency, phase=0.0)",
               "A travelling wave over the rest positions (vertices, 3) [m]: direction (3,), "
               "amplitude (3,) [m], wavelength [m], frequency [Hz], phase [rad].",
               wave);
  defineStatic(motion, "waves",
               "(rest, directions, amplitudes, wavelengths, frequencies, phases=None, *, "
               "pinned=None)",
               "Several waves at once: directions (n, 3), amplitudes (n, 3) [m], wavelengths (n,) "
               "[m], frequencies (n,) [Hz], phases (n,) [rad]. pinned=(point, direction, length) "
               "holds an edge still: waves grow from it along `direction` over `length` [m].",
               waves);
  defineStatic(motion, "lattice", "(rest, lower, upper, times, control_points, *, smooth=False)",
               "Free-form deformation: the box from `lower` to `upper` (3,) [m], which holds all "
               "rest positions, has control points (times, x, y, z, 3) [m], 2 to 17 along each "
               "axis, at `times` [s]. At their grid places they leave the mesh undeformed.",
               lattice);
  defineStatic(motion, "skinned",
               "(rest, parents, rest_poses, weights, times, poses, *, smooth=False)",
               "Linear blend skinning: bones with `parents` (bones,), an earlier bone or -1, rest "
               "poses (bones, 7) and poses (times, bones, 7), each x y z qx qy qz qw in the "
               "parent's frame; weights (vertices, bones), of which zeros count nothing.",
               skinned);
  defineStatic(motion, "reduced",
               "(rest, modes, *, amplitudes=None, frequencies=None, phases=None, times=None, "
               "coordinates=None, smooth=False)",
               "Rest positions plus modes (modes, vertices, 3) [m], each times its coordinate: "
               "amplitude sin(2 pi frequency t + phase), or coordinates (times, modes) at `times` "
               "[s].",
               reduced);
  define(motion, "at", "(self, time)", "The vertices at a time [s]: (vertices, 3) [m].",
         [](const Motion& self, const py::object& time) {
           const double when = number(time, "time");
           const auto count = static_cast<std::size_t>(self.value->vertexCount());
           std::vector<Eigen::Vector3d> positions(count);
           self.value->evaluate(when, positions);
           std::vector<double> values(positions.front().data(),
                                      positions.front().data() + 3 * count);
           return array(std::move(values), {static_cast<py::ssize_t>(count), 3});
         });
  motion.def("__repr__", [](const Motion& self) {
    return std::string("<leeway.Motion, ") + toString(self.value->kind()) + ", of " +
           std::to_string(self.value->vertexCount()) + " vertices>";
  });
}

}  // namespace

std::shared_ptr<const collision::DeformableMesh> deformableMesh(const py::object& vertices,
                                                                const py::object& faces) {
  const std::vector<Eigen::Vector3d> rest = points(vertices, "vertices");
  const auto indices = triangles(faces, "triangles");
  return released([&] { return collision::DeformableMesh::make(rest, indices); });
}

std::shared_ptr<const VertexMotion> motionOf(const py::object& motion) {
  if (motion.is_none()) return nullptr;
  if (!py::isinstance<Motion>(motion))
    throw py::type_error(std::string("motion is of type ") + Py_TYPE(motion.ptr())->tp_name +
                         "; a Motion is expected");
  return motion.cast<const Motion&>().value;
}

double speedBoundOf(const py::object& value, const char* name) {
  if (value.is_none()) return std::numeric_limits<double>::infinity();
  const double bound = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a number or None is expected");
  }
  if (!(bound >= 0))
    throw py::value_error(std::string(name) + " is " + text(bound) + "; at least 0 is expected");
  return bound;
}

collision::DeformStrategy strategyOf(const py::object& word) {
  const std::string name = py::str(word);
  const auto strategy = collision::deformStrategy(name);
  if (!strategy)
    unknownWord("strategy", name,
                "auto, hybrid, refit, restructure, rebuild, rebuild-linear, lazy, octree, morph, "
                "skinned or reduced");
  return *strategy;
}

void defineDeforming(py::module_& module) {
  defineMotion(module);
  const std::string init =
      "(vertices, triangles, *, motion=None, strategy='auto', expected_queries=12)";
  auto body = defineClass<py::class_<Body>>(
      module, "Deformable", init,
      "A mesh whose vertices move. One thread updates it; `shape` is constant and "
      "for any thread.\n\n`vertices` (n, 3) are those at rest [m], `triangles` "
      "(m, 3) indices. `strategy` says how its hierarchy follows; no choice changes "
      "an answer.",
      makeBody);
  define(body, "update", "(self, vertices, time=0.0, speed_bound=None)",
         "Moves the vertices to (n, 3) [m] as they are at `time` [s]; none is faster than "
         "`speed_bound` [m/s] from then on (None: unknown). ValueError, and the last good state "
         "stays, for another "
         "number of vertices or NaN.",
         update);
  define(body, "follow", "(self, time)", "Moves the vertices to where `motion` has them [s].",
         follow);
  defineConstant(
      body, "shape", [](const Body& self) { return collision::Shape::deformable(self.snapshot); },
      "The mesh at the last update, for distance() and World.add(): constant, for any thread.");
  defineConstant(
      body, "vertices",
      [](const Body& self) {
        auto snapshot = self.snapshot;
        const auto vertices = snapshot->vertices();
        using Held = std::shared_ptr<const DeformableSnapshot>;
        const py::capsule owner(new Held(std::move(snapshot)),
                                [](void* p) { delete static_cast<Held*>(p); });
        return view(vertices, owner);
      },
      "The vertices at the last update, without a copy: (n, 3), read-only [m].");
  defineConstant(
      body, "time", [](const Body& self) { return self.snapshot->time(); },
      "The time of the last update [s].");
  defineConstant(
      body, "strategy", [](const Body& self) { return toString(self.statistics.strategy); },
      "What the last update did.");
  defineConstant(
      body, "reason", [](const Body& self) { return self.statistics.reason; },
      "Why 'auto' chose that.");
  define(body, "self_distance", "(self)",
         "The least distance between two triangles that share no vertex, at most 0 where they "
         "cross.",
         [](const Body& self) {
           const auto snapshot = self.snapshot;
           return released([&] {
             collision::prepare(threadScratch(), *snapshot);
             return collision::selfDistance(*snapshot, {}, threadScratch());
           });
         });
  body.def("__repr__", [](const Body& self) {
    return "<leeway.Deformable of " + std::to_string(self.deformable.mesh()->triangleCount()) +
           " triangles at " + text(self.snapshot->time()) + " s>";
  });
}

}  // namespace leeway::python
