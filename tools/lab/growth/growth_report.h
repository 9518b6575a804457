#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/lab/base/report_options.h"
#include "tools/lab/base/state_engine.h"
#include "tools/lab/base/table.h"

namespace leeway::tools::report {

struct GrowthRow;

/// Options of `report growth`, and of `report sensed`, whose only family is "points".
struct GrowthReportOptions : ReportOptions {
  /// By family. Sorted, the first world of each is the one whose edges are measured.
  std::map<std::string, std::vector<std::int64_t>> counts = {
      {"boxes", {10, 100, 1000, 10000, 100000}},
      {"joints", {2, 4, 7, 14, 28, 40}},
      {"triangles", {1000, 10000, 100000}}};
  int edges = 200;   ///< limit on the edges, which planning requests
  int rounds = 5;    ///< rounds over the edges; the median is reported
  double time = 30;  ///< limit of one plan [s]
  /// Called with the rows of each problem when they are complete.
  std::function<void(const std::vector<GrowthRow>&)> on_rows;
};

/// One engine in one world.
struct GrowthRow {
  std::string family;
  std::int64_t count = 0;
  std::string engine;
  std::string status = {};  ///< ours: toString(PlanStatus); a rival's: "measured" or "left out"
  /// Time from the world in memory (points: an array of float) until it can be queried, including
  /// all data that meshes store; of points the median of the rounds. CPU time [s].
  double make_s = 0;
  /// Ours: time from moving one box, or from seeing a region with a tenth of the points again,
  /// until that world can be queried. Median of the rounds. CPU time [s].
  double change_s = 0;
  double bytes = 0;  ///< memory on the heap; 0 if the C library does not provide it
  /// Mean time of one edge [us], over the edges that planning requests in the first world of the
  /// family (for "joints", in each world): ours certified, a rival's in steps of 1/32 rad. CPU
  /// time.
  int edges = 0;
  double edge_us = 0;
  double edge_median_us = 0;  ///< over the edges, each with its fastest round
  double plan_s = 0;          ///< ours: plan, simplify, push and certify. Wall clock [s]
  /// Among points: states, the middles of the edges, that are compared with the distances of all
  /// balls, computed one by one; ours also after the change. How often the distance is below what
  /// was said (a state called free touches a ball, or an interval is too high), or above it.
  int states = 0, too_high = 0, too_low = 0;
};

/// Measures ours and, in the same worlds, the rivals' scenes.
std::vector<GrowthRow> measureGrowth(const std::vector<const StateEngine*>& rivals,
                                     const GrowthReportOptions& options);

/// All members of the rows; without states.
Table growthRows(const std::vector<GrowthRow>& rows);
/// For people: milliseconds and megabytes.
Table growthTable(const std::vector<GrowthRow>& rows);
/// The same for worlds of points, with states.
Table sensedRows(const std::vector<GrowthRow>& rows);
Table sensedTable(const std::vector<GrowthRow>& rows);

}  // namespace leeway::tools::report
