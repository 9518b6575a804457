#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/robots/inverse_kinematics.h"
#include "leeway/robots/kinematics.h"
#include "robots/base/low_discrepancy.h"
#include "robots/base/tolerances.h"
#include "robots/inverse/closed_form.h"
#include "robots/inverse/reach_proof.h"
#include "robots/inverse/region.h"
#include "robots/inverse/search.h"

namespace leeway::robots {

namespace {

using collision::kTwoPi;

/// The proof that there is no solution is tried for one box after the first search, for
/// kEarlyProofBoxes boxes after this many starts, and with all its boxes after the last one.
constexpr int kStartsBeforeProof = 20;
constexpr int kEarlyProofBoxes = 2000;

/// Closed forms of seven joints: angles of the given joint that are tried before the start is used
/// for the numeric search.
constexpr std::uint64_t kSweep = 8;

/// sample(): number of searches for one draw.
constexpr int kStartsOfSample = 3;

void check(const Model& model, std::span<const PoseRegion> regions,
           std::span<const double> configuration) {
  const auto demand = [](bool holds, const std::string& what) {
    if (!holds) throw std::invalid_argument("InverseKinematics: " + what);
  };
  demand(configuration.size() == model.variables.size(),
         std::to_string(configuration.size()) + " numbers for a model of " +
             std::to_string(model.variables.size()) + " variables");
  demand(std::all_of(configuration.begin(), configuration.end(),
                     [](double x) { return std::isfinite(x); }),
         "the configuration has a number that is not finite");
  demand(!regions.empty(), "no region is given");
  for (const PoseRegion& region : regions)
    if (const std::optional<std::string> fault = regionFault(model, region)) demand(false, *fault);
}

/// One call's data that InverseKinematics shares between starts.
class Task {
 public:
  Task(const Model& model, const std::vector<int>& variables, const std::vector<char>& periodic,
       std::span<const PoseRegion> regions, std::span<const double> configuration,
       std::uint64_t seed)
      : model_(model),
        variables_(variables),
        periodic_(periodic),
        regions_(regions),
        configuration_(configuration.begin(), configuration.end()),
        sequence_(variables.size(), seed),
        X_WL_(model.links.size()),
        search_(makeSearch()),
        closed_form_(search_.chains()[0]) {
    const PreparedRegion& region = search_.regions()[0];
    has_closed_form_ =
        regions.size() == 1 && regions[0].base < 0 && closed_form_.exists() && region.exact_turn;
    for (const auto& [low, high] : region.position) has_closed_form_ &= low == high;
    for (const ChainJoint& joint : search_.chains()[0].joints)
      has_closed_form_ = has_closed_form_ && periodic_[at(joint.column[0])];
  }

  bool hasClosedForm() const { return has_closed_form_; }
  bool isRedundant() const { return closed_form_.given() >= 0; }
  bool isNear(const std::vector<double>& q) { return search_.squaredError(q) < kNearPosesSquared; }

  /// Adds at most `most` solutions with the given joint of q: those nearest to the configuration
  /// first, or cyclically from number `first` on. False if some may be missing.
  bool solveClosed(const std::vector<double>& q, int most, std::vector<IkSolution>& solutions,
                   std::uint64_t first = 0) {
    const std::vector<ChainJoint>& joints = search_.chains()[0].joints;
    const PreparedRegion& region = search_.regions()[0];
    std::array<double, 7> angles = {};
    for (std::size_t i = 0; i < joints.size(); ++i)
      angles[i] = q[at(joints[i].variable)] + joints[i].offset;
    ClosedForm::Answer answer;
    closed_form_.solve(
        {region.target,
         {region.position[0].first, region.position[1].first, region.position[2].first}},
        angles, answer);
    std::array<std::pair<double, std::vector<double>>, 8> candidates;
    std::size_t count = 0;
    for (int k = 0; k < answer.count; ++k) {
      std::vector<double> values = configuration_;
      for (std::size_t i = 0; i < joints.size(); ++i)
        values[at(joints[i].variable)] = answer.angles[at(k)][i] - joints[i].offset;
      const std::vector<double> free = values;
      normalize(values);
      double squared_distance = 0;
      bool within = true;
      for (const ChainJoint& joint : joints) {
        const std::size_t v = at(joint.variable);
        const double moved = values[v] - free[v];
        within = within && std::fabs(moved - kTwoPi * std::floor(moved / kTwoPi + 0.5)) < kPolished;
        squared_distance += (values[v] - configuration_[v]) * (values[v] - configuration_[v]);
      }
      if (within) candidates[count++] = {squared_distance, std::move(values)};
    }
    std::stable_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    IkSolution solution;
    std::size_t k = 0;
    for (; k < count && most > 0; ++k) {
      if (!solveFrom(std::move(candidates[(first + k) % count].second), solution)) continue;
      solutions.push_back(solution);
      --most;
    }
    return !answer.singular && k == count;
  }

