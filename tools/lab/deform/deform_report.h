#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tools/lab/base/mesh_engine.h"
#include "tools/lab/base/report_options.h"
#include "tools/lab/base/table.h"

namespace leeway::tools::report {
struct DeformRow;

struct DeformReportOptions : ReportOptions {
  std::vector<std::string> motions;  ///< of deformMotions()
  std::vector<int> triangles = {2000, 20000, 200000};
  int frames = 100;
  /// Engines slower than this on a mesh [s] are measured only at every second, third, ... frame.
  double engine_seconds = 0.25;
  /// Above this many triangles, only updates are measured.
  int queries_up_to = 200000;
  /// Called with the rows of each mesh when they are complete.
  std::function<void(const std::vector<DeformRow>&)> on_rows;
};

/// Times of one frame of one engine [ns]; NaN: not measured, or the engine lacks the query.
struct DeformFrame {
  double update = std::numeric_limits<double>::quiet_NaN();
  double spheres = update;    ///< 12 least distances, of spheres
  double capsules = update;   ///< 12 least distances, of capsules
  double tolerance = update;  ///< 12 tests "farther than 5 cm?", of the capsules
  /// 1 minimum distance, of a mesh of about 1000 triangles: far, near, and touching (penetrating,
  /// or nearly). Each placement continues that of the previous frame.
  double far = update, near = update, touching = update;
};

/// One engine on one mesh and motion; times are medians over the measured frames [ns].
struct DeformRow {
  std::string motion;
  int triangles = 0;
  std::string engine;
  bool done = true;  ///< false: it threw or ended its process; all other members are unset
  int frames = 0;    ///< measured frames
  DeformFrame median;
  double update_low = std::numeric_limits<double>::quiet_NaN();  ///< quartiles [ns]
  double update_high = update_low;
  /// Number of distances compared with those of our rebuilt hierarchy, and how many exceeded the
  /// engine's tolerance.
  int compared = 0, wrong = 0;
  double error = 0;  ///< largest [m]
  /// Hierarchy quality at the end: median query time (capsules, or spheres if there are none) over
  /// the last tenth of the frames relative to the first tenth, divided by the same ratio of our
  /// rebuilt hierarchy. 1: as good as new. NaN: no queries.
  double decay = update_low;
  double nodes = update_low, vertices = update_low;  ///< touched by an update; NaN: unknown
  /// Lower limit of an update's time [ns]: this machine streams, in the same frames, the memory
  /// that the update must touch. Full updates: vertices and triangle corners read, boxes of a
  /// binary hierarchy with 4 triangles in each leaf written. hybrid, lazy and octree: only
  /// vertices. NaN if bounds are computed from the motion.
  double bandwidth_limit = update_low;
  std::vector<DeformFrame> by_frame;
};

/// Runs every engine on every motion and size: one child process for each mesh, with engines
/// interleaved frame by frame. Pin the process first.
std::vector<DeformRow> measureDeform(const std::vector<const MeshEngine*>& engines,
                                     const DeformReportOptions& options);

/// The rows, without their frames.
Table deformRows(const std::vector<DeformRow>& rows);
/// One row for each measured frame.
Table deformFrameRows(const std::vector<DeformRow>& rows);
/// For people: times in microseconds, and ratios to FCL's AABB refit.
Table deformTable(const std::vector<DeformRow>& rows);
/// Verdicts in words, one line for each motion and size: whether hybrid updates are four to five
/// times cheaper than full refits (Larsson and Akenine-Moller 2001), their ratio when bounds on the
/// vertices' motion are known, and a comparison of `auto` with the best single strategy.
std::string deformWords(const std::vector<DeformRow>& rows);

}  // namespace leeway::tools::report
