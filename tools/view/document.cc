#include "tools/view/document.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "collision/base/numbers.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/point_cloud.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "planner/validate/checks.h"
#include "tools/view/base/json_text.h"
#include "tools/view/base/output_file.h"
#include "tools/view/base/scene_names.h"
#include "tools/view/display_mesh.h"
#include "tools/view/page_source.h"

namespace leeway::tools::view {
namespace {

using collision::Pose;
using collision::ShapeType;
using Eigen::Vector3d;

constexpr std::size_t kTriangles = 200'000;       // of all meshes of a page
constexpr std::size_t kVisualTriangles = 60'000;  // of all visual meshes
constexpr std::size_t kDrawnBalls = 50'000;       // of a cloud
constexpr std::size_t kShownPairs = 400;          // unchecked pairs that are listed by name
constexpr std::size_t kShownEdges = 10'000;       // of a search
constexpr std::string_view kEndings[] = {".html"};

float small(double x) { return static_cast<float>(x); }

/// The quaternion x y z w with w >= 0.
Eigen::Vector4d quaternionOf(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  q.normalize();
  return q.w() < 0 ? Eigen::Vector4d(-q.coeffs()) : Eigen::Vector4d(q.coeffs());
}

/// Poses as columns of numbers: seven planes of `count` numbers, x y z qx qy qz qw.
class PoseColumns {
 public:
  void add(const Pose& X) {
    const Eigen::Vector4d q = quaternionOf(X.rotation);
    for (int k = 0; k < 3; ++k) columns_[at(k)].push_back(small(X.translation[k]));
    for (int k = 0; k < 4; ++k) columns_[at(3 + k)].push_back(small(q[k]));
  }
  Json pack(Pack& pack) const {
    std::vector<float> all;
    for (const std::vector<float>& column : columns_)
      all.insert(all.end(), column.begin(), column.end());
    return pack.add(all);
  }

 private:
  std::vector<float> columns_[7];
};

/// The three numbers with which a page draws a shape: half extents, or radius and half length.
Vector3d sizesOf(const collision::Shape& shape) {
  switch (shape.type()) {
    case ShapeType::kBox:
    case ShapeType::kEllipsoid:
      return shape.halfExtents();
    case ShapeType::kSphere:
    case ShapeType::kCapsule:
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      return {shape.radius(), shape.halfLength(), 0};
    default:
      return Vector3d::Zero();
  }
}

/// The parts of bodies as columns of numbers.
class PartColumns {
 public:
  /// Adds a part of body `body` and returns its number. `mesh`: that of a hull or a mesh. `X`
  /// places the shape on the body.
  int add(int body, const collision::Shape& shape, int mesh, const Pose& X) {
    const Vector3d sizes = sizesOf(shape);
    for (int k = 0; k < 3; ++k) size_[k].push_back(small(sizes[k]));
    const bool ends = std::isfinite(shape.boundingRadius());
    return add(body, shape.type(), mesh, X, shape.boundingCenter(),
               ends ? shape.boundingRadius() : -1);
  }
  /// The same for a mesh that belongs to no shape, with a ball around it.
  int add(int body, int mesh, const Pose& X, const Vector3d& center, double radius) {
    for (std::vector<float>& column : size_) column.push_back(0);
    return add(body, ShapeType::kMesh, mesh, X, center, radius);
  }
  Json json(Pack& pack) const {
    const std::size_t by_one[] = {1};
    const auto joined = [](const auto& columns) {
      std::vector<float> all;
      for (const auto& column : columns) all.insert(all.end(), column.begin(), column.end());
      return all;
    };
    return {{"count", body_.size()},           {"body", pack.add(body_, by_one)},
            {"mesh", pack.add(mesh_, by_one)}, {"kind", pack.add(kind_)},
            {"size", pack.add(joined(size_))}, {"ball", pack.add(joined(ball_))},
            {"pose", poses_.pack(pack)},       {"names", Json::array()},
            {"pieces", Json::array()}};
  }