  /// The configuration itself as a start, within the limits, or number `index` of the sequence.
  std::vector<double> start(std::uint64_t index) const {
    std::vector<double> q = configuration_;
    for (std::size_t c = 0; c < variables_.size(); ++c) {
      double& value = q[at(variables_[c])];
      if (index > 0) value = low_[c] + (high_[c] - low_[c]) * sequence_.at(index, c);
      value = std::clamp(value, lower_[c], upper_[c]);
    }
    return q;
  }

  /// Searches from q and checks the result by forwardKinematics(). True if `solution` is one.
  bool solveFrom(std::vector<double> q, IkSolution& solution) {
    search_.descend(q);
    return finish(q, solution);
  }

  bool finish(std::vector<double>& q, IkSolution& solution) {
    normalize(q);
    solution.values.clear();
    for (const int v : variables_) solution.values.push_back(q[at(v)]);
    forwardKinematics(model_, q, X_WL_);
    solution.error = {};
    bool good = true;
    for (const PoseRegion& region : regions_) {
      const PoseError error = errorAt(region);
      good = good && error.position <= region.position_tolerance &&
             error.angle <= region.angle_tolerance;
      solution.error.position = std::max(solution.error.position, error.position);
      solution.error.angle = std::max(solution.error.angle, error.angle);
    }
    return good;
  }

  bool same(const IkSolution& a, const IkSolution& b) const {
    for (std::size_t c = 0; c < variables_.size(); ++c) {
      double difference = std::fabs(a.values[c] - b.values[c]);
      if (periodic_[c]) difference -= kTwoPi * std::floor(difference / kTwoPi + 0.5);
      if (!(std::fabs(difference) < kSameSolution)) return false;
    }
    return true;
  }

  double squaredDistance(const IkSolution& solution) const {
    double sum = 0;
    for (std::size_t c = 0; c < variables_.size(); ++c) {
      const double d = solution.values[c] - configuration_[at(variables_[c])];
      sum += d * d;
    }
    return sum;
  }

  /// Whether one of the frames is proven not to reach its region. Adds to `boxes`.
  bool provenUnreachable(std::int64_t limit, std::int64_t& boxes) const {
    for (std::size_t r = 0; r < regions_.size(); ++r) {
      if (regions_[r].base >= 0) continue;  // the proof knows regions at rest alone
      const ReachProof proof =
          proveUnreachable(search_.chains()[r], regions_[r], configuration_, lower_, upper_, limit);
      boxes += proof.boxes;
      if (proof.proven) return true;
    }
    return false;
  }

  std::int64_t iterations() const { return search_.iterations(); }

 private:
  /// The error of a region with the links at X_WL_.
  PoseError errorAt(const PoseRegion& region) const {
    const Pose& X_WL = X_WL_[at(region.link)];
    return poseError(region, region.base < 0 ? X_WL : X_WL_[at(region.base)].inverse() * X_WL);
  }

