#pragma once

// Not part of the product: the plain way to look for collisions, kept apart from all that it is to
// judge. It shares with Leeway only the reading of URDF and mesh files.

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

/// The request file beside a MoveIt scene file, sceneNNNN.yaml. Throws std::runtime_error for
/// another name.
std::string requestOf(const std::string& scene);

struct Collision {
  bool found = false;
  std::string a, b;
};

/// A robot among the boxes and cylinders of a MoveIt scene, in the library FCL: exact meshes, no
/// hulls, no bounds, no certificates.
class DenseWorld {
 public:
  /// Throws std::runtime_error for what the files lack; yaml-cpp's exceptions for broken ones.
  DenseWorld(std::shared_ptr<const robots::Model> model, const std::string& scene_file,
             const std::string& request_file);
  /// The same robot in another scene, without building its hierarchies again.
  DenseWorld(const DenseWorld& other, const std::string& scene_file,
             const std::string& request_file);
  ~DenseWorld();

  /// Positions of the named joints; all others as in the request's start state (absent there: 0).
  Collision check(const std::vector<std::string>& names, const std::vector<double>& positions);

  /// The same at the places t = i / count of the straight way between two rows, i = 0 .. count: the
  /// first t at which a pair collides. Two shapes whose hierarchies are so far apart that they
  /// cannot meet at the next places (the distance of a node from a joint, along the chain, times
  /// the joint's turn) are left out there: the same answer as check() everywhere, much faster.
  std::optional<double> firstCollision(const std::vector<std::string>& names,
                                       const std::vector<double>& from,
                                       const std::vector<double>& to, int count);

  /// Whether any pair is within `threshold` [m] of touching; a pair that cannot be decided counts.
  /// By Leeway's distance, one plain query a pair after its bounding spheres: no caches, no
  /// certificates.
  bool closerThan(const std::vector<std::string>& names, const std::vector<double>& positions,
                  double threshold);

  /// The largest difference of a named joint from the request's start state and from its goal.
  double startError(const std::vector<std::string>& names, const std::vector<double>& row) const;
  double goalError(const std::vector<std::string>& names, const std::vector<double>& row) const;

  /// The goal of the request, in its own order.
  const std::vector<std::pair<std::string, double>>& goal() const { return goal_; }
  const std::vector<std::pair<std::string, double>>& start() const { return start_; }

 private:
  struct Bounds;
  struct Body;
  using NodePair = std::pair<std::size_t, std::size_t>;
  /// Two shapes of a pair of bodies, and which of their nodes were nearest to one another last.
  struct ShapePair {
    std::size_t bodies, a, b;
    NodePair nearest{};
  };
  /// How far a point moves in one place: `turn` times its distance from the origin of its link, and
  /// `rest` [m].
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
  std::vector<int> due_;     // firstCollision(): when a pair is looked at next
  std::vector<int> placed_;  // and the place that a body's objects were set for
  std::vector<ShapePair> shape_pairs_;
  using Timed = std::pair<NodePair, double>;
  std::vector<Timed> nodes_;
  collision::Scratch scratch_;
};

}  // namespace leeway::dense
