#include "tools/lab/deform/deform_report.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <utility>

#include "collision/base/numbers.h"
#include "tools/lab/base/guard.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/deform/deform_scenes.h"

namespace leeway::tools::report {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Vector3d;
constexpr double kThreshold = 0.05;  // [m]
/// Measured for every engine, even a slow one (or all frames, if there are fewer).
constexpr int kLeastFrames = 3;
/// The engine whose distances are the reference.
constexpr const char* kReference = "leeway rebuild";

double nanoseconds(Clock::time_point begin) {
  return std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
}

volatile double sink;

/// Lower limit of an update: streaming the memory that it must touch.
struct Limits {
  double all = 0;       ///< vertices and triangle corners read, boxes written [ns]
  double vertices = 0;  ///< vertices read [ns]
};

/// Alternates with the engines, so that it finds the caches in the state in which their updates do:
/// vertices just copied, all other data last touched one frame ago.
class MemoryStream {
 public:
  MemoryStream(std::size_t vertices, std::size_t triangles)
      : positions_(vertices), corners_(3 * triangles, 1), boxes_(6 * (triangles / 2) + 1) {}

  Limits frame(std::span<const Vector3d> vertices) {
    Limits limits;
    setVertices(vertices);
    auto begin = Clock::now();
    read(positions_.data(), positions_.size() * sizeof(Vector3d));
    read(corners_.data(), corners_.size() * sizeof(std::int32_t));
    std::fill(boxes_.begin(), boxes_.end(), static_cast<float>(vertices[0].x()));
    limits.all = nanoseconds(begin);
    sink = static_cast<double>(boxes_.back());
    setVertices(vertices);
    begin = Clock::now();
    read(positions_.data(), positions_.size() * sizeof(Vector3d));
    limits.vertices = nanoseconds(begin);
    return limits;
  }

 private:
  void setVertices(std::span<const Vector3d> vertices) {
    std::copy(vertices.begin(), vertices.end(), positions_.begin());
  }

  // memcpy reads at the machine's full rate, and the copy stays in cache.
  void read(const void* data, std::size_t bytes) {
    const char* from = static_cast<const char*>(data);
    for (std::size_t i = 0; i < bytes; i += near_.size()) {
      std::memcpy(near_.data(), from + i, std::min(near_.size(), bytes - i));
      sink = near_[0];
    }
  }

  std::vector<Vector3d> positions_;
  std::vector<std::int32_t> corners_;
  std::vector<float> boxes_;
  std::array<char, 4096> near_;
};

/// A child's results for one engine: numbers only, because it lives in shared memory.
struct Shared {
  bool supported = false, failed = false;
  int compared = 0, wrong = 0;
  double error = 0, nodes = 0, vertices = 0;
};

/// One engine on one mesh, in the child.
class Runner {
 public:
  Runner(const MeshEngine& engine, const DeformingSpec& spec, const DeformBodies& bodies,
         bool queries)
      : engine_(engine), bodies_(bodies), follower_(engine.follow(spec)) {
    if (!follower_ || !queries) return;
    spheres_ = addAll(bodies.spheres);
    capsules_ = addAll(bodies.capsules);
    mesh_ = addAll({bodies.mesh, bodies.mesh, bodies.mesh});
  }

  bool isSupported() const { return follower_ != nullptr; }

  /// Handles a frame that is not measured.
  void passOver(std::span<const Vector3d> vertices, double time) {
    if (!follower_->followsEveryFrame()) return;
    follower_->setVertices(vertices, time);
    follower_->update();
  }

  /// Measures one frame.
  DeformFrame frame(std::span<const Vector3d> vertices, double time, Shared& shared) {
    DeformFrame result;
    follower_->setVertices(vertices, time);
    auto begin = Clock::now();
    follower_->update();
    result.update = nanoseconds(begin);
    distances.clear();
    // Poses are computed off the clock.
    std::array<collision::Pose, 12> links;
    for (int i = 0; i < 12; ++i) links[static_cast<std::size_t>(i)] = bodies_.linkPose(i, time);
    result.spheres = askAll(spheres_, links);
    result.capsules = askAll(capsules_, links);
    if (capsules_) {
      begin = Clock::now();
      for (int i = 0; i < 12; ++i)
        farther +=
            follower_->isFarther(*capsules_ + i, links[static_cast<std::size_t>(i)], kThreshold);
      result.tolerance = nanoseconds(begin);
    }
    if (mesh_) {
      int place = 0;
      for (double DeformFrame::*member :
           {&DeformFrame::far, &DeformFrame::near, &DeformFrame::touching}) {
        const collision::Pose pose = bodies_.meshPose(place, time);
        begin = Clock::now();
        distances.push_back(follower_->distance(*mesh_ + place, pose));
        result.*member = nanoseconds(begin);
        ++place;
      }
    } else {
      distances.insert(distances.end(), 3, kNaN);
    }
    shared.nodes = follower_->nodesTouched();
    shared.vertices = follower_->verticesTouched();
    return result;
  }

