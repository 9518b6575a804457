#pragma once

// Not part of the product: the plain way to look for collisions, kept apart from all that it is to
// judge. It shares with Leeway only the reading of URDF and mesh files.

#include <Eigen/Geometry>
#include <memory>
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

/// A robot among the boxes and cylinders of a MoveIt scene, in the library FCL: exact meshes, no
/// hulls, no bounds, no certificates.
class DenseWorld {
 public:
  /// Throws std::runtime_error for what the files lack; yaml-cpp's exceptions for broken ones.
  DenseWorld(std::shared_ptr<const robots::Model> model, const std::string& scene_file,
             const std::string& request_file);
  ~DenseWorld();

  /// Positions of the named joints; all others as in the request's start state (absent there: 0).
  Collision check(const std::vector<std::string>& names, const std::vector<double>& positions);

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
  struct Body;
  void readScene(const std::string& file);
  void readRequest(const std::string& file);
  void addRobot();
  void listPairs();
  void place(const std::vector<std::string>& names, const std::vector<double>& positions);
  bool mayTouch(const std::string& a, const std::string& b) const;

  std::shared_ptr<const robots::Model> model_;
  std::vector<std::unique_ptr<Body>> bodies_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  std::vector<std::pair<std::string, std::string>> allowed_;
  std::vector<std::pair<std::string, double>> start_, goal_;
  std::vector<Eigen::Isometry3d> X_WL_;
  collision::Scratch scratch_;
};

}  // namespace leeway::dense
