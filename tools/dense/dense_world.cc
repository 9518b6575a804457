#include "tools/dense/dense_world.h"

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

#include "tools/dense/fcl_shape.h"

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

/// Rounding of FCL's bounds, generously [m], and the most places that a pair is left out.
constexpr double kGapSlack = 1e-6, kLongestHop = 1e6;
/// That many places, or a quarter of it and so on, are tried between meshes.
constexpr int kHopBetweenMeshes = 16;

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

/// What holds a shape, in its own frame: of a mesh its vertices and FCL's hierarchy over it, of
/// anything else a box.
struct DenseWorld::Bounds {
  std::shared_ptr<const FclSurface> mesh;
  Eigen::Matrix3Xd vertices;
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), half_extents = Eigen::Vector3d::Zero();

  explicit Bounds(const FclGeometry& geometry)
      : mesh(std::dynamic_pointer_cast<const FclSurface>(geometry)) {
    if (mesh != nullptr) {
      vertices = Eigen::Map<const Eigen::Matrix3Xd>(mesh->vertices->data(), 3, mesh->num_vertices);
      return;
    }
    geometry->computeLocalAABB();
    center = geometry->aabb_local.center();
    half_extents = 0.5 * (geometry->aabb_local.max_ - geometry->aabb_local.min_);
  }
};

struct DenseWorld::Body {
  std::string name;
  int link = -1;  // -1: the world
  std::vector<Isometry3d> X_LG;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
  std::vector<Bounds> bounds;
  std::vector<Shape> shapes;
  std::vector<collision::Pose> X_WG;