  /// Compares with the reference's distances of the frame.
  void compare(const std::vector<double>& truth, Shared& shared) const {
    for (std::size_t i = 0; i < truth.size() && i < distances.size(); ++i) {
      if (std::isnan(distances[i]) || std::isnan(truth[i])) continue;
      ++shared.compared;
      // In contact, engines agree only that the distance is not positive.
      const double error = std::abs(std::max(0.0, distances[i]) - std::max(0.0, truth[i]));
      shared.error = std::max(shared.error, error);
      shared.wrong += error > engine_.tolerance();
    }
  }

  std::vector<double> distances;  ///< of the last frame: spheres, capsules, mesh; NaN: missing
  int farther = 0;

 private:
  /// Adds all shapes; returns the index of the first, which the others follow.
  std::optional<int> addAll(const std::vector<collision::Shape>& shapes) {
    for (const collision::Shape& shape : shapes)
      if (!follower_->addBody(shape)) return std::nullopt;
    return std::exchange(next_, next_ + static_cast<int>(shapes.size()));
  }

  double askAll(std::optional<int> first, std::span<const collision::Pose, 12> links) {
    if (!first) {
      distances.insert(distances.end(), 12, kNaN);
      return kNaN;
    }
    const auto begin = Clock::now();
    for (int i = 0; i < 12; ++i)
      distances.push_back(follower_->distance(*first + i, links[static_cast<std::size_t>(i)]));
    return nanoseconds(begin);
  }

  const MeshEngine& engine_;
  const DeformBodies& bodies_;
  std::unique_ptr<MeshFollower> follower_;
  std::optional<int> spheres_, capsules_, mesh_;
  int next_ = 0;
};

/// One mesh and motion, in the child: engines take turns within each frame.
class MeshMeasurement {
 public:
  MeshMeasurement(const std::vector<const MeshEngine*>& engines, const DeformScene& scene,
                  const DeformReportOptions& options, std::span<Shared> shared,
                  std::span<DeformFrame> frames, std::span<Limits> limits)
      : options_(options),
        scene_(scene),
        memory_(scene.spec.rest.size(), scene.spec.triangles.size()),
        shared_(shared),
        frames_(frames),
        limits_(limits) {
    const bool queries =
        static_cast<int>(scene.spec.triangles.size()) <= options.queries_up_to * 11 / 10;
    for (const MeshEngine* engine : engines)
      runners_.emplace_back(*engine, scene.spec, bodies_, queries);
    stride_.assign(engines.size(), 1);
    for (std::size_t e = 0; e < engines.size(); ++e) {
      shared_[e].supported = runners_[e].isSupported();
      if (std::string(engines[e]->name()) == kReference) reference_ = e;
    }
  }

  void run() {
    std::vector<Vector3d> vertices(scene_.spec.rest.size());
    const auto frames = static_cast<std::size_t>(options_.frames);
    for (std::size_t f = 0; f < frames; ++f) {
      const double time = static_cast<double>(f + 1) / static_cast<double>(frames);
      scene_.vertices(time, vertices);
      limits_[f] = memory_.frame(vertices);
      for (std::size_t e = 0; e < runners_.size(); ++e)
        if (shared_[e].supported && !shared_[e].failed) frame(e, f, vertices, time);
      if (!reference_ || shared_[*reference_].failed || f % stride_[*reference_] != 0) continue;
      for (std::size_t e = 0; e < runners_.size(); ++e)
        if (e != *reference_ && shared_[e].supported && !shared_[e].failed && f % stride_[e] == 0)
          runners_[e].compare(runners_[*reference_].distances, shared_[e]);
    }
  }

 private:
  void frame(std::size_t e, std::size_t f, const std::vector<Vector3d>& vertices, double time) {
    const auto begin = Clock::now();
    try {
      if (f % stride_[e] != 0) {
        runners_[e].passOver(vertices, time);
        return;
      }
      // The first frame is discarded, because it warms caches and makes lazy allocations.
      if (f == 0) runners_[e].frame(vertices, time, shared_[e]);
      const auto second = f == 0 ? Clock::now() : begin;
      frames_[e * static_cast<std::size_t>(options_.frames) + f] =
          runners_[e].frame(vertices, time, shared_[e]);
      if (f > 0) return;
      const double all = 1e-9 * nanoseconds(second) * options_.frames;
      const double most = std::ceil(options_.frames / static_cast<double>(kLeastFrames));
      stride_[e] =
          static_cast<std::size_t>(std::clamp(std::ceil(all / options_.engine_seconds), 1.0, most));
    } catch (const std::exception&) {
      shared_[e].failed = true;
    }
  }