 private:
  int add(int body, ShapeType kind, int mesh, const Pose& X, const Vector3d& center,
          double radius) {
    const auto part = static_cast<int>(body_.size());
    body_.push_back(static_cast<std::uint32_t>(body));
    mesh_.push_back(static_cast<std::uint32_t>(mesh));
    kind_.push_back(static_cast<std::uint8_t>(kind));
    for (int k = 0; k < 3; ++k) ball_[k].push_back(small(center[k]));
    ball_[3].push_back(small(radius));
    poses_.add(X);
    return part;
  }

  std::vector<std::uint32_t> body_, mesh_;
  std::vector<std::uint8_t> kind_;
  std::vector<float> size_[3], ball_[4];
  PoseColumns poses_;
};

/// Makes the document and its arrays, which tools/view/ reads.
class Document {
 public:
  /// `pack` receives the arrays.
  Document(const Subject& subject, Pack& pack)
      : subject_(subject),
        scene_(subject.scene->scene()),
        model_(subject.scene->model()),
        pack_(pack),
        scenes_(movingScenes(subject.stages, subject.first_scene)),
        meshes_(pack_, kTriangles),
        q_(model_.variables.size()),
        X_WL_(model_.links.size()) {
    for (std::size_t b = 0; b < scene_.bodies().size(); ++b)
      if (scene_.bodies()[b].moving) moving_.push_back(static_cast<int>(b));
    // Objects with a motion of their own have the highest numbers.
    if (!subject.timeline.moments.empty())
      for (const auto& [body, X_WB] : subject.timeline.moments.front().placed)
        if (!scene_.bodies()[at(body)].moving) moving_.push_back(body);
  }

  /// `compared`: another path of the same problem; null: none. `visuals`: drawn over what is
  /// checked; null: none.
  std::string text(const Subject* compared, const robots::VisualShapes* visuals) {
    Json document = {{"format", 1},
                     {"name", subject_.problem.name},
                     {"source", subject_.source},
                     {"label", fileName(subject_.path_file)},
                     {"robot", model_.name},
                     {"verdict", subject_.verdict},
                     {"good", subject_.good},
                     {"notes", subject_.notes},
                     {"warnings", subject_.warnings}};
    addBodies(document);
    addParts(document);
    addMotion(document);
    addClearance(document);
    addJoints(document);
    addEnds(document);
    addFrames(document);
    addAxes(document);
    addSearch(document);
    addDropped(document);
    addSteps(document);
    document["triangles"] = meshes_.triangles();
    document["mesh_error"] = meshes_.largestError();
    document["visual"] = visuals == nullptr ? Json() : visualJson(*visuals);
    document["meshes"] = meshes_.document();
    document["compared"] = compared == nullptr ? Json() : Document(*compared, pack_).comparedJson();
    return pack_.text(document);
  }

 private:
  /// A page may be sent to anyone: it names files, not where they are on this machine.
  static std::string fileName(const std::string& file) {
    return std::filesystem::path(file).filename().string();
  }

  /// Motion and clearances of another path. Its world and robot are those of the page.
  Json comparedJson() {
    Json document = {{"label", fileName(subject_.path_file)},
                     {"verdict", subject_.verdict},
                     {"good", subject_.good}};
    addMotion(document);
    addClearance(document);
    return document;
  }

  void addBodies(Json& document) const {
    Json names = Json::array();
    for (const collision::Body& body : scene_.bodies()) names.push_back(body.name);
    document["bodies"] = names;
    document["moving"] = moving_;
    Json driven = Json::array();  // by a motion of their own: not parts of the robot
    for (const int b : moving_)
      if (!scene_.bodies()[at(b)].moving) driven.push_back(b);
    document["driven"] = driven;
    // The last body in tree order, whose trail is shown.
    document["tip"] = tip();
    Json held = Json::array();
    for (const planner::Attachment& a : shownProblem(subject_.problem).robot.attachments)
      if (const int body = scene_.find(a.object.name); body >= 0) held.push_back(body);
    document["held"] = held;
    Json links = Json::array();
    for (std::size_t b = 0; b < scene_.bodies().size(); ++b)
      if (model_.findLink(scene_.bodies()[b].name) >= 0) links.push_back(b);
    document["links"] = links;
    document["parents"] = parents();
    Json colors = Json::array();
    const auto addColor = [&](const planner::Object& object) {
      const int body = object.color ? scene_.find(object.name) : -1;
      if (body >= 0) colors.push_back({body, *object.color});
    };
    const planner::Problem& problem = subject_.problem;
    for (const planner::Object& object : problem.world.objects) addColor(object);
    for (const planner::DeformingObstacle& o : problem.world.deforming) addColor(o.object);
    for (const planner::Attachment& a : problem.robot.attachments) addColor(a.object);
    document["colors"] = colors;
  }

