#include "planner/space/connect_trees.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "collision/base/sine_cosine.h"
#include "planner/base/largest_value.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

constexpr float kUnlimited = std::numeric_limits<float>::infinity();

/// Halvings of a sample's way into the ellipsoid of shorter paths.
constexpr int kInformedHalvings = 10;

/// The number at `share` of the way from one end to the other; rounding never leaves that range.
double placedBetween(double lower, double upper, double share) {
  return std::clamp(lower + share * (upper - lower), lower, upper);
}

/// The weight of a radian if the planned variables are those of one planar or floating joint;
/// otherwise 0.
double bodyTurn(const ConfigurationSpace& space) {
  const robots::Model& model = space.model();
  int joint = -1;
  for (const int v : space.variables()) {
    const int other = model.variables[static_cast<std::size_t>(v)].joint;
    if (joint >= 0 && other != joint) return 0;
    joint = other;
  }
  if (joint < 0) return 0;
  const robots::JointType type = model.joints[static_cast<std::size_t>(joint)].type;
  const bool body = type == robots::JointType::kPlanar || type == robots::JointType::kFloating;
  const bool whole = space.size() == model.joints[static_cast<std::size_t>(joint)].variable_count;
  return body && whole ? space.parts().back().weight : 0;
}

}  // namespace

double usefulExtent(const ConfigurationSpace& space) {
  double squared = 0;
  for (const ConfigurationSpace::Part& part : space.parts()) {
    double range = std::numbers::pi;
    if (part.kind == ConfigurationSpace::Kind::kLine) {
      range = space.upper(part.first) - space.lower(part.first);
      if (isAngle(space.model(), space.variables()[static_cast<std::size_t>(part.first)]))
        range = std::min(range, std::numbers::pi);
    }
    squared += part.weight * range * part.weight * range;
  }
  return std::sqrt(squared);
}

double defaultRange(const ConfigurationSpace& space) {
  double dimension = 0;
  for (const ConfigurationSpace::Part& part : space.parts())
    dimension += part.kind == ConfigurationSpace::Kind::kRotation ? 3 : 1;
  const double extent = usefulExtent(space), turn = bodyTurn(space) * kBodyTurn;
  const double range = extent * std::min(kLongestRange, kRangeShare / (dimension * dimension));
  return turn > 0 ? std::min(range, std::max(turn, extent * kLeastBodyRange)) : range;
}

bool isBody(const ConfigurationSpace& space) { return bodyTurn(space) > 0; }

ConnectTrees::ConnectTrees(const ConnectTask& task, const ConnectSettings& settings,
                           std::uint64_t seed)
    : task_(task),
      settings_(settings),
      random_(seed),
      size_(static_cast<std::size_t>(task.space.size())),
      trees_{Tree(task.space), Tree(task.space)},
      sample_(size_),
      next_(size_),
      focus_(size_),
      drawn_(size_) {
  // Replaces a range that is not positive, or so short that a connection would never end.
  const double extent = usefulExtent(task.space);
  if (!(settings_.range >= kShortestRange * extent)) settings_.range = kShortestRange * extent;
  if (!(settings_.range > 0)) settings_.range = 1;  // all joints are locked, or two points coincide
  // With many joints ranges are short, and a domain of a few ranges would contain no sample. Nodes
  // that have failed once would then be excluded from the search.
  const double least_domain = bodyTurn(task.space) > 0 ? 0 : kLongestRange * extent;
  domain_ = static_cast<float>(std::max(settings_.range, least_domain));
  if (settings_.low_discrepancy) {
    std::size_t dimensions = 0;
    for (const ConfigurationSpace::Part& part : task.space.parts())
      dimensions += part.kind == ConfigurationSpace::Kind::kRotation ? 3 : 1;
    sequence_.emplace(dimensions, seed);
  }
  add(trees_[0], task.start, 0, 0);
  takeGoals();
}

void ConnectTrees::takeGoals() {
  for (; goals_ < task_.goals.size(); ++goals_)
    add(trees_[1], task_.goals[goals_], static_cast<std::uint32_t>(trees_[1].nearest.size()), 0);
}

std::span<const double> ConnectTrees::pointOf(const Tree& tree, std::uint32_t node) const {
  return std::span<const double>(tree.points).subspan(node * size_, size_);
}