  Search makeSearch() {
    std::vector<int> column(model_.variables.size(), -1);
    for (std::size_t c = 0; c < variables_.size(); ++c)
      column[at(variables_[c])] = static_cast<int>(c);
    forwardKinematics(model_, configuration_, X_WL_);
    std::vector<Chain> chains;
    std::vector<std::optional<Chain>> bases;
    std::vector<PreparedRegion> prepared;
    double away = 0;  // distance of any frame from its region, plus reach
    for (const PoseRegion& region : regions_) {
      chains.push_back(makeChain(model_, region, X_WL_, column));
      bases.emplace_back();
      if (region.base >= 0) bases.back() = makeBaseChain(model_, region, X_WL_, column);
      prepared.emplace_back(region);
      away = std::max(away, errorAt(region).position + chains.back().reach);
    }
    for (const int v : variables_) {
      const Variable& variable = model_.variables[at(v)];
      lower_.push_back(variable.lower);
      upper_.push_back(variable.upper);
      // Unlimited variables start within half a turn, within the remaining distance, or as a
      // quaternion.
      const double now = configuration_[at(v)];
      const Joint& joint = model_.joints[at(variable.joint)];
      const int k = v - joint.first_variable;
      const bool quaternion = joint.type == JointType::kFloating && k >= 3;
      const bool angle =
          joint.type == JointType::kContinuous || (joint.type == JointType::kPlanar && k == 2);
      const double width = angle ? kTwoPi / 2 : away;
      low_.push_back(quaternion                      ? -1
                     : std::isfinite(variable.lower) ? variable.lower
                                                     : now - width);
      high_.push_back(quaternion                      ? 1
                      : std::isfinite(variable.upper) ? variable.upper
                                                      : now + width);
    }
    // A joint that can make a whole turn has no limits during the search; normalize() brings it
    // back.
    std::vector<double> lower = lower_, upper = upper_;
    for (std::size_t c = 0; c < variables_.size(); ++c)
      if (periodic_[c] && upper[c] - lower[c] >= kTwoPi - kWholeTurnGap) {
        lower[c] = -std::numeric_limits<double>::infinity();
        upper[c] = -lower[c];
      }
    return {std::move(chains), std::move(bases), std::move(prepared),
            variables_,        std::move(lower), std::move(upper)};
  }

  /// Reduces angles by whole turns towards the configuration, and normalizes quaternions.
  void normalize(std::vector<double>& q) const {
    for (std::size_t c = 0; c < variables_.size(); ++c) {
      if (!periodic_[c]) continue;
      double& value = q[at(variables_[c])];
      const double now = configuration_[at(variables_[c])];
      // The nearest equal angle, or the next one within the limits.
      double turned = value + kTwoPi * std::floor((now - value) / kTwoPi + 0.5);
      if (turned < lower_[c]) turned += kTwoPi * std::ceil((lower_[c] - turned) / kTwoPi);
      if (turned > upper_[c]) turned -= kTwoPi * std::ceil((turned - upper_[c]) / kTwoPi);
      value = std::clamp(turned, lower_[c], upper_[c]);
    }
    for (const Joint& joint : model_.joints) {
      if (joint.type != JointType::kFloating || joint.first_variable < 0) continue;
      const std::size_t first = at(joint.first_variable) + 3;
      int solved = 0;
      for (const int v : variables_) solved += at(v) >= first && at(v) < first + 4 ? 1 : 0;
      double squared = 0;
      for (std::size_t k = first; k < first + 4; ++k) squared += q[k] * q[k];
      if (solved == 4 && squared > 0)
        for (std::size_t k = first; k < first + 4; ++k) q[k] /= std::sqrt(squared);
    }
  }