  /// The body that carries each body: of a link, the nearest link with a shape on the way to the
  /// root; of a held object, the link that holds it. -1: none.
  std::vector<int> parents() const {
    std::vector<int> all(scene_.bodies().size(), -1);
    std::vector<int> above(model_.links.size(), -1);
    for (const robots::Joint& joint : model_.joints)
      above[at(joint.child_link)] = joint.parent_link;
    const auto bodyAbove = [&](int link) {
      for (link = above[at(link)]; link >= 0; link = above[at(link)])
        if (const int body = scene_.find(model_.links[at(link)].name); body >= 0) return body;
      return -1;
    };
    for (std::size_t b = 0; b < all.size(); ++b)
      if (const int link = model_.findLink(scene_.bodies()[b].name); link >= 0)
        all[b] = bodyAbove(link);
    for (const planner::Attachment& a : shownProblem(subject_.problem).robot.attachments) {
      const int body = scene_.find(a.object.name);
      if (body < 0) continue;
      const int holder = scene_.find(model_.links[at(a.link)].name);
      all[at(body)] = holder >= 0 ? holder : bodyAbove(a.link);
    }
    return all;
  }

  int tip() const {
    int best = moving_.empty() ? -1 : moving_.front();
    for (const int b : moving_)
      if (subject_.scene->bodyLink(b) >= subject_.scene->bodyLink(best)) best = b;
    return best;
  }

  /// Adds fewer balls that cover those of a body, and a note; false if it has something else.
  bool addThinned(int body, PartColumns& parts, Json& document) {
    const collision::Body& of = scene_.bodies()[at(body)];
    planner::PointCloud cloud;
    cloud.balls.reserve(of.size());
    for (std::size_t number = 0; number < of.size(); ++number) {
      const collision::Geometry g = of.geometry(number);
      if (g.shape.type() != ShapeType::kSphere) return false;
      cloud.balls.push_back({g.X_BG.translation, g.shape.radius()});
    }
    const planner::PointCloud drawn = planner::thinnedTo(cloud, kDrawnBalls);
    for (const planner::PointCloud::Ball& ball : drawn.balls) {
      const Pose X{Eigen::Matrix3d::Identity(), ball.center};
      parts.add(body, collision::Shape::sphere(ball.radius), 0, moves(body) ? X : of.X_WB * X);
    }
    document["notes"].push_back(
        fmt::format("'{}' is drawn as {} larger balls, which contain its {}.", of.name,
                    drawn.balls.size(), of.size()));
    return true;
  }

  void addParts(Json& document) {
    PartColumns parts;
    Json names = Json::array(), pieces = Json::array();
    for (std::size_t b = 0; b < scene_.bodies().size(); ++b) {
      const collision::Body& of = scene_.bodies()[b];
      if (of.size() > kDrawnBalls && addThinned(static_cast<int>(b), parts, document)) continue;
      for (std::size_t number = 0; number < of.size(); ++number) {
        const collision::Geometry g = of.geometry(number);
        const bool has_mesh = g.shape.type() >= ShapeType::kConvexHull && !hasFrames(of);
        // A moving shape is placed in its body's frame, and a fixed one in the world.
        const int part =
            parts.add(static_cast<int>(b), g.shape, has_mesh ? meshes_.add(g.shape) : 0,
                      moves(static_cast<int>(b)) ? g.X_BG : of.X_WB * g.X_BG);
        if (!g.name.empty() && g.name != of.name) names.push_back({part, g.name});
        addPieces(g.shape, part, pieces);
      }
    }
    document["parts"] = parts.json(pack_);
    document["parts"]["names"] = names;
    document["parts"]["pieces"] = pieces;
    document["kinds"] = Json::array();
    for (int k = 0; k <= static_cast<int>(ShapeType::kDeformable); ++k)
      document["kinds"].push_back(toString(static_cast<ShapeType>(k)));
  }

