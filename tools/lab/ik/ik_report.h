#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "leeway/robots/model.h"
#include "tools/lab/base/ik_engine.h"
#include "tools/lab/base/report_options.h"
#include "tools/lab/base/table.h"

namespace leeway::tools::report {

/// A robot whose link is placed by all variables that move it.
struct IkRobot {
  std::string name;
  std::shared_ptr<const robots::Model> model;
  int link = -1;
};

/// One engine on the poses of random configurations of one robot, starting from another random one.
struct IkRow {
  std::string robot, engine;
  int poses = 0;
  int solved = 0;  ///< within the limits, to 1e-9 m and rad by our forward kinematics
  int coarse = 0;  ///< only to 1e-5: KDL treats angles below 1e-6 as 0
  int wrong = 0;   ///< answers that are neither solved nor coarse
  double median_us = 0, most_us = 0;  ///< processor time to the first solution; 95 %
  double worst_error = 0;             ///< of answers that are not wrong [m or rad]
  double all_us = 0, branches = 0;    ///< ours: median time to all solutions, their mean number
};

/// Unreachable poses, and proofs for reachable ones.
struct IkProofRow {
  std::string robot;
  int beyond = 0, proven = 0, found = 0;  ///< the rest is undecided
  double median_ms = 0, most_ms = 0;      ///< 95 %
  int reachable = 0, wrong = 0;           ///< wrong: reachable, but proven to be out of reach
};

struct IkReportOptions : ReportOptions {
  std::vector<std::string> robots = {"robots/arm6/arm6.urdf:tool",
                                     "robots/arm7/arm7.urdf:hand"};  ///< URDF:LINK
  int poses = 1000;  ///< poses of random configurations for each engine and robot
  int beyond = 200;  ///< poses beyond reach; the proof is also tried on ten times as many reachable
                     ///< ones
  /// Called with the rows of each robot when they are complete.
  std::function<void(const std::vector<IkRow>&)> on_rows;
  std::function<void(const std::vector<IkProofRow>&)> on_proof_rows;
};

/// Measures the rivals and our engine. Robots with joints other than single ones, or with mimic
/// joints on the way, are measured with ours alone.
std::vector<IkRow> measureIk(const std::vector<IkRobot>& robots,
                             const std::vector<const IkEngine*>& rivals,
                             const IkReportOptions& options);
std::vector<IkProofRow> measureIkProofs(const std::vector<IkRobot>& robots,
                                        const IkReportOptions& options);

/// The rows as they are.
Table ikRows(const std::vector<IkRow>& rows);
Table ikProofRows(const std::vector<IkProofRow>& rows);
/// For people.
Table ikTable(const std::vector<IkRow>& rows);

}  // namespace leeway::tools::report