  const DeformReportOptions& options_;
  const DeformScene& scene_;
  DeformBodies bodies_ = makeDeformBodies();
  MemoryStream memory_;
  std::span<Shared> shared_;
  std::span<DeformFrame> frames_;
  std::span<Limits> limits_;
  std::vector<Runner> runners_;
  std::vector<std::size_t> stride_;
  std::optional<std::size_t> reference_;
};

double medianOf(const std::vector<DeformFrame>& frames, double DeformFrame::*member,
                double share = 0.5) {
  std::vector<double> values;
  for (const DeformFrame& f : frames)
    if (!std::isnan(f.*member)) values.push_back(f.*member);
  return quantile(values, share);
}

/// Late query time divided by early query time.
double slowdown(const std::vector<DeformFrame>& frames) {
  const std::size_t tenth = std::max<std::size_t>(1, frames.size() / 10);
  const std::vector<DeformFrame> early(frames.begin(), frames.begin() + static_cast<long>(tenth));
  const std::vector<DeformFrame> late(frames.end() - static_cast<long>(tenth), frames.end());
  for (double DeformFrame::*member : {&DeformFrame::capsules, &DeformFrame::spheres}) {
    const double ratio = medianOf(late, member) / medianOf(early, member);
    if (!std::isnan(ratio)) return ratio;
  }
  return kNaN;
}

DeformRow summarise(const DeformScene& scene, const MeshEngine& engine, const Shared& shared,
                    std::span<const DeformFrame> frames) {
  DeformRow row;
  row.motion = scene.motion;
  row.triangles = static_cast<int>(scene.spec.triangles.size());
  row.engine = engine.name();
  row.done = !shared.failed;
  row.by_frame.assign(frames.begin(), frames.end());
  if (!row.done) return row;
  for (const DeformFrame& f : row.by_frame) row.frames += !std::isnan(f.update);
  for (double DeformFrame::*member :
       {&DeformFrame::update, &DeformFrame::spheres, &DeformFrame::capsules,
        &DeformFrame::tolerance, &DeformFrame::far, &DeformFrame::near, &DeformFrame::touching})
    row.median.*member = medianOf(row.by_frame, member);
  row.update_low = medianOf(row.by_frame, &DeformFrame::update, 0.25);
  row.update_high = medianOf(row.by_frame, &DeformFrame::update, 0.75);
  row.compared = shared.compared, row.wrong = shared.wrong, row.error = shared.error;
  if (shared.nodes >= 0) row.nodes = shared.nodes;
  if (shared.vertices >= 0) row.vertices = shared.vertices;
  row.decay = slowdown(row.by_frame);
  return row;
}

bool readsVerticesAlone(const std::string& engine) {
  return engine == "leeway hybrid" || engine == "leeway hybrid moved" || engine == "leeway lazy" ||
         engine == "leeway octree";
}

void measureMesh(const std::vector<const MeshEngine*>& engines, const DeformScene& scene,
                 const DeformReportOptions& options, std::vector<DeformRow>& rows) {
  const auto frames = static_cast<std::size_t>(options.frames);
  const SharedArray<Shared> shared(engines.size());
  const SharedArray<DeformFrame> measured(engines.size() * frames);
  const SharedArray<Limits> limits(frames);
  const std::vector<Fate> fate = runGuarded(1, 3600, [&](std::size_t) {
    MeshMeasurement(engines, scene, options, shared.span(), measured.span(), limits.span()).run();
  });
  const auto medianLimit = [&](double Limits::*member) {
    std::vector<double> values;
    for (const Limits& l : limits.span()) values.push_back(l.*member);
    return quantile(values, 0.5);
  };
  const double limit = medianLimit(&Limits::all), of_vertices = medianLimit(&Limits::vertices);
  const std::size_t first = rows.size();
  std::optional<double> fresh;
  for (std::size_t e = 0; e < engines.size(); ++e) {
    if (fate[0] != Fate::kDone) shared[e].failed = true;
    if (!shared[e].supported) continue;
    rows.push_back(
        summarise(scene, *engines[e], shared[e], measured.span().subspan(e * frames, frames)));
    rows.back().bandwidth_limit = !(shared[e].vertices > 0) && shared[e].nodes >= 0 ? kNaN
                                  : readsVerticesAlone(engines[e]->name())          ? of_vertices
                                                                                    : limit;
    if (rows.back().engine == kReference) fresh = rows.back().decay;
  }
  // Normalised by the rebuilt hierarchy, because late frames may be inherently harder.
  for (std::size_t i = first; i < rows.size() && fresh; ++i) rows[i].decay /= *fresh;
}

}  // namespace

std::vector<DeformRow> measureDeform(const std::vector<const MeshEngine*>& engines,
                                     const DeformReportOptions& options) {
  std::vector<DeformRow> rows;
  for (const std::string& motion : options.motions) {
    for (const int triangles : options.triangles) {
      if (options.progress) options.progress(motion + ", " + std::to_string(triangles));
      std::vector<DeformRow> added;
      measureMesh(engines, makeDeformScene(motion, triangles, options.seed), options, added);
      if (options.on_rows) options.on_rows(added);
      rows.insert(rows.end(), added.begin(), added.end());
    }
  }
  return rows;
}

}  // namespace leeway::tools::report