  /// The visual shapes of links, with the places of these links at all moments.
  Json visualJson(const robots::VisualShapes& visuals) {
    std::size_t triangles = 0;
    for (const robots::VisualShape& visual : visuals.shapes)
      triangles += visual.mesh.triangles.size();
    PartColumns parts;
    std::vector<int> links;  // of the model, those that have visual shapes
    double error = 0;
    for (const robots::VisualShape& visual : visuals.shapes) {
      const auto known = std::find(links.begin(), links.end(), visual.link);
      const auto number = static_cast<int>(known - links.begin());
      if (known == links.end()) links.push_back(visual.link);
      if (visual.shape) {
        parts.add(number, *visual.shape, 0, visual.X_LV);
        continue;
      }
      const auto& vertices = visual.mesh.vertices;
      const auto& of = visual.mesh.triangles;
      // Larger meshes get more of the triangles, and each a hundred.
      const double share = static_cast<double>(of.size()) / static_cast<double>(triangles);
      const auto most = std::max<std::size_t>(
          100, static_cast<std::size_t>(share * static_cast<double>(kVisualTriangles)));
      const int mesh = meshes_.add(
          decimated(vertices, of, triangles <= kVisualTriangles ? of.size() : most), of.size());
      error = std::max(error, meshes_.document()[at(mesh)]["error"].get<double>());
      Vector3d low = vertices.front(), high = low;
      for (const Vector3d& v : vertices) {
        low = low.cwiseMin(v);
        high = high.cwiseMax(v);
      }
      parts.add(number, mesh, visual.X_LV, (low + high) / 2, (high - low).norm() / 2);
    }
    PoseColumns poses;  // moment by moment, then link by link
    for (const Moment& moment : subject_.timeline.moments) {
      place(moment.position, moment.placed);
      for (const int link : links) poses.add(X_WL_[at(link)]);
    }
    Json bodies = Json::array(), moving = Json::array();
    for (const int link : links) {
      bodies.push_back(scene_.find(model_.links[at(link)].name));
      moving.push_back(moving.size());
    }
    return {{"parts", parts.json(pack_)},
            {"bodies", bodies},  // of the scene; -1: the link has no checked shape
            {"moving", moving},
            {"poses", poses.pack(pack_)},
            {"error", error},
            {"left_out", visuals.left_out.size()}};
  }

  /// Adds the convex pieces that queries try first.
  void addPieces(const collision::Shape& shape, int part, Json& pieces) {
    if (shape.mesh() == nullptr) return;
    const collision::MeshTree& tree = shape.mesh()->tree();
    for (int i = 0; i < tree.pieceCount(); ++i) {
      const collision::ConvexHull& hull = tree.pieceHull(i);
      constexpr std::size_t kOfPiece = 1000;
      pieces.push_back({part, meshes_.add(decimated(hull.vertices(), hull.facets(), kOfPiece),
                                          hull.facets().size())});
    }
  }

  bool hasFrames(const collision::Body& body) const {
    const auto& frames = subject_.timeline.frames;
    return std::any_of(frames.begin(), frames.end(),
                       [&](const Frames& f) { return &scene_.bodies()[at(f.body)] == &body; });
  }

  void place(const std::vector<double>& position,
             const std::vector<std::pair<int, Pose>>& placed = {}) {
    subject_.scene->expand(position, q_);
    robots::forwardKinematics(model_, q_, X_WL_);
    placed_ = placed;
  }
  const Pose& poseOf(int body) const {
    for (const auto& [known, X_WB] : placed_)
      if (known == body) return X_WB;
    const collision::Body& b = scene_.bodies()[at(body)];
    return b.moving ? X_WL_[at(subject_.scene->bodyLink(body))] : b.X_WB;
  }