std::uint32_t ConnectTrees::add(Tree& tree, std::span<const double> point, std::uint32_t parent,
                                double step) {
  const auto node = static_cast<std::uint32_t>(tree.nearest.size());
  tree.nearest.add(point);
  if (node == 0) tree.lower = tree.upper = {point.begin(), point.end()};
  for (std::size_t i = 0; task_.slide != nullptr && i < size_; ++i) {
    tree.lower[i] = std::min(tree.lower[i], point[i]);
    tree.upper[i] = std::max(tree.upper[i], point[i]);
  }
  tree.points.insert(tree.points.end(), point.begin(), point.end());
  tree.parent.push_back(parent);
  tree.radius.push_back(kUnlimited);
  tree.cost.push_back(node == parent ? 0 : tree.cost[parent] + step);
  return node;
}

double ConnectTrees::draw(std::size_t dimension) {
  return sequence_ ? sequence_->at(samples_, dimension) : random_.uniform();
}

void ConnectTrees::drawRotation(std::size_t dimension, double* xyzw) {
  if (!sequence_) {
    random_.quaternion(xyzw);
    return;
  }
  // K. Shoemake, "Uniform random rotations", Graphics Gems III, 1992.
  const double share = draw(dimension);
  const double radius[] = {std::sqrt(1 - share), std::sqrt(share)};
  for (std::size_t i = 0; i < 2; ++i) {
    double sine, cosine;
    collision::sineCosine(2 * std::numbers::pi * draw(dimension + 1 + i), sine, cosine);
    xyzw[2 * i] = radius[i] * sine;
    xyzw[2 * i + 1] = radius[i] * cosine;
  }
}

double ConnectTrees::between(std::size_t i, double weight, double drawn) const {
  const auto [low, high] = std::minmax(std::max(trees_[0].lower[i], trees_[1].lower[i]),
                                       std::min(trees_[0].upper[i], trees_[1].upper[i]));
  const double more = kBetweenMore * settings_.range / weight;
  const int v = static_cast<int>(i);
  return placedBetween(std::max(low - more, task_.space.lower(v)),
                       std::min(high + more, task_.space.upper(v)), drawn);
}

void ConnectTrees::sample() {
  const bool is_between = task_.slide != nullptr && random_.uniform() < kBetweenShare;
  ++samples_;
  std::size_t dimension = 0;
  for (const ConfigurationSpace::Part& part : task_.space.parts()) {
    const auto i = static_cast<std::size_t>(part.first);
    switch (part.kind) {
      case ConfigurationSpace::Kind::kLine: {
        const double drawn = draw(dimension++);
        sample_[i] = is_between ? between(i, part.weight, drawn)
                                : placedBetween(task_.space.lower(part.first),
                                                task_.space.upper(part.first), drawn);
        break;
      }
      case ConfigurationSpace::Kind::kCircle:
        sample_[i] = -std::numbers::pi + 2 * std::numbers::pi * draw(dimension++);
        break;
      case ConfigurationSpace::Kind::kRotation:
        drawRotation(dimension, &sample_[i]);
        dimension += 3;
        break;
    }
  }
  if (isBounded()) pullSample();
}

double ConnectTrees::toRoot(int tree, std::span<const double> point) const {
  if (tree == 0) return task_.space.distance(task_.start, point);
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<double>& goal : task_.goals)
    least = std::min(least, task_.space.distance(point, goal));
  return least;
}

void ConnectTrees::pullSample() {
  const auto mayHelp = [&] { return toRoot(0, sample_) + toRoot(1, sample_) < task_.bound; };
  if (mayHelp()) return;
  drawn_ = sample_;
  const int goal = random_.index(static_cast<int>(task_.goals.size()));
  task_.space.interpolate(task_.start, task_.goals[static_cast<std::size_t>(goal)],
                          random_.uniform(), focus_);
  double in = 0, out = 1;
  for (int i = 0; i < kInformedHalvings; ++i) {
    const double middle = (in + out) / 2;
    task_.space.interpolate(focus_, drawn_, middle, sample_);
    (mayHelp() ? in : out) = middle;
  }
  task_.space.interpolate(focus_, drawn_, in * random_.uniform(), sample_);
}

bool ConnectTrees::stepTowards(const Tree& tree, std::uint32_t node, std::span<const double> target,
                               double distance) {
  const std::span<const double> from = pointOf(tree, node);
  task_.space.interpolate(from, target, std::min(1.0, settings_.range / distance), next_);
  return isFree(tree, from);
}

