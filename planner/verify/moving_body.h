#pragma once

// Private to planner/: where obstacles that move can be, by the verifier's own kinematics.

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"
#include "planner/verify/kinematics.h"

namespace leeway::planner::verification {

/// The knowledge of an obstacle in one step of an execution.
struct Sighting {
  enum class Kind : unsigned char {
    kFollows,  ///< it follows the problem's motion
    kLooked,   ///< at `time` it was where that motion has it; from then on a bound holds
    kSeen,     ///< at `time` it was seen; from then on a bound holds
  };
  Kind kind = Kind::kFollows;
  double time = 0;  ///< [s]
  /// kSeen: the pose of a rigid obstacle, or the vertices of one that deforms; null: as in the
  /// problem.
  robots::Pose X_WO;
  std::shared_ptr<const std::vector<Eigen::Vector3d>> vertices;
  std::shared_ptr<const PointCloud> cloud;  ///< in place of the problem's; null: that one
  /// Bounds on the speed of its frame's origin, or of its vertices [m/s], and on its turning
  /// [rad/s]. kLooked: if one is infinite, the motion's own bounds hold.
  double speed = 0, turning = 0;
};

/// Where a shape of an obstacle is at one time.
struct Place {
  robots::Pose X_WO;
  const collision::Shape* shape = nullptr;  ///< of an obstacle that deforms; null: its own
  double grown = 0;   ///< how far its points can be from there at that time [m]
  double nearer = 0;  ///< how much nearer to anything it can certainly be at that time [m]
  double speed = 0;   ///< how fast its points can be around that time [m/s]
  double slack = 0;   ///< rounding [m]
};

/// An obstacle that deforms, or an object with a motion.
class MovingBody {
 public:
  /// The obstacle must outlive this.
  MovingBody(const DeformingObstacle& obstacle, const Execution& execution);
  MovingBody(const Object& object, const Execution& execution);

  const std::string& name() const { return name_; }
  bool isRigid() const { return deforming_ == nullptr; }
  /// The number of vertices of an obstacle that deforms.
  std::size_t vertexCount() const;

  /// The knowledge at a step's look, at `time` [s], if the program has not observed the obstacle.
  Sighting lookedAt(double time) const;
  /// The place of a shape inside `sphere_O`, at `time`; `speed` and `slack` hold while the time
  /// differs by at most `half` [s]. Valid until the next call.
  Place at(const Sighting& known, double time, double half, const Sphere& sphere_O);
  /// Says how far a sight departs from what was known before; empty if it agrees with it, and for
  /// another cloud, whose balls do not correspond to those before. Of two sights, the bounds of the
  /// earlier one hold, whichever was stated first.
  std::string departure(const Sighting& before, const Sighting& now);
  /// The same of the problem's motion at a time that is not before a sight, by the sight's bounds.
  std::string departureOfMotion(const Sighting& seen, double time);
  /// Says that a sight has the problem's cloud at another pose than the one at which it was carved;
  /// empty if it has not.
  std::string carvedElsewhere(const Sighting& seen) const;

 private:
  /// Bounds on the motion of a rigid obstacle: its origin [m/s], its turning [rad/s], and its
  /// points within a reach of the origin [m/s].
  struct Rates {
    double speed = 0, turning = 0, of_points = 0;
  };
  std::string apart(const Sighting& first, const Sighting& second, double time, const char* from);
  Rates ratesBetween(double t0, double t1, double reach = 0) const;
  /// A bound on the speed of points within `reach` of the origin, from t0 to t1 [m/s].
  double motionSpeed(double t0, double t1, double reach) const;
  /// A bound on the rounding of poseAt() and of vertices [m].
  double motionRounding(double t0, double t1, double reach) const;
  robots::Pose poseAt(double time) const;
  robots::Pose poseOf(const Sighting& known, double time) const;
  /// The vertices of an obstacle that deforms where it was, or is, seen.
  std::vector<Eigen::Vector3d> verticesOf(const Sighting& known, double time) const;
  const collision::Shape& shapeOf(const Sighting& known, double time);

  std::string name_;
  Execution execution_;
  const DeformingObstacle* deforming_ = nullptr;
  const Object* object_ = nullptr;
  std::optional<collision::Deformable> present_;
  /// By the vertices and the time at which they were seen.
  std::map<std::pair<const void*, double>, collision::Shape> shapes_;
};

}  // namespace leeway::planner::verification