  void addMotion(Json& document) {
    Json times = Json::array();
    PoseColumns poses;  // moment by moment, then body by body
    for (const Moment& moment : subject_.timeline.moments) {
      times.push_back(moment.time);
      place(moment.position, moment.placed);
      for (const int body : moving_) poses.add(poseOf(body));
    }
    document["times"] = times;
    document["poses"] = poses.pack(pack_);
    document["waypoints"] = subject_.timeline.waypoint_times;
    Json decisions = Json::array();
    for (const auto& [time, decision] : subject_.decisions) decisions.push_back({time, decision});
    document["decisions"] = decisions;
  }

  /// Whether the page has the places of a body at all moments: bodies of the robot, what it holds,
  /// and objects with a motion of their own.
  bool moves(int body) const {
    return std::find(moving_.begin(), moving_.end(), body) != moving_.end();
  }

  /// A point in the frame of a moving body; for other bodies, in the world.
  Vector3d local(int body, const Vector3d& p_W) const {
    return moves(body) ? Vector3d(poseOf(body).inverse() * p_W) : p_W;
  }

  /// Bodies, points and both ends of the interval, with the bodies placed.
  Json nearestJson(const Nearest& near) const {
    if (near.pair.a < 0) return {};
    return {{"a", near.pair.a},
            {"b", near.pair.b},
            {"lower", jsonNumber(near.clearance.lower)},
            {"upper", jsonNumber(near.clearance.upper)},
            {"point_a", jsonVector(local(near.pair.a, near.point_a))},
            {"point_b", jsonVector(local(near.pair.b, near.point_b))},
            {"margin", near.pair.margin}};
  }

  static Json lowerEnds(const std::vector<planner::Interval>& stretches) {
    Json ends = Json::array();
    for (const planner::Interval& stretch : stretches) ends.push_back(jsonNumber(stretch.lower));
    return ends;
  }

  /// The margins of the pairs with the world or of the robot with itself, each once. Names the
  /// object or link if a margin has only one.
  Json margins(bool of_robot) const {
    std::map<double, std::set<std::string>> bodies;
    for (const auto& compiled : scenes_) {
      std::map<double, std::set<int>> numbers;
      for (const collision::ScenePair& pair : compiled->scene().pairs())
        if (compiled->isOfRobot(pair) == of_robot)
          numbers[pair.margin].insert(std::max(pair.body_a, pair.body_b));
      for (const auto& [margin, of] : numbers)
        for (const int body : of) bodies[margin].insert(compiled->scene().bodies()[at(body)].name);
    }
    constexpr std::size_t kMargins = 6;
    Json list = Json::array();
    for (const auto& [margin, of] : bodies) {
      const bool is_one = bodies.size() > 1 && of.size() == 1;
      if (list.size() < kMargins) list.push_back({margin, is_one ? *of.begin() : ""});
    }
    return list;
  }

  void addClearance(Json& document) {
    const Timeline& timeline = subject_.timeline;
    Json world = Json::array(), self = Json::array();
    for (const Moment& moment : timeline.moments) {
      place(moment.position, moment.placed);
      world.push_back(nearestJson(moment.world));
      self.push_back(nearestJson(moment.self));
    }
    document["world"] = world;
    document["self"] = self;
    document["least"] = {{"world", timeline.least_world}, {"self", timeline.least_self}};
    document["proven"] = {{"all", lowerEnds(timeline.stretches)},
                          {"world", lowerEnds(timeline.world_stretches)},
                          {"self", lowerEnds(timeline.self_stretches)}};
    document["margins"] = {{"world", margins(false)}, {"self", margins(true)}};
    document["obstacles"] = obstaclesText(subject_.problem);
    document["shown"] = subject_.shown;
    document["measured_throughout"] = subject_.measured_throughout;
    document["widest"] =
        std::holds_alternative<planner::MaximumClearance>(subject_.problem.objective);
    // Objectives other than length are refused with them.
    document["constrained"] =
        !subject_.problem.constraints.empty() || subject_.problem.condition.accept != nullptr;
    addPairs(document);
    // The clearance from the world that the objective length keeps.
    const auto* length = std::get_if<planner::MinimumLength>(&subject_.problem.objective);
    document["keep"] = length != nullptr ? jsonNumber(length->clearance) : Json();
    // In the steps of a task.
    std::size_t least_pairs = scenes_.front()->scene().pairs().size(), most_pairs = least_pairs;
    for (const auto& compiled : scenes_) {
      least_pairs = std::min(least_pairs, compiled->scene().pairs().size());
      most_pairs = std::max(most_pairs, compiled->scene().pairs().size());
    }
    document["pair_count"] = {least_pairs, most_pairs};
    std::vector<float> bodies;  // moment by moment, moving bodies only
    for (const std::vector<double>& clearance : timeline.body_clearance)
      for (const int body : moving_) bodies.push_back(small(clearance[at(body)]));
    document["body_clearance"] = pack_.add(bodies);
    std::vector<float> least;
    for (const double x : timeline.least_clearance) least.push_back(small(x));
    std::vector<std::uint32_t> when;
    for (const int m : timeline.least_moment) when.push_back(static_cast<std::uint32_t>(m + 1));
    document["least_clearance"] = pack_.add(least);
    document["least_moment"] = pack_.add(when);
  }

