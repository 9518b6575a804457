#include "python/bindings/deforming.h"

#include <limits>

#include "leeway/collision/shape.h"
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

class Busy {
 public:
  explicit Busy(Body& body) : body_(body) {
    if (body.busy) throw std::runtime_error("another thread is updating this Deformable");
    body.busy = true;
  }
  ~Busy() { body_.busy = false; }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  Body& body_;
};

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
  const Busy busy(self);
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
  const Busy busy(self);
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

Motion cache(const py::object& times, const py::object& positions) {
  collision::CacheMotion motion;
  motion.times = increasingTimes(times);
  const Rows frames = rows(positions, "positions", 3, 3);
  if (frames.shape.size() != 2 || frames.shape[0] != static_cast<py::ssize_t>(motion.times.size()))
    throw py::value_error("positions do not have shape (times, vertices, 3) with " +
                          std::to_string(motion.times.size()) + " times");
  motion.vertex_count = static_cast<int>(frames.shape[1]);
  for (std::size_t i = 0; i < frames.count(); ++i)
    motion.positions.push_back(Eigen::Vector3d::Map(frames.row(i).data()).cast<float>());
  return {VertexMotion::cache(std::move(motion))};
}

Motion morph(const py::object& references, const py::object& times, const py::object& weights,
             bool smooth) {
  collision::MorphMotion motion;
  const Rows given = rows(references, "references", 3, 3);
  if (given.shape.size() != 2)
    throw py::value_error("references do not have shape (references, vertices, 3)");
  const auto count = static_cast<std::size_t>(given.shape[0]);
  const auto vertices = static_cast<std::size_t>(given.shape[1]);
  motion.references.resize(count);
  for (std::size_t i = 0; i < given.count(); ++i)
    motion.references[i / vertices].push_back(Eigen::Vector3d::Map(given.row(i).data()));
  const std::vector<double> keys = increasingTimes(times);
  const Rows shares = rows(weights, "weights", count, 2);
  if (shares.shape.size() != 1 || shares.count() != keys.size())
    throw py::value_error("weights do not have shape (times, references)");
  for (std::size_t i = 0; i < keys.size(); ++i)
    motion.keys.push_back({keys[i], {shares.row(i).begin(), shares.row(i).end()}});
  if (smooth) motion.interpolation = collision::Interpolation::kSmooth;
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

void defineMotion(py::module_& module) {
  py::class_<Motion> motion(module, "Motion",
                            "Where the vertices of a mesh are at any time: constant. With it, "
                            "execution looks ahead, and updates read fewer vertices.");
  defineStatic(motion, "cache", "(times, positions)",
               "Recorded positions (times, vertices, 3) [m] at increasing `times` [s], linear in "
               "between, held before and after.",
               cache, py::arg("times"), py::arg("positions"));
  defineStatic(motion, "morph", "(references, times, weights, *, smooth=False)",
               "Blends references (references, vertices, 3) [m] by weights (times, references) at "
               "`times` [s].",
               morph, py::arg("references"), py::arg("times"), py::arg("weights"), py::kw_only(),
               py::arg("smooth") = false);
  defineStatic(motion, "wave", "(rest, direction, amplitude, wavelength, frequency, phase=0.0)",
               "A travelling wave over the rest positions (vertices, 3) [m]: direction (3,), "
               "amplitude (3,) [m], wavelength [m], frequency [Hz], phase [rad].",
               wave, py::arg("rest"), py::arg("direction"), py::arg("amplitude"),
               py::arg("wavelength"), py::arg("frequency"), py::arg("phase") = 0.0);
  define(
      motion, "at", "(self, time)", "The vertices at a time [s]: (vertices, 3) [m].",
      [](const Motion& self, const py::object& time) {
        const double when = number(time, "time");
        const auto count = static_cast<std::size_t>(self.value->vertexCount());
        std::vector<Eigen::Vector3d> positions(count);
        self.value->evaluate(when, positions);
        std::vector<double> values(positions.front().data(), positions.front().data() + 3 * count);
        return array(std::move(values), {static_cast<py::ssize_t>(count), 3});
      },
      py::arg("time"));
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

double speedBoundOf(const py::object& value) {
  if (value.is_none()) return std::numeric_limits<double>::infinity();
  const double bound = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw py::type_error(std::string("speed_bound is of type ") + Py_TYPE(value.ptr())->tp_name +
                         "; a number or None is expected");
  }
  if (!(bound >= 0))
    throw py::value_error("speed_bound is " + text(bound) + "; at least 0 is expected");
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
  py::class_<Body> body(
      module, "Deformable",
      withSignature("Deformable", init,
                    "A mesh whose vertices move. One thread updates it; `shape` is constant and "
                    "for any thread.\n\n`vertices` (n, 3) are those at rest [m], `triangles` "
                    "(m, 3) indices. `strategy` says how its hierarchy follows; no choice changes "
                    "an answer.")
          .c_str());
  defineInit(body, init, makeBody, py::arg("vertices"), py::arg("triangles"), py::kw_only(),
             py::arg("motion") = py::none(), py::arg("strategy") = "auto",
             py::arg("expected_queries") = 12);
  define(body, "update", "(self, vertices, time=0.0, speed_bound=None)",
         "Moves the vertices to (n, 3) [m] as they are at `time` [s]; none is faster than "
         "`speed_bound` [m/s] from then on (None: unknown). ValueError, and the last good state "
         "stays, for another "
         "number of vertices or NaN.",
         update, py::arg("vertices"), py::arg("time") = 0.0, py::arg("speed_bound") = py::none());
  define(body, "follow", "(self, time)", "Moves the vertices to where `motion` has them [s].",
         follow, py::arg("time"));
  body.def_property_readonly(
      "shape", [](const Body& self) { return collision::Shape::deformable(self.snapshot); },
      "The mesh at the last update, for distance() and World.add(): constant, for any thread.");
  body.def_property_readonly(
      "vertices",
      [](const Body& self) {
        auto snapshot = self.snapshot;
        const auto vertices = snapshot->vertices();
        using Held = std::shared_ptr<const DeformableSnapshot>;
        const py::capsule owner(new Held(std::move(snapshot)),
                                [](void* p) { delete static_cast<Held*>(p); });
        return view(vertices, owner);
      },
      "The vertices at the last update, without a copy: (n, 3), read-only [m].");
  body.def_property_readonly(
      "time", [](const Body& self) { return self.snapshot->time(); },
      "The time of the last update [s].");
  body.def_property_readonly(
      "strategy", [](const Body& self) { return toString(self.statistics.strategy); },
      "What the last update did.");
  body.def_property_readonly(
      "reason", [](const Body& self) { return self.statistics.reason; }, "Why 'auto' chose that.");
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
