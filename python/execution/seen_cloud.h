#pragma once

#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>

#include "leeway/planner/problem.h"
#include "python/base/arrays.h"

namespace leeway::python {

/// The arguments of set_cloud(), as Python gives them.
struct CloudArguments {
  const py::object &points, &radius, &pose, &thin, &most_balls, &carve, &carve_margin;
};
/// The last arguments of set_cloud(), and its text.
inline constexpr char kCloudSignature[] =
    "pose=None, thin=None, most_balls=None, carve=(), carve_margin=0.0, state=None)";
inline constexpr char kCloudDoc[] =
    "All points (n, 3) [m] of an object with a cloud and a motion, as seen in its frame at `time` "
    "[s], each a ball of `radius` [m] (a number, or one a point). They replace those before, and "
    "none is faster than `speed_bound` [m/s] from then on. `pose` of the frame: x y z, or with a "
    "quaternion x y z w behind it, or (4, 4); None: as before. Points that are NaN are dropped. "
    "`thin`, `most_balls` as in World.add_cloud(). `carve`: links, objects at rest or 'robot' "
    "whose points "
    "are left out, to within `carve_margin` [m], with the robot at `state`; needs `pose`.";

/// The balls, filtered, and their pose, if one is given. `state`: of the planned variables, or
/// empty: nothing can be carved out. Throws ValueError.
struct CloudGiven {
  std::shared_ptr<const planner::PointCloud> cloud;
  std::optional<collision::Pose> X_WO;
};
/// The rest as for seenPose().
CloudGiven cloudGiven(const planner::Problem& problem, const CloudArguments& of,
                      std::span<const double> state, const std::string& object, double time,
                      const std::set<std::string>& turned);

}  // namespace leeway::python
