#include "tools/truth/dense/dense_world.h"

#include <fcl/fcl.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <utility>

#include "tools/truth/dense/fcl_shape.h"

namespace leeway::dense {
namespace {

using collision::Shape;
using Eigen::Isometry3d;
using Named = std::vector<std::pair<std::string, double>>;

Isometry3d readPose(const YAML::Node& node) {
  const YAML::Node p = node["position"], q = node["orientation"];
  Isometry3d X = Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(p[0].as<double>(), p[1].as<double>(), p[2].as<double>());
  X.linear() =
      Eigen::Quaterniond(q[3].as<double>(), q[0].as<double>(), q[1].as<double>(), q[2].as<double>())
          .normalized()
          .toRotationMatrix();
  return X;
}

Shape readPrimitive(const YAML::Node& node, const std::string& file) {
  const std::string type = node["type"].as<std::string>();
  const YAML::Node d = node["dimensions"];
  if (type == "box")
    return Shape::box(0.5 *
                      Eigen::Vector3d(d[0].as<double>(), d[1].as<double>(), d[2].as<double>()));
  if (type == "cylinder") return Shape::cylinder(d[1].as<double>(), 0.5 * d[0].as<double>());
  if (type == "sphere") return Shape::sphere(d[0].as<double>());
  throw std::runtime_error(file + ": primitive '" + type +
                           "'; this checker knows box, cylinder and sphere");
}

/// Rounding of FCL's bounds, generously [m].
constexpr double kGapSlack = 1e-6;
/// Where two bodies are proven apart for so much of the places that their nearest known parts are,
/// no longer proof is looked for.
constexpr double kShareOfHop = 0.25;

double valueOf(const Named& values, const std::string& name) {
  for (const auto& [known, value] : values)
    if (known == name) return value;
  return 0;
}

double largestError(const Named& wanted, const std::vector<std::string>& names,
                    const std::vector<double>& row) {
  double worst = 0;
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const auto& [name, value] : wanted)
      if (name == names[i]) worst = std::max(worst, std::abs(value - row[i]));
  return worst;
}

}  // namespace

std::string requestOf(const std::string& scene) {
  const std::filesystem::path path = scene;
  std::string name = path.filename().string();
  const std::size_t at = name.find("scene");
  if (at == std::string::npos)
    throw std::runtime_error(scene + ": a file named sceneNNNN.yaml is expected");
  return (path.parent_path() / name.replace(at, 5, "request")).string();
}

/// What holds a shape: of a mesh FCL's hierarchy over it, of anything else a box.
struct DenseWorld::Bounds {
  /// A box, and for a part of a mesh FCL's rounded rectangle, in the shape's frame; how far from
  /// the origin of its link it reaches, and its children, the second after the first; -1: none.
  struct Node {
    Eigen::Vector3d center, half_extents;
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    double radius = 0, reach = 0;
    int child = -1, triangle = -1;
    const fcl::RSSd* rss = nullptr;
  };
  std::shared_ptr<const FclSurface> mesh;
  std::vector<Node> nodes;

  Bounds(const FclGeometry& geometry, const Isometry3d& X_LG)
      : mesh(std::dynamic_pointer_cast<const FclSurface>(geometry)) {
    if (mesh != nullptr) {
      for (int i = 0; i < mesh->getNumBVs(); ++i) {
        const fcl::BVNode<fcl::OBBRSSd>& node = mesh->getBV(i);
        add(node.bv.obb.To, node.bv.obb.extent, X_LG);
        nodes.back().axes = node.bv.obb.axis;
        if (node.isLeaf())
          nodes.back().triangle = node.primitiveId();
        else
          nodes.back().child = node.leftChild();
        nodes.back().rss = &node.bv.rss;
      }
      return;
    }
    geometry->computeLocalAABB();
    add(geometry->aabb_local.center(),
        0.5 * (geometry->aabb_local.max_ - geometry->aabb_local.min_), X_LG);
  }
  void add(const Eigen::Vector3d& center, const Eigen::Vector3d& half_extents,
           const Isometry3d& X_LG) {
    nodes.emplace_back();
    nodes.back().center = center;
    nodes.back().half_extents = half_extents;
    nodes.back().radius = half_extents.norm();
    nodes.back().reach = (X_LG * center).norm() + nodes.back().radius;
  }
  /// The corners of a node's triangle.
  std::array<Eigen::Vector3d, 3> corners(const Node& leaf) const {
    const fcl::Triangle& t = mesh->tri_indices[leaf.triangle];
    return {mesh->vertices[t[0]], mesh->vertices[t[1]], mesh->vertices[t[2]]};
  }
  /// At most the distance between what two nodes hold; below 0 it says nothing.
  static double gap(const Node& a, const Node& b, const Isometry3d& X_AB) {
    const Eigen::Vector3d to_b = X_AB * b.center - a.center;
    const double balls = to_b.norm() - a.radius - b.radius;
    if (balls > a.radius + b.radius) return balls;  // their shapes matter little
    if (a.rss != nullptr && b.rss != nullptr)
      return std::max(balls, fcl::distance(fcl::Matrix3d(X_AB.linear()),
                                           fcl::Vector3d(X_AB.translation()), *a.rss, *b.rss));
    // A box around b whose faces are parallel to those of a.
    const Eigen::Vector3d around =
        (a.axes.transpose() * (X_AB.linear() * b.axes)).cwiseAbs() * b.half_extents;
    const Eigen::Vector3d apart = (a.axes.transpose() * to_b).cwiseAbs() - a.half_extents - around;
    return std::max(balls, apart.cwiseMax(0).norm());
  }
};

