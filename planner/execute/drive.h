#pragma once

// Private to planner/: how a robot drives along a path.

#include <memory>
#include <vector>

#include "leeway/planner/trajectory.h"
#include "planner/base/waypoints.h"

namespace leeway::planner {

/// A trajectory in rows that are one period apart, which joints pass in straight lines at constant
/// speed. So acceleration is the change of velocity over a period, and jerk that of acceleration,
/// as for a Guard. Both keep the limits of the trajectory: differences of its rows are means of its
/// derivatives. Where the trajectory rests, the robot rests at a row. Times count periods.
class Drive {
 public:
  /// Throws as Trajectory does.
  Drive(const std::shared_ptr<const ConfigurationSpace>& space, const Waypoints& path,
        const MotionLimits& limits, double period, Cuts cuts = {});

  /// The last row, in which it rests.
  int rows() const { return sections_.back().row; }
  /// The place at a time, whole or not.
  std::vector<double> at(double time) const;
  /// The first row in which it rests, not before `row`.
  int restFrom(int row) const;
  /// The path from a time on: its corners, and the rows of blends.
  Waypoints pathFrom(double time) const;
  /// The shortest stop from a row that was found: the times at which the robot is where the drive
  /// is, one period each, until it rests. It leaves neither the curve nor the limits. At worst it
  /// is the drive itself, up to where that rests. Tries a fixed number of stops.
  std::vector<double> stop(int row) const;

 private:
  /// From one rest of the trajectory to the next.
  struct Section {
    int row;
    double time;  ///< of the trajectory [s]
  };
  struct Corner {
    double time;
    std::vector<double> place;
  };
  void findCorners();
  double timeOf(double seconds) const;
  bool keepsLimits(int row, const std::vector<double>& times) const;

  Trajectory trajectory_;
  MotionLimits limits_;
  double period_;
  std::vector<Section> sections_;  ///< and its end
  std::vector<Corner> corners_;
};

}  // namespace leeway::planner