  void add(const Shape& shape, const Isometry3d& X) {
    const FclGeometry geometry = toFcl(shape);
    bounds.emplace_back(geometry);
    shapes.push_back(shape);
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

bool DenseWorld::collides(const Body& x, const Body& y) const {
  const fcl::CollisionRequestd request(1, false);
  for (const auto& a : x.objects)
    for (const auto& b : y.objects) {
      if (!a->getAABB().overlap(b->getAABB())) continue;
      fcl::CollisionResultd result;
      if (fcl::collide(a.get(), b.get(), request, result) > 0) return true;
    }
  return false;
}

/// Whether the volumes of FCL's hierarchies around two meshes' triangles are `gap` apart.
bool DenseWorld::farther(const Bounds& a, const Bounds& b, const Isometry3d& X_AB, double gap) {
  const fcl::Matrix3d R = X_AB.linear();
  const fcl::Vector3d p = X_AB.translation();
  nodes_.assign(1, {0, 0});
  while (!nodes_.empty()) {
    const auto [i, j] = nodes_.back();
    nodes_.pop_back();
    const fcl::BVNode<fcl::OBBRSSd>&u = a.mesh->getBV(i), &v = b.mesh->getBV(j);
    if (fcl::distance(R, p, u.bv, v.bv) >= gap) continue;
    if (u.isLeaf() && v.isLeaf()) return false;
    if (v.isLeaf() || (!u.isLeaf() && u.bv.size() > v.bv.size())) {
      nodes_.emplace_back(u.leftChild(), j);
      nodes_.emplace_back(u.rightChild(), j);
    } else {
      nodes_.emplace_back(i, v.leftChild());
      nodes_.emplace_back(i, v.rightChild());
    }
  }
  return true;
}

/// How far a mesh's vertices all lie outside of one of a box's faces; negative when outside of
/// none.
double DenseWorld::faceGap(const Bounds& box, const Bounds& mesh, const Isometry3d& X_BM) {
  placed_vertices_.noalias() = X_BM.linear() * mesh.vertices;
  const Eigen::Vector3d p = X_BM.translation() - box.center;
  const Eigen::Vector3d lower = placed_vertices_.rowwise().minCoeff() + p;
  const Eigen::Vector3d upper = placed_vertices_.rowwise().maxCoeff() + p;
  return (lower - box.half_extents).cwiseMax(-upper - box.half_extents).maxCoeff();
}

/// For how many places to come, each bringing two bodies `step` closer at most, they are proven
/// apart: by planes of boxes' faces, and by FCL's bounds as many as `most` between meshes.
double DenseWorld::placesApart(const Body& x, const Body& y, double step, int most) {
  double places = kLongestHop;
  for (std::size_t g = 0; g < x.objects.size(); ++g)
    for (std::size_t h = 0; h < y.objects.size(); ++h) {
      const fcl::CollisionObjectd &a = *x.objects[g], &b = *y.objects[h];
      double apart = (a.getAABB().distance(b.getAABB()) - kGapSlack) / step;
      const Isometry3d X_AB = a.getTransform().inverse(Eigen::Isometry) * b.getTransform();
      const Bounds &u = x.bounds[g], &v = y.bounds[h];
      if (apart < most && u.mesh && v.mesh) {
        for (int tried = most; tried > std::max(apart, 0.0); tried /= 4)
          if (farther(u, v, X_AB, tried * step + kGapSlack)) apart = tried;
      } else if (apart < most && (u.mesh || v.mesh)) {
        const double gap =
            u.mesh ? faceGap(v, u, X_AB.inverse(Eigen::Isometry)) : faceGap(u, v, X_AB);
        apart = std::max(apart, (gap - kGapSlack) / step);
      }
      places = std::min(places, apart);
    }
  return places;
}

Collision DenseWorld::check(const std::vector<std::string>& names,
                            const std::vector<double>& positions) {
  place(names, positions);
  for (const auto& [i, j] : pairs_)
    if (collides(*bodies_[i], *bodies_[j])) return {true, bodies_[i]->name, bodies_[j]->name};
  return {};
}

/// For each pair, how far its bodies can come towards each other on the whole way: joints that
/// carry both move neither against the other; each of the rest moves a body by its turn times the
/// length of the chain between them, and a slide by itself.
std::vector<double> DenseWorld::largestSteps(const std::vector<std::string>& names,
                                             const std::vector<double>& from,
                                             const std::vector<double>& to) const {
  std::vector<double> turns(model_->joints.size(), 0);
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const robots::Joint* joint = &model_->joints[i];
    double factor = 1;
    if (joint->mimic >= 0) {
      factor = joint->multiplier;
      joint = &model_->joints[static_cast<std::size_t>(joint->mimic)];
    }
    for (std::size_t k = 0; k < names.size(); ++k)
      if (names[k] == joint->name) turns[i] = std::abs(factor * (to[k] - from[k]));
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
    double length = 0, sum = 0;
    for (std::size_t g = 0; g < body.shapes.size(); ++g)
      length = std::max(length, (body.X_LG[g] * body.shapes[g].boundingCenter()).norm() +
                                    body.shapes[g].boundingRadius());
    for (int link = body.link; link >= 0; link = parentOf(link)) {
      const robots::Joint& joint = model_->joints[static_cast<std::size_t>(link)];
      if (carries(link, other)) break;
      const double turn = turns[static_cast<std::size_t>(link)];
      const bool slides = joint.type == robots::JointType::kPrismatic;
      sum += slides ? turn : turn * length;
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
  std::vector<double> steps;
  for (const auto& [i, j] : pairs_)
    steps.push_back(moved(*bodies_[i], bodies_[j]->link) + moved(*bodies_[j], bodies_[i]->link));
  return steps;
}

std::optional<double> DenseWorld::firstCollision(const std::vector<std::string>& names,
                                                 const std::vector<double>& from,
                                                 const std::vector<double>& to, int count) {
  const std::vector<double> steps = largestSteps(names, from, to);
  due_.assign(pairs_.size(), 0);
  placed_.assign(bodies_.size(), -1);
  std::vector<double> q(from.size());
  for (int place = 0; place <= count; ++place) {
    const double t = static_cast<double>(place) / count;
    bool looked = false;
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      if (due_[p] > place) continue;
      if (!looked) {
        for (std::size_t k = 0; k < q.size(); ++k) q[k] = (1 - t) * from[k] + t * to[k];
        placeLinks(names, q);
        looked = true;
      }
      const auto& [i, j] = pairs_[p];
      for (const std::size_t b : {i, j}) {
        if (placed_[b] == place) continue;
        placed_[b] = place;
        placeObjects(*bodies_[b]);
      }
      const double places = placesApart(*bodies_[i], *bodies_[j], std::max(steps[p] / count, 1e-12),
                                        kHopBetweenMeshes);
      if (places < 0 && collides(*bodies_[i], *bodies_[j])) return t;
      due_[p] = place + 1 + static_cast<int>(std::max(places, 0.0));
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