struct DenseWorld::Body {
  std::string name;
  int link = -1;  // -1: the world
  std::vector<Isometry3d> X_LG;
  std::vector<FclGeometry> geometries;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
  std::vector<std::shared_ptr<const Bounds>> bounds;
  std::vector<Shape> shapes;
  std::vector<collision::Pose> X_WG;

  void add(const Shape& shape, const Isometry3d& X) {
    const FclGeometry geometry = toFcl(shape);
    add(shape, X, geometry, std::make_shared<const Bounds>(geometry, X));
  }
  void add(const Shape& shape, const Isometry3d& X, const FclGeometry& geometry,
           std::shared_ptr<const Bounds> of_shape) {
    shapes.push_back(shape);
    geometries.push_back(geometry);
    bounds.push_back(std::move(of_shape));
    X_WG.push_back({X.linear(), X.translation()});
    X_LG.push_back(X);
    objects.push_back(std::make_unique<fcl::CollisionObjectd>(geometry, X));
    objects.back()->computeAABB();
  }
};

DenseWorld::DenseWorld(std::shared_ptr<const robots::Model> model, const std::string& scene_file,
                       const std::string& request_file)
    : model_(std::move(model)), X_WL_(model_->links.size()) {
  addRobot();
  readScene(scene_file);
  readRequest(request_file);
  listPairs();
}

DenseWorld::DenseWorld(const DenseWorld& other, const std::string& scene_file,
                       const std::string& request_file)
    : model_(other.model_), X_WL_(model_->links.size()) {
  for (std::size_t i = 0; i < model_->links.size(); ++i) {
    const Body& like = *other.bodies_[i];
    bodies_.push_back(std::make_unique<Body>());
    bodies_[i]->name = like.name;
    bodies_[i]->link = like.link;
    for (std::size_t g = 0; g < like.shapes.size(); ++g)
      bodies_[i]->add(like.shapes[g], like.X_LG[g], like.geometries[g], like.bounds[g]);
  }
  readScene(scene_file);
  readRequest(request_file);
  listPairs();
}

DenseWorld::~DenseWorld() = default;

void DenseWorld::addRobot() {
  for (std::size_t i = 0; i < model_->links.size(); ++i) {
    auto body = std::make_unique<Body>();
    body->name = model_->links[i].name;
    body->link = static_cast<int>(i);
    for (const robots::Geometry& g : model_->links[i].geometries)
      body->add(g.shape, isometry(g.X_BG));
    bodies_.push_back(std::move(body));
  }
}

void DenseWorld::readScene(const std::string& file) {
  const YAML::Node scene = YAML::LoadFile(file);
  for (const YAML::Node& object : scene["world"]["collision_objects"]) {
    auto body = std::make_unique<Body>();
    body->name = object["id"].as<std::string>();
    const Isometry3d X_WO = object["pose"] ? readPose(object["pose"]) : Isometry3d::Identity();
    for (std::size_t i = 0; i < object["primitives"].size(); ++i)
      body->add(readPrimitive(object["primitives"][i], file),
                X_WO * readPose(object["primitive_poses"][i]));
    bodies_.push_back(std::move(body));
  }
  const YAML::Node matrix = scene["allowed_collision_matrix"];
  const auto names = matrix["entry_names"].as<std::vector<std::string>>();
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (matrix["entry_values"][i][j].as<bool>()) allowed_.emplace_back(names[i], names[j]);
}

