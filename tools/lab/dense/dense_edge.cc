// First collision along an edge: checks every place, except where bounds prove two shapes apart.

#include <fcl/fcl.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/lab/dense/dense_body.h"
#include "tools/lab/dense/dense_world.h"

namespace leeway::dense {
namespace {

using Eigen::Isometry3d;

/// Exceeds the rounding of FCL's bounds [m].
constexpr double kGapSlack = 1e-6;
/// A proof for this share of the places cleared by the nearest known parts is accepted, because a
/// longer one costs more than it saves.
constexpr double kShareOfHop = 0.25;

}  // namespace

/// Distance between two leaves [m]; a lower bound if one is a box.
double DenseWorld::leafGap(const Bounds& a, const Bounds& b, const NodePair& pair,
                           const Isometry3d& X_AB) {
  const Bounds::Node &u = a.nodes[pair.first], &v = b.nodes[pair.second];
  if (!a.mesh || !b.mesh) return Bounds::gap(u, v, X_AB);
  const std::array<Eigen::Vector3d, 3> s = a.corners(u), t = b.corners(v);
  Eigen::Vector3d on_s, on_t;
  return fcl::detail::TriangleDistance<double>::triDistance(s.data(), t.data(), X_AB, on_s, on_t);
}

/// Number of following places, at most `most`, at which two shapes are proven apart. Decided node
/// by node, because near a joint, nodes move less than at the chain's end.
double DenseWorld::placesApart(ShapePair& shapes, const Approach& approach, double most) {
  const Body &x = *bodies_[pairs_[shapes.bodies].first],
             &y = *bodies_[pairs_[shapes.bodies].second];
  const Bounds &a = *x.bounds[shapes.a], &b = *y.bounds[shapes.b];
  NodePair& nearest = shapes.nearest;
  const Isometry3d X_AB = x.objects[shapes.a]->getTransform().inverse(Eigen::Isometry) *
                          y.objects[shapes.b]->getTransform();
  const auto places = [&](const NodePair& pair) {
    const Bounds::Node &u = a.nodes[pair.first], &v = b.nodes[pair.second];
    return (Bounds::gap(u, v, X_AB) - kGapSlack) / approach.step(u.reach, v.reach);
  };
  const auto leaf_places = [&](const NodePair& pair) {
    const Bounds::Node &u = a.nodes[pair.first], &v = b.nodes[pair.second];
    return (leafGap(a, b, pair, X_AB) - kGapSlack) / approach.step(u.reach, v.reach);
  };
  // The nearest pair of leaves rarely changes, so this starts with it and prunes pairs that are
  // much farther apart.
  const double whole = places({0, 0});
  if (whole >= most) return whole;
  const bool known = a.nodes[nearest.first].child < 0 && b.nodes[nearest.second].child < 0;
  double nearest_places = known ? std::max(leaf_places(nearest), 0.0) : most, apart = most;
  nodes_.assign(1, {{0, 0}, whole});
  while (!nodes_.empty()) {
    const auto [pair, bound] = nodes_.back();
    nodes_.pop_back();
    const Bounds::Node &u = a.nodes[pair.first], &v = b.nodes[pair.second];
    const bool is_leaf = u.child < 0 && v.child < 0;
    const bool is_far = bound >= std::min(most, kShareOfHop * nearest_places);
    if (is_far) {
      apart = std::min(apart, bound);
      continue;
    }
    if (is_leaf) {
      const double exact = leaf_places(pair);
      apart = std::min(apart, exact);
      if (exact < 0) return exact;
      if (exact < nearest_places) nearest_places = exact, nearest = pair;
      continue;
    }
    const bool first = v.child < 0 || (u.child >= 0 && u.radius > v.radius);
    Timed children[2];
    for (std::size_t k = 0; k < 2; ++k) {
      NodePair& child = children[k].first;
      child = pair;
      (first ? child.first : child.second) =
          static_cast<std::size_t>(first ? u.child : v.child) + k;
      children[k].second = std::max(bound, places(child));
    }
    const bool turned = children[0].second < children[1].second;  // nearer child first
    nodes_.push_back(children[turned ? 1 : 0]);
    nodes_.push_back(children[turned ? 0 : 1]);
  }
  return apart;
}

/// For each pair, a bound on the approach of its bodies between places. A joint that carries both
/// does not move them relative to each other. Another revolute joint moves a point by its turn
/// times the chain's length in between, a prismatic one by its slide.
std::vector<DenseWorld::Approach> DenseWorld::largestSteps(const std::vector<std::string>& names,
                                                           const std::vector<double>& from,
                                                           const std::vector<double>& to,
                                                           int count) const {
  std::vector<double> turns(model_->joints.size(), 0);
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const robots::Joint* joint = &model_->joints[i];
    double factor = 1;
    if (joint->mimic >= 0) {
      factor = joint->multiplier;
      joint = &model_->joints[static_cast<std::size_t>(joint->mimic)];
    }
    for (std::size_t k = 0; k < names.size(); ++k)
      if (names[k] == joint->name) turns[i] = std::abs(factor * (to[k] - from[k])) / count;
  }
  // A link's joint has the link's number.
  const auto parentOf = [&](int link) {
    return model_->joints[static_cast<std::size_t>(link)].parent_link;
  };
  const auto carries = [&](int link, int other) {
    while (other >= 0 && other != link) other = parentOf(other);
    return other >= 0;
  };
  const auto moved = [&](const Body& body, int other) {
    double length = 0;  // joint to the origin of the body's link
    Moved sum;
    for (int link = body.link; link >= 0; link = parentOf(link)) {
      const robots::Joint& joint = model_->joints[static_cast<std::size_t>(link)];
      if (carries(link, other)) break;
      const double turn = turns[static_cast<std::size_t>(link)];
      const bool slides = joint.type == robots::JointType::kPrismatic;
      sum.turn += slides ? 0 : turn;
      sum.rest += slides ? turn : turn * length;
      length += joint.X_PJ.translation.norm();
      if (!slides) continue;
      // A slide adds the length of its limits.
      const robots::Joint& master =
          joint.mimic < 0 ? joint : model_->joints[static_cast<std::size_t>(joint.mimic)];
      const robots::Variable& v =
          model_->variables[static_cast<std::size_t>(master.first_variable)];
      const double most = std::max(std::abs(v.lower), std::abs(v.upper));
      length += joint.mimic < 0 ? most : std::abs(joint.multiplier) * most + std::abs(joint.offset);
    }
    return sum;
  };
  std::vector<Approach> approaches;
  for (const auto& [i, j] : pairs_)
    approaches.push_back(
        {moved(*bodies_[i], bodies_[j]->link), moved(*bodies_[j], bodies_[i]->link)});
  return approaches;
}