  /// Adds the distances of the nearest pairs, and their points as six planes.
  void addPairs(Json& document) {
    const Timeline& timeline = subject_.timeline;
    Json pairs = Json::array();
    for (const PairCurve& curve : timeline.pairs) {
      std::vector<float> distance, points(6 * curve.distance.size());
      for (const double d : curve.distance) distance.push_back(small(d));
      for (std::size_t m = 0; m < curve.distance.size(); ++m) {
        place(timeline.moments[m].position, timeline.moments[m].placed);
        const Vector3d a = local(curve.pair.a, curve.point_a[m]),
                       b = local(curve.pair.b, curve.point_b[m]);
        for (std::size_t k = 0; k < 3; ++k) {
          points[k * curve.distance.size() + m] = small(a[static_cast<Eigen::Index>(k)]);
          points[(3 + k) * curve.distance.size() + m] = small(b[static_cast<Eigen::Index>(k)]);
        }
      }
      pairs.push_back({{"a", curve.pair.a},
                       {"b", curve.pair.b},
                       {"margin", curve.pair.margin},
                       {"distance", pack_.add(distance)},
                       {"points", pack_.add(points)}});
    }
    document["pairs"] = pairs;
    document["failing"] = timeline.failing;
  }

  void addJoints(Json& document) {
    const planner::ConfigurationSpace& space = subject_.scene->space();
    Json joints = Json::array();
    for (int i = 0; i < space.size(); ++i) {
      const robots::Variable& v = model_.variables[at(space.variables()[at(i)])];
      joints.push_back({{"name", v.name},
                        {"unit", unitOf(model_, space.variables()[at(i)])},
                        {"lower", jsonNumber(space.lower(i))},
                        {"upper", jsonNumber(space.upper(i))}});
    }
    document["joints"] = joints;
    std::vector<double> values;  // moment by moment, exact
    for (const Moment& moment : subject_.timeline.moments)
      values.insert(values.end(), moment.position.begin(), moment.position.end());
    document["positions"] = pack_.add(values);
  }

  void addEnds(Json& document) {
    Json ends = Json::array();
    for (const End& end : subject_.ends) {
      PoseColumns poses, frames;
      for (const Pose& X_WF : end.frames) frames.add(X_WF);
      Json bodies = Json::array();
      if (end.unreachable()) {
        for (const auto& [body, X_WB] : end.placed) {
          bodies.push_back(body);
          poses.add(X_WB);
        }
      } else {
        place(end.position, end.placed);
        for (const int body : moving_) {
          bodies.push_back(body);
          poses.add(poseOf(body));
        }
      }
      ends.push_back({{"name", end.name},
                      {"valid", end.isValid()},
                      {"fault", end.fault},
                      {"closest", end.unreachable() ? Json()
                                                    : nearestJson({end.check.clearance, end.closest,
                                                                   end.check.closest.point_a,
                                                                   end.check.closest.point_b})},
                      {"way_out", jsonVector(end.way_out)},
                      {"bodies", bodies},
                      {"poses", poses.pack(pack_)},
                      {"frames", frames.pack(pack_)}});
    }
    document["ends"] = ends;
  }