void DenseWorld::readRequest(const std::string& file) {
  const YAML::Node request = YAML::LoadFile(file);
  const YAML::Node state = request["start_state"]["joint_state"];
  for (std::size_t i = 0; i < state["name"].size(); ++i)
    start_.emplace_back(state["name"][i].as<std::string>(), state["position"][i].as<double>());
  for (const YAML::Node& constraint : request["goal_constraints"][0]["joint_constraints"])
    goal_.emplace_back(constraint["joint_name"].as<std::string>(),
                       constraint["position"].as<double>());
}

bool DenseWorld::mayTouch(const std::string& a, const std::string& b) const {
  return std::any_of(allowed_.begin(), allowed_.end(), [&](const auto& pair) {
    return (pair.first == a && pair.second == b) || (pair.first == b && pair.second == a);
  });
}

void DenseWorld::listPairs() {
  // The link that carries each link rigidly: bodies of one carrier never move against one another.
  std::vector<int> carrier(model_->links.size());
  std::vector<bool> planned(model_->links.size(), false);
  for (std::size_t i = 0; i < model_->links.size(); ++i) {
    const robots::Joint& joint = model_->joints[i];
    const bool moves = std::any_of(goal_.begin(), goal_.end(),
                                   [&](const auto& g) { return g.first == joint.name; }) ||
                       joint.mimic >= 0;
    const int parent = joint.parent_link;
    carrier[i] = moves        ? static_cast<int>(i)
                 : parent < 0 ? -1
                              : carrier[static_cast<std::size_t>(parent)];
  }
  const auto carrierOf = [&](const Body& b) {
    return b.link < 0 ? -1 : carrier[static_cast<std::size_t>(b.link)];
  };
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (carrierOf(*bodies_[i]) != carrierOf(*bodies_[j]) &&
          !mayTouch(bodies_[i]->name, bodies_[j]->name))
        pairs_.emplace_back(i, j);
  for (std::size_t p = 0; p < pairs_.size(); ++p)
    for (std::size_t a = 0; a < bodies_[pairs_[p].first]->shapes.size(); ++a)
      for (std::size_t b = 0; b < bodies_[pairs_[p].second]->shapes.size(); ++b)
        shape_pairs_.push_back({p, a, b});
}

void DenseWorld::placeLinks(const std::vector<std::string>& names,
                            const std::vector<double>& positions) {
  const auto position = [&](const std::string& name) {
    const auto named = std::find(names.begin(), names.end(), name);
    return named != names.end() ? positions[static_cast<std::size_t>(named - names.begin())]
                                : valueOf(start_, name);
  };
  for (std::size_t i = 0; i < model_->links.size(); ++i) {
    const robots::Joint& joint = model_->joints[i];
    double q = 0;
    if (joint.mimic >= 0) {
      q = joint.multiplier * position(model_->joints[static_cast<std::size_t>(joint.mimic)].name) +
          joint.offset;
    } else {
      q = position(joint.name);
    }
    Isometry3d X = joint.parent_link < 0 ? Isometry3d::Identity()
                                         : X_WL_[static_cast<std::size_t>(joint.parent_link)];
    X = X * isometry(joint.X_PJ);
    switch (joint.type) {
      case robots::JointType::kFixed:
        break;
      case robots::JointType::kRevolute:
      case robots::JointType::kContinuous:
        X.rotate(Eigen::AngleAxisd(q, joint.axis));
        break;
      case robots::JointType::kPrismatic:
        X.translate(q * joint.axis);
        break;
      case robots::JointType::kPlanar:
      case robots::JointType::kFloating:
        // A base that the SRDF lets float stands at the origin in all of MotionBenchMaker.
        if (joint.parent_link >= 0)
          throw std::runtime_error("joint '" + joint.name +
                                   "': this checker knows joints of one degree of freedom");
        break;
    }
    X_WL_[i] = X;
  }
}

