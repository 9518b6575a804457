#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "python/bindings/problem.h"

namespace leeway::python {

/// The certifiers of a scene, one lent to each call that runs.
class Certifiers {
 public:
  explicit Certifiers(std::shared_ptr<const planner::CompiledScene> scene)
      : scene_(std::move(scene)) {}
  std::unique_ptr<planner::EdgeCertifier> take();
  void giveBack(std::unique_ptr<planner::EdgeCertifier> certifier);

 private:
  std::shared_ptr<const planner::CompiledScene> scene_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<planner::EdgeCertifier>> idle_;
};

/// A problem compiled for questions about states and edges.
struct Scene {
  Problem problem;  ///< with its objects where they were when it was compiled
  std::map<std::string, collision::Pose> moved;  ///< X_WO since then
  /// Clouds of which regions were renewed since then.
  std::map<std::string, std::shared_ptr<const planner::PointCloud>> renewed;
  std::shared_ptr<const planner::CompiledScene> compiled;
  std::shared_ptr<Certifiers> certifiers;

  explicit Scene(Problem of, std::shared_ptr<const planner::CompiledScene> scene);
  std::size_t size() const { return problem.size(); }
  /// The problem with its objects where and as they are now.
  std::shared_ptr<const planner::Problem> current() const;
};

/// What check() says of one state.
struct State {
  std::vector<double> point;
  planner::StateCheck check;
  std::string limit;                    ///< the first limit that it breaks, in words; empty: none
  std::string a, b;                     ///< the closest pair
  std::string near_a, near_b;           ///< a pair that does not keep its margin
  std::string nothing_checked;          ///< CompiledScene::nothingChecked()
  std::vector<std::string> notes = {};  ///< planner::cloudNotes()
};

const char* verdictName(planner::Verdict verdict);
/// The names of a pair's bodies; empty for -1.
std::pair<std::string, std::string> pairNames(const planner::CompiledScene& scene, int pair);
py::object pairObject(const std::string& a, const std::string& b);  ///< a tuple, or None

void defineScene(py::module_& module);

}  // namespace leeway::python