  void addFrames(Json& document) {
    Json all = Json::array();
    for (const Frames& frames : subject_.timeline.frames) {
      std::vector<Vector3d> points;
      for (const std::vector<Vector3d>& frame : frames.positions)
        points.insert(points.end(), frame.begin(), frame.end());
      const Quantised q = quantised(points);
      const std::size_t frame = 3 * frames.positions.front().size();
      // Takes differences over time twice, because most vertices keep their velocity between
      // frames.
      const std::size_t strides[] = {frame, frame};
      std::vector<std::uint32_t> indices;
      for (const Triangle& t : scene_.bodies()[at(frames.body)]
                                   .geometries.front()
                                   .shape.deformable()
                                   ->mesh()
                                   .triangles())
        for (const std::int32_t i : t) indices.push_back(static_cast<std::uint32_t>(i));
      const std::size_t by_one[] = {1};
      PoseColumns pose;
      const collision::Body& body = scene_.bodies()[at(frames.body)];
      pose.add(body.X_WB * body.geometries.front().X_BG);
      all.push_back({{"body", frames.body},
                     {"pose", pose.pack(pack_)},
                     {"times", frames.times},
                     {"low", jsonVector(q.low)},
                     {"step", q.step},
                     {"error", quantisationError(q)},
                     {"positions", pack_.add(q.numbers, strides)},
                     {"triangles", pack_.add(indices, by_one)}});
    }
    document["frames"] = all;
  }

  /// Adds the frames of tools, and of constraints with their references, at all moments.
  void addAxes(Json& document) {
    struct Axes {
      std::string name;
      int link;  ///< -1: the world
      Pose X_LF;
    };
    const planner::Problem& problem = subject_.problem;
    std::vector<Axes> all;
    for (const planner::Frame& frame : problem.robot.frames)
      all.push_back({frame.name, frame.link, frame.X_LF});
    for (const planner::Constraint& constraint : problem.constraints) {
      const robots::PoseRegion of = planner::frameOf(problem, constraint);
      all.push_back({constraint.name + ": " + constraint.frame, of.link, of.X_LF});
      all.push_back({constraint.name + ": reference", of.base, of.X_WR});
    }
    std::vector<PoseColumns> poses(all.size());
    for (const Moment& moment : subject_.timeline.moments) {
      place(moment.position, moment.placed);
      for (std::size_t i = 0; i < all.size(); ++i)
        poses[i].add(all[i].link < 0 ? all[i].X_LF : X_WL_[at(all[i].link)] * all[i].X_LF);
    }
    Json axes = Json::array();
    for (std::size_t i = 0; i < all.size(); ++i)
      axes.push_back({{"name", all[i].name}, {"poses", poses[i].pack(pack_)}});
    document["axes"] = axes;
  }

  /// Adds the middle of each moving body at both ends of each edge, body by body. A node of a tree
  /// is the end of many edges, and is placed once. The first edges come first, so that trees stay
  /// whole.
  void addSearch(Json& document) {
    const auto& searched = subject_.searched;
    const std::size_t shown = std::min(searched.size(), kShownEdges);
    std::map<std::vector<double>, std::uint32_t> nodes;
    std::vector<const std::vector<double>*> order;
    std::vector<std::uint32_t> ends;
    for (std::size_t i = 0; i < shown; ++i)
      for (const std::vector<double>* q : {&searched[i].first, &searched[i].second}) {
        const auto [node, is_new] = nodes.emplace(*q, static_cast<std::uint32_t>(order.size()));
        if (is_new) order.push_back(&node->first);
        ends.push_back(node->second);
      }
    std::vector<Vector3d> points(moving_.size() * order.size());
    for (std::size_t n = 0; n < order.size(); ++n) {
      place(*order[n]);
      for (std::size_t m = 0; m < moving_.size(); ++m) {
        const auto& geometries = scene_.bodies()[at(moving_[m])].geometries;
        if (geometries.empty()) continue;
        const collision::Geometry& g = geometries.front();
        points[m * order.size() + n] = poseOf(moving_[m]) * (g.X_BG * g.shape.boundingCenter());
      }
    }
    const Quantised q = quantised(points);
    const std::size_t by_two[] = {2};
    document["search"] = {{"ends", pack_.add(ends, by_two)},
                          {"low", jsonVector(q.low)},
                          {"step", q.step},
                          {"of_start", pack_.add(nearerToStart(nodes, ends))},
                          {"points", pack_.add(q.numbers)}};
    document["searched"] = searched.size();
    Json blocked = Json::array();  // bodies; -1: of a step, not of the shown scene
    for (const planner::BlockedPair& pair : subject_.blocked)
      blocked.push_back({{"names", {pair.a, pair.b}},
                         {"bodies", {scene_.find(pair.a), scene_.find(pair.b)}},
                         {"edges", pair.edges}});
    document["blocked"] = blocked;
  }