  const Model& model_;
  const std::vector<int>& variables_;
  const std::vector<char>& periodic_;
  std::span<const PoseRegion> regions_;
  std::vector<double> configuration_;
  LowDiscrepancy sequence_;
  std::vector<Pose> X_WL_;
  std::vector<double> lower_, upper_;  // limits
  std::vector<double> low_, high_;     // of starts
  Search search_;
  ClosedForm closed_form_;  // of the first region
  bool has_closed_form_ = false;
};

}  // namespace

InverseKinematics::InverseKinematics(std::shared_ptr<const Model> model, std::vector<int> variables)
    : model_(std::move(model)), variables_(std::move(variables)) {
  if (!model_) throw std::invalid_argument("InverseKinematics: a model is expected");
  std::vector<char> seen(model_->variables.size(), 0);
  for (const int v : variables_) {
    if (v < 0 || v >= static_cast<int>(seen.size()))
      throw std::invalid_argument("InverseKinematics: the model has no variable " +
                                  std::to_string(v));
    if (seen[at(v)])
      throw std::invalid_argument("InverseKinematics: variable " + std::to_string(v) +
                                  " is listed twice");
    seen[at(v)] = 1;
    const int index = model_->variables[at(v)].joint;
    const Joint& joint = model_->joints[at(index)];
    const bool angle = joint.type == JointType::kRevolute || joint.type == JointType::kContinuous ||
                       (joint.type == JointType::kPlanar && v - joint.first_variable == 2);
    const bool followed = std::any_of(model_->joints.begin(), model_->joints.end(),
                                      [&](const Joint& j) { return j.mimic == index; });
    periodic_.push_back(angle && !followed);
  }
}

IkResult InverseKinematics::solve(std::span<const PoseRegion> regions,
                                  std::span<const double> configuration,
                                  const IkOptions& options) const {
  check(*model_, regions, configuration);
  Task task(*model_, variables_, periodic_, regions, configuration, options.seed);
  IkResult result;
  double least = std::numeric_limits<double>::infinity();
  IkSolution solution;
  bool stopped = false;
  const auto prove = [&](int boxes) {
    if (options.prove && boxes > 0 && result.solutions.empty() &&
        task.provenUnreachable(boxes, result.proof_boxes))
      result.status = IkStatus::kUnreachable;
    return result.status == IkStatus::kUnreachable;
  };
  std::vector<IkSolution> closed;
  const auto add = [&](const IkSolution& found) {
    if (static_cast<int>(result.solutions.size()) < options.max_solutions &&
        std::none_of(result.solutions.begin(), result.solutions.end(),
                     [&](const IkSolution& other) { return task.same(found, other); }))
      result.solutions.push_back(found);
  };
  while (result.starts < options.starts &&
         static_cast<int>(result.solutions.size()) < options.max_solutions) {
    stopped = options.stop && options.stop();
    if (stopped) break;
    const int early = result.starts == 1                    ? 1
                      : result.starts == kStartsBeforeProof ? kEarlyProofBoxes
                                                            : 0;
    if (early > 0 && prove(std::min(early, options.proof_boxes))) break;
    const auto index = static_cast<std::uint64_t>(result.starts++);
    std::vector<double> q = task.start(index);
    const bool redundant = task.isRedundant();
    if (options.closed_form && task.hasClosedForm() && (redundant || index == 0)) {
      if (redundant && index == 0 && task.isNear(q) && task.solveFrom(q, solution)) {
        add(solution);
        continue;
      }
      closed.clear();
      bool complete = false;
      for (std::uint64_t k = 0; closed.empty() && k < (redundant ? kSweep : 1); ++k)
        complete = task.solveClosed(k == 0 ? q : task.start(index * kSweep + k),
                                    options.max_solutions, closed);
      for (const IkSolution& other : closed) add(other);
      if (!closed.empty() && complete && !redundant) {
        result.complete = true;
        break;
      }
      if (!closed.empty()) continue;
    }
    if (task.solveFrom(std::move(q), solution)) {
      add(solution);
    } else if (const double error = solution.error.position + solution.error.angle; error < least) {
      least = error;
      result.nearest = solution;
    }
  }
  if (!stopped && result.status != IkStatus::kUnreachable) prove(options.proof_boxes);
  result.iterations = task.iterations();
  if (result.solutions.empty()) return result;
  result.status = IkStatus::kFound;
  std::stable_sort(result.solutions.begin(), result.solutions.end(),
                   [&](const IkSolution& a, const IkSolution& b) {
                     return task.squaredDistance(a) < task.squaredDistance(b);
                   });
  result.nearest = result.solutions.front();
  return result;
}

std::optional<IkSolution> InverseKinematics::sample(std::span<const PoseRegion> regions,
                                                    std::span<const double> configuration,
                                                    std::uint64_t index, std::uint64_t seed) const {
  check(*model_, regions, configuration);
  const LowDiscrepancy sequence(6 * regions.size(), mixed(seed));
  std::vector<PoseRegion> drawn(regions.begin(), regions.end());
  std::size_t dimension = 0;
  for (PoseRegion& region : drawn)
    for (auto* ranges : {&region.position, &region.rpy})
      for (auto& range : *ranges) {
        const double width = range.second - range.first;
        const double value =
            std::min(range.first + width * sequence.at(index, dimension++), range.second);
        range = {value, value};
      }
  Task task(*model_, variables_, periodic_, drawn, configuration, seed);
  IkSolution solution;
  if (task.hasClosedForm()) {
    std::vector<IkSolution> closed;
    bool complete = false;
    const std::uint64_t sweep = task.isRedundant() ? kSweep : 1;
    for (std::uint64_t k = 0; closed.empty() && k < sweep; ++k)
      complete = task.solveClosed(task.start(1 + index * sweep + k), 1, closed, index);
    if (!closed.empty()) return closed.front();
    if (complete && !task.isRedundant()) return std::nullopt;
  }
  for (std::uint64_t k = 0; k < kStartsOfSample; ++k)
    if (task.solveFrom(task.start(1 + index * kStartsOfSample + k), solution)) return solution;
  return std::nullopt;
}

}  // namespace leeway::robots
