#pragma once

// Private to planner/: reads the log of an execution.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner::verification {

/// An observation of an obstacle by the program.
struct LoggedSight {
  std::string object;
  double time = 0;        ///< [s]
  bool is_rigid = false;  ///< a pose or a cloud; else vertices
  robots::Pose X_WO;
  std::vector<Eigen::Vector3d> vertices;
  std::shared_ptr<const PointCloud> cloud;  ///< null: the one before
  double speed_bound = 0, turn_bound = 0;   ///< [m/s], [rad/s]; may be infinite
};

struct LoggedObstacle {
  std::string name;
  double seen = 0;  ///< [s]
  bool predicted = false;
};

/// A line of a step.
struct LoggedStep {
  int line = 0;
  std::int64_t step = 0;
  double time = 0;  ///< [s]
  std::string decision;
  bool certified = false, exposed = false, reached = false;
  std::vector<double> position;
  std::vector<double> times;              ///< of the rows [s]
  std::vector<std::vector<double>> rows;  ///< at least two
  std::vector<double> stop_times;         ///< likewise of the stop after them
  std::vector<std::vector<double>> stop_rows;
  bool keeps_stop = false;  ///< in place of these rows: what the motion leaves of the stop before
  std::optional<std::vector<double>> measured;
  std::vector<LoggedSight> observed;
  std::vector<LoggedObstacle> obstacles;
};

/// The last line.
struct LoggedEnd {
  int line = 0;
  std::string status;
  bool certified = false;
  double duration = 0;  ///< [s]
  std::int64_t steps = 0, plans = 0, follows = 0, waits = 0, evasions = 0;
};

struct Log {
  std::vector<LoggedStep> steps;
  std::optional<LoggedEnd> end;  ///< nothing: the log was cut
};

/// Reads a log of the problem. Throws robots::InputError, with file and line, for a file that
/// cannot be read or is empty, a line that was cut or changed or is not a document of a log, and
/// another robot, problem or version. Keys that are not known are skipped.
Log readLog(const std::string& file, const Problem& problem);

}  // namespace leeway::planner::verification
