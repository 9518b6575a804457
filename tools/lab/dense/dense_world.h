#pragma once

// Dense collision checks, independent of the engine they check: only the readers of URDF and mesh
// files are Leeway's. Not installed.

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "leeway/collision/distance.h"
#include "leeway/robots/model.h"

namespace leeway::dense {

struct Collision {
  bool found = false;
  std::string a, b;
};

/// A robot among the boxes and cylinders of a MoveIt scene, checked by FCL: exact meshes, no hulls,
/// bounds or certificates.
class DenseWorld {
 public:
  /// Throws std::runtime_error for missing content, yaml-cpp's exceptions for malformed files.
  DenseWorld(std::shared_ptr<const robots::Model> model, const std::string& scene_file,
             const std::string& request_file);
  /// The robot of `other` in another scene; shares its hierarchies.
  DenseWorld(const DenseWorld& other, const std::string& scene_file,
             const std::string& request_file);
  /// The robot alone, for leastDistance(); `start`: of the joints that are not named there.
  DenseWorld(std::shared_ptr<const robots::Model> model,
             std::vector<std::pair<std::string, double>> start);
  ~DenseWorld();

  /// Points in FCL's hierarchy, as triangles of 0.01 mm.
  struct Points;
  static std::shared_ptr<const Points> pointsOf(const std::vector<Eigen::Vector3d>& points_W);
  /// The least distance of a link from the points [m], and the link's name.
  std::pair<double, std::string> leastDistance(const Points& points,
                                               const std::vector<std::string>& names,
                                               const std::vector<double>& positions);

  /// Finds the first colliding pair at these positions of the named joints. Other joints take the
  /// values of the request's start state, or 0 if it does not name them.
  Collision check(const std::vector<std::string>& names, const std::vector<double>& positions);

  /// The first t = i / count, i = 0 .. count, at which a pair collides on the straight line between
  /// two rows. Equals check() at every place, but much faster: a pair of shapes skips the places at
  /// which its hierarchies prove it apart (a node moves at most by its distance from a joint, along
  /// the chain, times the joint's turn).
  std::optional<double> firstCollision(const std::vector<std::string>& names,
                                       const std::vector<double>& from,
                                       const std::vector<double>& to, int count);

  /// Whether any pair is within `threshold` [m]; undecided counts as near. Calls Leeway's
  /// distance() for each pair with nearby bounding spheres, without caches or certificates.
  bool closerThan(const std::vector<std::string>& names, const std::vector<double>& positions,
                  double threshold);

  /// Largest difference of a named joint from the request's start state or goal [rad or m].
  double startError(const std::vector<std::string>& names, const std::vector<double>& row) const;
  double goalError(const std::vector<std::string>& names, const std::vector<double>& row) const;

  /// The request's joint names and values, in its order.
  const std::vector<std::pair<std::string, double>>& goal() const { return goal_; }
  const std::vector<std::pair<std::string, double>>& start() const { return start_; }

 private:
  struct Bounds;
  struct Body;
  using NodePair = std::pair<std::size_t, std::size_t>;
  /// Two shapes of a pair of bodies, and their last nearest pair of leaves.
  struct ShapePair {
    std::size_t bodies, a, b;
    NodePair nearest{};
  };
  /// From one place to the next a point moves at most turn * (distance from its link's origin) +
  /// rest [m].
  struct Moved {
    double turn = 0, rest = 0;
  };
  struct Approach {
    Moved a, b;
    double step(double reach_a, double reach_b) const {
      return std::max(a.turn * reach_a + a.rest + b.turn * reach_b + b.rest, 1e-12);
    }
  };
  void readScene(const std::string& file);
  void readRequest(const std::string& file);
  void addRobot();
  void listPairs();
  void placeLinks(const std::vector<std::string>& names, const std::vector<double>& positions);
  void placeObjects(Body& body) const;
  void place(const std::vector<std::string>& names, const std::vector<double>& positions);
  bool collide(const ShapePair& pair) const;
  static double leafGap(const Bounds& a, const Bounds& b, const NodePair& pair,
                        const Eigen::Isometry3d& X_AB);
  double placesApart(ShapePair& pair, const Approach& approach, double most);
  std::vector<Approach> largestSteps(const std::vector<std::string>& names,
                                     const std::vector<double>& from, const std::vector<double>& to,
                                     int count) const;
  bool mayTouch(const std::string& a, const std::string& b) const;

  std::shared_ptr<const robots::Model> model_;
  std::vector<std::unique_ptr<Body>> bodies_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  std::vector<std::pair<std::string, std::string>> allowed_;
  std::vector<std::pair<std::string, double>> start_, goal_;
  std::vector<Eigen::Isometry3d> X_WL_;
  std::vector<int> due_;  // firstCollision(): next place at which a pair of shapes must be checked
  std::vector<int> placed_;  // firstCollision(): place to which a body's objects were moved
  std::vector<ShapePair> shape_pairs_;
  using Timed = std::pair<NodePair, double>;
  std::vector<Timed> nodes_;
  collision::Scratch scratch_;
};

}  // namespace leeway::dense