void DenseWorld::placeObjects(Body& body) const {
  if (body.link < 0) return;
  const Isometry3d& X = X_WL_[static_cast<std::size_t>(body.link)];
  for (std::size_t g = 0; g < body.objects.size(); ++g) {
    const Isometry3d X_WG = X * body.X_LG[g];
    body.X_WG[g] = {X_WG.linear(), X_WG.translation()};
    body.objects[g]->setTransform(X_WG);
    body.objects[g]->computeAABB();
  }
}

void DenseWorld::place(const std::vector<std::string>& names,
                       const std::vector<double>& positions) {
  placeLinks(names, positions);
  for (const auto& body : bodies_) placeObjects(*body);
}

/// Whether two shapes meet where they are.
bool DenseWorld::collide(const ShapePair& pair) const {
  const auto& [i, j] = pairs_[pair.bodies];
  const fcl::CollisionObjectd &a = *bodies_[i]->objects[pair.a], &b = *bodies_[j]->objects[pair.b];
  if (!a.getAABB().overlap(b.getAABB())) return false;
  fcl::CollisionResultd result;
  return fcl::collide(&a, &b, fcl::CollisionRequestd(1, false), result) > 0;
}

/// The distance between two nodes without children; of a box, at most that.
double DenseWorld::leafGap(const Bounds& a, const Bounds& b, const NodePair& pair,
                           const Isometry3d& X_AB) {
  const Bounds::Node &u = a.nodes[pair.first], &v = b.nodes[pair.second];
  if (!a.mesh || !b.mesh) return Bounds::gap(u, v, X_AB);
  const std::array<Eigen::Vector3d, 3> s = a.corners(u), t = b.corners(v);
  Eigen::Vector3d on_s, on_t;
  return fcl::detail::TriangleDistance<double>::triDistance(s.data(), t.data(), X_AB, on_s, on_t);
}

/// For how many places to come, at most `most`, two shapes are proven apart, by their nodes: those
/// near a joint come less far in a place than those at the end of the chain.
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
  // What was nearest before is so as a rule: nothing that is farther by far needs to be divided.
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
    const bool turned = children[0].second < children[1].second;  // the nearer is taken first
    nodes_.push_back(children[turned ? 1 : 0]);
    nodes_.push_back(children[turned ? 0 : 1]);
  }
  return apart;
}

Collision DenseWorld::check(const std::vector<std::string>& names,
                            const std::vector<double>& positions) {
  place(names, positions);
  for (const ShapePair& pair : shape_pairs_) {
    const auto& [i, j] = pairs_[pair.bodies];
    if (collide(pair)) return {true, bodies_[i]->name, bodies_[j]->name};
  }
  return {};
}

/// For each pair, how far its bodies can come towards each other from one place to the next: joints
/// that carry both move neither against the other; each of the rest moves a point by its turn times
/// the length of the chain between them, and a slide by itself.
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
    double length = 0;  // from the joint to the origin of the body's link
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
      // What slides lies as far out as its limits allow.
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

bool DenseWorld::closerThan(const std::vector<std::string>& names,
                            const std::vector<double>& positions, double threshold) {
  place(names, positions);
  collision::DistanceRequest request;
  request.threshold = threshold;
  request.depth = false;
  for (const auto& [i, j] : pairs_) {
    const Body& a = *bodies_[i];
    const Body& b = *bodies_[j];
    for (std::size_t g = 0; g < a.shapes.size(); ++g) {
      for (std::size_t h = 0; h < b.shapes.size(); ++h) {
        const Eigen::Vector3d between =
            a.X_WG[g] * a.shapes[g].boundingCenter() - b.X_WG[h] * b.shapes[h].boundingCenter();
        const double reach =
            a.shapes[g].boundingRadius() + b.shapes[h].boundingRadius() + threshold + 1e-9;
        if (between.squaredNorm() > reach * reach) continue;
        const collision::DistanceResult r =
            collision::distance(a.shapes[g], a.X_WG[g], b.shapes[h], b.X_WG[h], request, scratch_);
        if (!(r.distance.lower > threshold)) return true;
      }
    }
  }
  return false;
}

double DenseWorld::startError(const std::vector<std::string>& names,
                              const std::vector<double>& row) const {
  return largestError(start_, names, row);
}

double DenseWorld::goalError(const std::vector<std::string>& names,
                             const std::vector<double>& row) const {
  return largestError(goal_, names, row);
}

}  // namespace leeway::dense
