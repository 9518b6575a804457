#include "tools/lab/dense/dense_body.h"

#include <fcl/fcl.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "tools/lab/dense/joint_motion.h"

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

DenseWorld::DenseWorld(std::shared_ptr<const robots::Model> model, Named start)
    : model_(std::move(model)), start_(std::move(start)), X_WL_(model_->links.size()) {
  addRobot();
}

DenseWorld::~DenseWorld() = default;

struct DenseWorld::Points {
  std::shared_ptr<FclSurface> surface;
};

std::shared_ptr<const DenseWorld::Points> DenseWorld::pointsOf(
    const std::vector<Eigen::Vector3d>& points_W) {
  constexpr double kSize = 1e-5;
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const Eigen::Vector3d& p : points_W) {
    const auto first = static_cast<std::int32_t>(vertices.size());
    vertices.insert(vertices.end(), {p, p + kSize * Eigen::Vector3d::UnitX(),
                                     p + kSize * Eigen::Vector3d::UnitY()});
    triangles.push_back({first, first + 1, first + 2});
  }
  return std::make_shared<const Points>(Points{lab::fclMesh(vertices, triangles)});
}

std::pair<double, std::string> DenseWorld::leastDistance(const Points& points,
                                                         const std::vector<std::string>& names,
                                                         const std::vector<double>& positions) {
  place(names, positions);
  std::pair<double, std::string> least{std::numeric_limits<double>::infinity(), {}};
  for (const auto& body : bodies_) {
    for (std::size_t g = 0; g < body->geometries.size(); ++g) {
      fcl::DistanceResultd result;
      const double distance = fcl::distance(
          body->geometries[g].get(), body->objects[g]->getTransform(), points.surface.get(),
          Isometry3d::Identity(), fcl::DistanceRequestd(), result);
      if (!(distance >= least.first)) least = {distance, body->name};
    }
  }
  return least;
}

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
  const auto names = matrix && matrix["entry_names"]
                         ? matrix["entry_names"].as<std::vector<std::string>>()
                         : std::vector<std::string>();
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (matrix["entry_values"][i][j].as<bool>()) allowed_.emplace_back(names[i], names[j]);
  // Pairs of links that the matrix does not contain are those of the SRDF.
  const auto has = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const robots::DisabledPair& pair : model_->disabled_pairs) {
    const std::string& a = model_->links[static_cast<std::size_t>(pair.link_a)].name;
    const std::string& b = model_->links[static_cast<std::size_t>(pair.link_b)].name;
    if (!has(a) || !has(b)) allowed_.emplace_back(a, b);
  }
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
  // The link that rigidly carries each link, because bodies of one carrier never move relative to
  // one another.
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
    // In MotionBenchMaker, a base that floats by the SRDF is at the origin.
    const bool is_base = joint.parent_link < 0 && joint.variable_count > 1;
    if (!is_base) X = X * jointMotion(joint, q);
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

/// Whether two shapes collide at their current poses.
bool DenseWorld::collide(const ShapePair& pair) const {
  const auto& [i, j] = pairs_[pair.bodies];
  const fcl::CollisionObjectd &a = *bodies_[i]->objects[pair.a], &b = *bodies_[j]->objects[pair.b];
  if (!a.getAABB().overlap(b.getAABB())) return false;
  fcl::CollisionResultd result;
  return fcl::collide(&a, &b, fcl::CollisionRequestd(1, false), result) > 0;
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