bool ConnectTrees::isFree(const Tree& tree, std::span<const double> from) const {
  return &tree == &trees_[0] ? task_.isFree(from, next_) : task_.isFree(next_, from);
}

std::uint32_t ConnectTrees::slideTowards(Tree& tree, std::uint32_t node,
                                         std::span<const double> target) {
  if (task_.slide == nullptr) return node;
  slid_.clear();
  (*task_.slide)(pointOf(tree, node), target, slid_);
  for (std::size_t i = 0; i < slid_.size(); i += size_) {
    const std::span<const double> point = std::span<const double>(slid_).subspan(i, size_);
    node = add(tree, point, node, task_.space.distance(pointOf(tree, node), point));
  }
  return node;
}

void ConnectTrees::noteGap(std::uint32_t node, std::span<const double> to) {
  const std::span<const double> from = pointOf(trees_[growing_], node);
  const double distance = task_.space.distance(from, to);
  if (!(distance < gap_.distance)) return;
  gap_.distance = distance;
  (growing_ == 0 ? gap_.of_start : gap_.of_goals).assign(from.begin(), from.end());
  (growing_ == 0 ? gap_.of_goals : gap_.of_start).assign(to.begin(), to.end());
}

bool ConnectTrees::iterate() {
  const std::size_t sizes[2] = {trees_[0].nearest.size(), trees_[1].nearest.size()};
  growing_ =
      settings_.balance && sizes[0] != sizes[1] ? (sizes[0] < sizes[1] ? 0 : 1) : 1 - growing_;
  Tree& tree = trees_[growing_];
  Tree& other = trees_[1 - growing_];
  sample();
  const NearestNodes::Nearest near = tree.nearest.nearest(sample_);
  if (near.distance > tree.radius[near.node]) return false;
  const double distance = task_.space.distance(pointOf(tree, near.node), sample_);
  if (!(distance > 0)) return false;
  const double step = std::min(settings_.range, distance);
  if (isBounded()) {
    task_.space.interpolate(pointOf(tree, near.node), sample_, step / distance, next_);
    if (!(tree.cost[near.node] + step + toRoot(1 - growing_, next_) < task_.bound)) return false;
  }
  std::uint32_t node = stepTowards(tree, near.node, sample_, distance)
                           ? add(tree, next_, near.node, step)
                           : slideTowards(tree, near.node, sample_);
  float& radius = tree.radius[near.node];
  if (node == near.node) {
    if (settings_.dynamic_domain) {
      radius = radius == kUnlimited ? kDomainRadius * domain_
                                    : std::max(radius * (1 - kDomainRate), kLeastDomain * domain_);
    }
    return false;
  }
  radius *= 1 + kDomainRate;
  // Steps of equal length to the nearest node of the other tree, as long as they are free.
  const std::span<const double> end = pointOf(tree, node);
  from_.assign(end.begin(), end.end());
  const std::uint32_t goal = other.nearest.nearest(from_).node;
  const std::span<const double> to = pointOf(other, goal);
  const double gap = task_.space.distance(from_, to);
  if (!(tree.cost[node] + gap + other.cost[goal] < task_.bound)) return false;
  const double steps = std::max(1.0, std::ceil(gap / settings_.range));
  for (double i = 1; i <= steps; ++i) {
    if (i == steps)
      std::copy(to.begin(), to.end(), next_.begin());
    else
      task_.space.interpolate(from_, to, i / steps, next_);
    if (!isFree(tree, pointOf(tree, node))) {
      node = slideTowards(tree, node, to);
      if (!std::equal(to.begin(), to.end(), pointOf(tree, node).begin())) {
        noteGap(node, to);
        return false;
      }
      break;
    }
    if (i < steps) node = add(tree, next_, node, gap / steps);
  }
  met_[growing_] = node;
  met_[1 - growing_] = goal;
  return true;
}

std::vector<std::vector<double>> ConnectTrees::path() const {
  std::vector<std::vector<double>> path;
  const auto append = [&](const Tree& tree, std::uint32_t node) {
    for (;; node = tree.parent[node]) {
      const std::span<const double> point = pointOf(tree, node);
      if (path.empty() || !std::equal(point.begin(), point.end(), path.back().begin()))
        path.emplace_back(point.begin(), point.end());
      if (tree.parent[node] == node) return;
    }
  };
  append(trees_[0], met_[0]);
  std::reverse(path.begin(), path.end());
  append(trees_[1], met_[1]);
  return path;
}

}  // namespace leeway::planner