std::optional<double> DenseWorld::firstCollision(const std::vector<std::string>& names,
                                                 const std::vector<double>& from,
                                                 const std::vector<double>& to, int count) {
  const std::vector<Approach> approaches = largestSteps(names, from, to, count);
  due_.assign(shape_pairs_.size(), 0);
  placed_.assign(bodies_.size(), -1);
  std::vector<double> q(from.size());
  int next = 0;
  for (int place = 0; place <= count; place = next) {
    const double t = static_cast<double>(place) / count;
    for (std::size_t k = 0; k < q.size(); ++k) q[k] = (1 - t) * from[k] + t * to[k];
    placeLinks(names, q);
    next = count + 1;
    for (std::size_t p = 0; p < shape_pairs_.size(); ++p) {
      if (due_[p] <= place) {
        ShapePair& pair = shape_pairs_[p];
        const auto& [i, j] = pairs_[pair.bodies];
        for (const std::size_t b : {i, j}) {
          if (placed_[b] == place) continue;
          placed_[b] = place;
          placeObjects(*bodies_[b]);
        }
        const double places = placesApart(pair, approaches[pair.bodies], count - place + 1.0);
        if (places < 0 && collide(pair)) return t;
        due_[p] = place + 1 + static_cast<int>(std::max(places, 0.0));
      }
      next = std::min(next, due_[p]);
    }
  }
  return std::nullopt;
}

}  // namespace leeway::dense
