#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tools/report/base/mesh_engine.h"
#include "tools/report/base/plot.h"

namespace leeway::tools::report {

struct DeformReportOptions {
  std::vector<std::string> motions;  ///< of deformMotions()
  std::vector<int> triangles = {2000, 20000, 200000};
  int frames = 100;
  /// Engines that would take longer for a mesh measure every second, third, ... frame only [s].
  double engine_seconds = 0.25;
  std::uint64_t seed = 1;
  /// Above this many triangles only updates are measured [count].
  int queries_up_to = 200000;
  std::function<void(const std::string&)> progress;
};

/// Nanoseconds of one frame of one engine; NaN: not measured, or a query that it does not have.
struct DeformFrame {
  double update = std::numeric_limits<double>::quiet_NaN();
  double spheres = update;    ///< 12 least distances, of spheres
  double capsules = update;   ///< 12 least distances, of capsules
  double tolerance = update;  ///< 12 times "farther than 5 cm?", of the capsules
  /// 1 least distance, of a mesh of about 1000 triangles: far, near, touching (one through the
  /// other, or nearly); each from where it was a frame before.
  double far = update, near = update, touching = update;
};

/// One engine on one mesh and motion; times are medians over the measured frames [ns].
struct DeformRow {
  std::string motion;
  int triangles = 0;
  std::string engine;
  bool done = true;  ///< false: it ended its process or threw; nothing else is then said
  int frames = 0;    ///< measured
  DeformFrame median;
  double update_low = std::numeric_limits<double>::quiet_NaN();  ///< quartiles [ns]
  double update_high = update_low;
  /// Distances compared with those of our own rebuilt hierarchy, and how many were off by more than
  /// the engine's tolerance.
  int compared = 0, wrong = 0;
  double error = 0;  ///< largest [m]
  /// Median of queries (capsules, else spheres) over the last tenth of the frames to that over the
  /// first tenth, against the same for our rebuilt hierarchy: 1 where the hierarchy is as good as
  /// new. NaN: no queries.
  double decay = update_low;
  double nodes = update_low, vertices = update_low;  ///< touched by an update; NaN: not told
  /// Time that this machine needs, in the same frames, to stream what a full update must: vertices
  /// and corners of all triangles read, boxes of a binary hierarchy written, 4 triangles a leaf
  /// [ns]; of the vertices alone where that is all that the strategy looks at (hybrid, lazy,
  /// octree); NaN where it looks at none (bounds from the motion).
  double bandwidth_limit = update_low;
  std::vector<DeformFrame> by_frame;
};

/// Every engine over every motion and size, in a child process each mesh, engines interleaved frame
/// by frame. Pin the process first.
std::vector<DeformRow> measureDeform(const std::vector<const MeshEngine*>& engines,
                                     const DeformReportOptions& options);

std::string deformCsv(const std::vector<DeformRow>& rows);
/// One line a measured frame.
std::string deformFramesCsv(const std::vector<DeformRow>& rows);
/// For people: by motion and size, times and ratios to FCL's AABB refit.
std::string deformTable(const std::vector<DeformRow>& rows);
/// In words, a motion and size a line: whether hybrid updates are four to five times cheaper than
/// full refits, as the textbooks have it since Larsson and Akenine-Moller 2001, what they are where
/// it is known how far vertices move, and how `auto` does beside the best single strategy.
std::string deformWords(const std::vector<DeformRow>& rows);
/// Updates over the number of triangles, a panel a motion.
Figure deformUpdateFigure(const std::vector<DeformRow>& rows, const std::string& note);
/// Update and queries of each frame over time at the largest size that has queries, running medians
/// of five frames.
Figure deformDecayFigure(const std::vector<DeformRow>& rows, const std::string& note);

}  // namespace leeway::tools::report