  /// Returns for each node of a search whether fewer edges lead to it from the start than from the
  /// goals or the path's end.
  std::vector<std::uint8_t> nearerToStart(const std::map<std::vector<double>, std::uint32_t>& nodes,
                                          const std::vector<std::uint32_t>& ends) const {
    std::vector<std::vector<std::uint32_t>> next(nodes.size());
    for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
      next[ends[i]].push_back(ends[i + 1]);
      next[ends[i + 1]].push_back(ends[i]);
    }
    std::vector<std::uint8_t> of_start(nodes.size(), 0), reached(nodes.size(), 0);
    std::vector<std::uint32_t> queue;
    const auto begin = [&](const std::vector<double>& q, bool start) {
      const auto node = nodes.find(q);
      if (node == nodes.end() || reached[node->second] != 0) return;
      of_start[node->second] = start ? 1 : 0;
      reached[node->second] = 1;
      queue.push_back(node->second);
    };
    for (const End& end : subject_.ends) begin(end.position, &end == subject_.ends.data());
    begin(subject_.timeline.moments.back().position, false);
    for (std::size_t i = 0; i < queue.size(); ++i)
      for (const std::uint32_t node : next[queue[i]]) {
        if (reached[node] != 0) continue;
        reached[node] = 1;
        of_start[node] = of_start[queue[i]];
        queue.push_back(node);
      }
    return of_start;
  }

  void addDropped(Json& document) const {
    const auto dropped = uncheckedIn(scenes_);
    Json list = Json::array();
    for (std::size_t i = 0; i < std::min(dropped.size(), kShownPairs); ++i)
      list.push_back({dropped[i].a, dropped[i].b, dropped[i].reason});
    document["dropped"] = list;
    document["dropped_count"] = dropped.size();
  }

  /// Adds the times at which each step of a task begins and ends.
  void addSteps(Json& document) const {
    Json steps = Json::array();
    for (const Stage& stage : subject_.stages)
      if (!stage.kind.empty())
        steps.push_back({{"name", stage.name},
                         {"kind", stage.kind},
                         {"object", stage.object},
                         {"begin", subject_.timeline.waypoint_times.at(at(stage.first))},
                         {"end", subject_.timeline.waypoint_times.at(at(stage.last))}});
    document["steps"] = steps;
  }

  const Subject& subject_;
  const collision::Scene& scene_;
  const robots::Model& model_;
  Pack& pack_;
  std::vector<std::shared_ptr<const planner::CompiledScene>> scenes_;  ///< as movingScenes()
  MeshStore meshes_;
  std::vector<int> moving_;
  std::vector<double> q_;
  std::vector<Pose> X_WL_;
  std::vector<std::pair<int, Pose>> placed_;
};

}  // namespace

std::string page(const Subject& subject, const Subject* compared,
                 const robots::VisualShapes* visuals) {
  const std::string_view source = pageSource();
  const std::size_t place = source.find(kDataPlace);
  std::string html(source.substr(0, place));
  Pack pack;
  html += Document(subject, pack).text(compared, visuals);
  html += source.substr(place + kDataPlace.size());
  return html;
}

void expectPage(const std::string& file) {
  checkOutputFile(file, kEndings);
  if (pageSource().empty())
    throw robots::InputError(
        file, 0,
        "cannot be written: leeway was built without node and npm, which make the page; run "
        "`tools/setup --view`, configure and build again");
}

}  // namespace leeway::tools::view
