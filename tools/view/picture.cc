#include "tools/view/picture.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/robots/kinematics.h"
#include "tools/view/base/output_file.h"
#include "tools/view/display_mesh.h"

namespace leeway::tools::view {
namespace {

using collision::Pose;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMeshTriangles = 400;  // of a part: paper does not show more
constexpr std::size_t kObjects = 3000;       // those nearest to the robot; larger files are useless
/// The picture shows the whole world up to this multiple of the robot's motion. Beyond it, the
/// robot would be too small to see.
constexpr double kMostWorld = 5;
constexpr double kPanel = 300, kGap = 18, kHead = 52;  // [px]
constexpr int kGhosts = 5;
constexpr std::string_view kPictureEndings[] = {".svg"};

/// The axes of the world that point to the right, up, and at the reader.
struct View {
  const char *name, *across, *upward;
  Vector3d right, up, out;
};
const std::array<View, 3> kViews = {{
    {"from the front", "x", "z", Vector3d::UnitX(), Vector3d::UnitZ(), -Vector3d::UnitY()},
    {"from the right", "y", "z", Vector3d::UnitY(), Vector3d::UnitZ(), Vector3d::UnitX()},
    {"from above", "x", "y", Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()},
}};

constexpr const char* kStyle = R"(<style>
.page { fill: #ffffff } .frame { fill: #f3f4f6; stroke: #d5d8de } .world { fill: #b9b3a6 } .robot { fill: #7d9fc4 }
.start { fill: #0072b2 } .goal { fill: #d98a00 } .trail { stroke: #009e73; fill: none } .near { stroke: #c8102e; fill: none }
.trail-fill { fill: #009e73 } .near-fill { fill: #c8102e } .bar { stroke: #1c1e24; fill: none }
.ink { fill: #1c1e24 } .soft { fill: #5b606b } .outline { stroke: #1c1e24; stroke-opacity: .25; stroke-width: .5 }
text { font-family: "DejaVu Sans", "Liberation Sans", Arial, sans-serif }
@media (prefers-color-scheme: dark) {
.page { fill: #15171b } .frame { fill: #1b1e23; stroke: #3a3e47 } .world { fill: #968f80 } .start { fill: #56b4e9 }
.goal { fill: #e69f00 } .ink { fill: #eceef2 } .bar { stroke: #eceef2 } .near-fill { fill: #ff5a5f } .soft { fill: #a3a9b5 } .near { stroke: #ff5a5f } .outline { stroke: #eceef2 }
}
</style>
)";

/// The convex hull of points in the plane, counter-clockwise (A. M. Andrew, "Another efficient
/// algorithm for convex hulls in two dimensions", 1979).
std::vector<Vector2d> hullOf(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  const auto turns = [](const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  std::vector<Vector2d> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t first = hull.size();
    for (const Vector2d& p : points) {
      while (hull.size() >= first + 2 && turns(hull[hull.size() - 2], hull.back(), p) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    if (!hull.empty()) hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

struct Part {
  int body;
  DisplayMesh mesh;
  Pose X_BG;
  bool convex;
  Vector3d center;
  double radius;
};

class Picture {
 public:
  explicit Picture(const Subject& subject) : subject_(subject) {
    const collision::Scene& scene = subject.scene->scene();
    for (std::size_t b = 0; b < scene.bodies().size(); ++b)
      for (std::size_t number = 0; number < scene.bodies()[b].size(); ++number) {
        const collision::Geometry g = scene.bodies()[b].geometry(number);
        if (g.shape.type() == collision::ShapeType::kHalfSpace)
          planes_.push_back(scene.bodies()[b].X_WB * g.X_BG);
        if (!std::isfinite(g.shape.boundingRadius())) continue;
        parts_.push_back({static_cast<int>(b),
                          {},
                          g.X_BG,
                          g.shape.isConvex(),
                          g.shape.boundingCenter(),
                          g.shape.boundingRadius()});
        shapes_.push_back(g.shape);
      }
    placeAll();
    chooseParts();
  }

  std::string text(bool only_picture) {
    const double head = only_picture ? 0 : kHead;
    const double width = 3 * kPanel + 4 * kGap, height = kPanel + 2 * kGap + head + 14;
    out_ = fmt::format(
        R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0:.0f}" height="{1:.0f}" viewBox="0 0 {0:.0f} {1:.0f}">)"
        "\n",
        width, height);
    out_ += kStyle;
    out_ +=
        fmt::format("<rect class=\"page\" width=\"{:.0f}\" height=\"{:.0f}\"/>\n", width, height);
    if (!only_picture) writeHead();
    for (std::size_t v = 0; v < kViews.size(); ++v)
      writeView(kViews[v], kGap + static_cast<double>(v) * (kPanel + kGap), head + kGap);
    return out_ + "</svg>\n";
  }

 private:
  /// The poses of all bodies at one point of the space.
  template <class At>
  std::vector<Pose> place(const At& moment) const {
    const std::vector<double>& position = moment.position;
    const planner::CompiledScene& scene = *subject_.scene;
    std::vector<double> q(scene.model().variables.size());
    std::vector<Pose> X_WL(scene.model().links.size()), X_WB;
    scene.expand(position, q);
    robots::forwardKinematics(scene.model(), q, X_WL);
    const auto bodies = scene.scene().bodies();
    for (std::size_t b = 0; b < bodies.size(); ++b)
      X_WB.push_back(bodies[b].moving
                         ? X_WL[static_cast<std::size_t>(scene.bodyLink(static_cast<int>(b)))]
                         : bodies[b].X_WB);
    for (const auto& [body, X_WO] : moment.placed) X_WB[static_cast<std::size_t>(body)] = X_WO;
    return X_WB;
  }
  bool moves(const Part& part) const {
    return subject_.scene->scene().bodies()[static_cast<std::size_t>(part.body)].moving;
  }

  void placeAll() {
    const std::vector<Moment>& moments = subject_.timeline.moments;
    const bool still = moments.size() < 2, has_motion = !still || !subject_.stages.empty();
    start_ = has_motion ? place(moments.front()) : place(subject_.ends.front());
    if (has_motion) {
      goal_ = place(moments.back());
    } else if (const End* goal = shownGoal(); goal != nullptr && !goal->unreachable()) {
      goal_ = place(*goal);
    } else if (goal != nullptr && !goal->placed.empty()) {
      goal_ = start_;
      placed_ = goal->placed;
      for (const auto& [body, X_WB] : placed_) goal_[at(body)] = X_WB;
    }
    for (int g = 1; g <= kGhosts && !still; ++g)
      ghosts_.push_back(
          place(moments[moments.size() * static_cast<std::size_t>(g) / (kGhosts + 1)]));
    for (Part& part : parts_) {
      if (!moves(part)) continue;
      tip_ = &part - parts_.data();
      part.mesh = displayMesh(shapes_[static_cast<std::size_t>(tip_)], kMeshTriangles);
      for (const auto* poses : allPoses()) box_.extend(boxOf(part, *poses));
    }
    const std::size_t every = moments.size() / 200 + 1;
    for (std::size_t m = 0; m < moments.size() && tip_ >= 0 && !still; m += every) {
      const Part& part = parts_[static_cast<std::size_t>(tip_)];
      trail_.push_back(place(moments[m])[static_cast<std::size_t>(part.body)] *
                       (part.X_BG * part.center));
    }
  }
  /// If nothing moves: the goal that is not valid, else the first one; null without goals.
  const End* shownGoal() const {
    const End* goal = nullptr;
    for (const End& end : std::span(subject_.ends).subspan(1))
      if (goal == nullptr || end.name == subject_.shown) goal = &end;
    return goal;
  }
  std::vector<const std::vector<Pose>*> allPoses() const {
    std::vector<const std::vector<Pose>*> all = {&start_};
    if (!goal_.empty()) all.push_back(&goal_);
    for (const std::vector<Pose>& ghost : ghosts_) all.push_back(&ghost);
    return all;
  }
  /// The box of a part's drawn vertices, in the world.
  static Eigen::AlignedBox3d boxOf(const Part& part, const std::vector<Pose>& poses) {
    Eigen::AlignedBox3d box;
    const Pose X_WG = poses[static_cast<std::size_t>(part.body)] * part.X_BG;
    for (const Vector3d& v : part.mesh.vertices) box.extend(X_WG * v);
    return box;
  }

  /// Chooses the objects that are drawn, nearest to the robot first, and the part of the world that
  /// the views show: all of it, up to kMostWorld.
  void chooseParts() {
    if (box_.isEmpty()) box_ = {-Vector3d::Ones(), Vector3d::Ones()};
    const Vector3d center = box_.center();
    const double most = kMostWorld * std::max(box_.sizes().maxCoeff(), 1e-3);
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (moves(parts_[i])) continue;
      const Vector3d at =
          start_[static_cast<std::size_t>(parts_[i].body)] * (parts_[i].X_BG * parts_[i].center);
      near.emplace_back((at - center).norm() - parts_[i].radius, i);
    }
    std::sort(near.begin(), near.end());
    left_out_ = near.size() - std::min(near.size(), kObjects);
    near.resize(near.size() - left_out_);
    for (const auto& [apart, i] : near) {
      parts_[i].mesh = displayMesh(shapes_[i], kMeshTriangles);
      world_.push_back(i);
      const Eigen::AlignedBox3d grown = box_.merged(boxOf(parts_[i], start_));
      if (grown.sizes().maxCoeff() <= most)
        box_ = grown;
      else
        is_cut_ = true;
    }
  }

  /// A sentence about objects that the picture does not show whole; empty if there are none.
  std::string cutText() const {
    std::string text;
    if (is_cut_) text = " The world goes on beyond the picture.";
    if (left_out_ > 0)
      text += fmt::format(" The {} objects nearest to the robot are drawn, {} are not.", kObjects,
                          left_out_);
    return text;
  }

  void writeHead() {
    out_ += fmt::format(
        "<text class=\"ink\" x=\"{0:.0f}\" y=\"26\" font-size=\"17\" "
        "font-weight=\"600\">{1}</text>\n<text class=\"soft\" x=\"{0:.0f}\" y=\"46\" "
        "font-size=\"12\">{2}{3}</text>\n",
        kGap, escaped(subject_.problem.name), escaped(subject_.verdict),
        (subject_.notes.empty() ? "" : ": " + escaped(subject_.notes.front())) + cutText());
    writeLegend();
  }

  void writeView(const View& view, double x, double y) {
    const Vector3d center = box_.center();
    const double span = box_.sizes().maxCoeff();
    scale_ = kPanel / (1.06 * (span > 0 ? span : 1));
    right_ = view.right;
    up_ = view.up;
    origin_ = {x + 0.5 * kPanel - scale_ * center.dot(right_),
               y + 0.5 * kPanel + scale_ * center.dot(up_)};
    out_ += fmt::format(
        "<svg x=\"{0:.1f}\" y=\"{1:.1f}\" width=\"{2}\" height=\"{2}\" viewBox=\"{0:.1f} {1:.1f} "
        "{2} {2}\">\n<rect class=\"frame\" x=\"{0:.1f}\" y=\"{1:.1f}\" width=\"{2}\" "
        "height=\"{2}\"/>\n",
        x, y, kPanel);
    std::vector<std::size_t> order = world_;
    const auto depth = [&](std::size_t i) {
      return (start_[static_cast<std::size_t>(parts_[i].body)] *
              (parts_[i].X_BG * parts_[i].center))
          .dot(view.out);
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return depth(a) < depth(b); });
    for (const Pose& X_WP : planes_) writePlane(X_WP, view.out);
    for (const std::size_t i : order) writePart(parts_[i], start_, "world", 0.5);
    for (const std::vector<Pose>& ghost : ghosts_) writeRobot(ghost, "robot", 0.22);
    // The start is drawn over the goal, because mixed colours would look like neither.
    if (!goal_.empty()) writeRobot(goal_, "goal", 0.9);
    writeRobot(start_, "start", 0.95);
    writeTrail();
    writeNearest();
    writeScale(x, y);
    out_ += fmt::format(
        "</svg>\n<text class=\"soft\" x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"11\">{}, {} to the "
        "right, {} up</text>\n",
        x, y + kPanel + 15, view.name, view.across, view.upward);
  }
  /// Draws a half-space that is seen edge-on: everything below its plane z = 0. In other views it
  /// would cover the whole picture.
  void writePlane(const Pose& X_WP, const Vector3d& out) {
    const Vector3d normal = X_WP.rotation.col(2);
    if (std::abs(normal.dot(out)) > 1e-3) return;
    const Vector3d along = normal.cross(out).normalized() * (2 * kPanel / scale_);
    // The point of the plane below the middle of the picture.
    const Vector3d foot = box_.center() - normal * normal.dot(box_.center() - X_WP.translation);
    const Vector3d below = -normal * (2 * kPanel / scale_);
    std::string path;
    for (const Vector3d& corner :
         {Vector3d(foot - along), Vector3d(foot + along), Vector3d(foot + along + below),
          Vector3d(foot - along + below)}) {
      const Vector2d at = onPage(corner);
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? 'M' : 'L', at.x(), at.y());
    }
    out_ += fmt::format("<path class=\"world\" fill-opacity=\"0.35\" d=\"{}Z\"/>\n", path);
  }
  /// Draws a scale bar of a round length, about a fifth of the panel.
  void writeScale(double x, double y) {
    const double rough = 0.2 * kPanel / scale_, power = std::pow(10, std::floor(std::log10(rough)));
    const double length = power * (rough >= 5 * power ? 5 : rough >= 2 * power ? 2 : 1);
    const double left = x + 8, height = y + kPanel - 8;
    out_ += fmt::format(
        "<path class=\"bar\" d=\"M{0:.1f} {1:.1f}v4h{2:.1f}v-4\"/>\n<text class=\"ink\" "
        "x=\"{0:.1f}\" "
        "y=\"{3:.1f}\" font-size=\"10\">{4:g} m</text>\n",
        left, height - 4, length * scale_, height - 7, length);
  }
  /// Draws a legend of what is drawn to the right of the title.
  void writeLegend() {
    double right = 3 * kPanel + 3 * kGap;
    for (const auto& [style, words, is_drawn] :
         {std::tuple("near-fill", "nearest pair", nearest() != nullptr),
          std::tuple("trail-fill", "trail", trail_.size() > 1),
          std::tuple("robot", "on the way", !ghosts_.empty()),
          std::tuple("goal", "goal", !goal_.empty()), std::tuple("start", "start", true)}) {
      if (!is_drawn) continue;
      right -= 6.2 * static_cast<double>(std::string_view(words).size()) + 26;
      out_ += fmt::format(
          "<rect class=\"{0}\" x=\"{1:.1f}\" y=\"17\" width=\"10\" height=\"10\"/>\n<text "
          "class=\"soft\" x=\"{2:.1f}\" y=\"26\" font-size=\"11\">{3}</text>\n",
          style, right, right + 14, words);
    }
  }
  /// Whether the place of a moving body at the goal is known.
  bool isPlaced(int body) const {
    return placed_.empty() || std::any_of(placed_.begin(), placed_.end(),
                                          [&](const auto& of) { return of.first == body; });
  }
  void writeRobot(const std::vector<Pose>& poses, const char* style, double opacity) {
    out_ += fmt::format("<g opacity=\"{}\">\n", opacity);
    for (const Part& part : parts_)
      if (moves(part) && (&poses != &goal_ || isPlaced(part.body)))
        writePart(part, poses, style, 1);
    out_ += "</g>\n";
  }

  Vector2d onPage(const Vector3d& p_W) const {
    return {origin_.x() + scale_ * p_W.dot(right_), origin_.y() - scale_ * p_W.dot(up_)};
  }

  void writePart(const Part& part, const std::vector<Pose>& poses, const char* style,
                 double opacity) {
    const Pose X_WG = poses[static_cast<std::size_t>(part.body)] * part.X_BG;
    std::vector<Vector2d> points;
    for (const Vector3d& v : part.mesh.vertices) points.push_back(onPage(X_WG * v));
    if (points.empty()) return;
    std::string path;
    const auto add = [&path](std::span<const Vector2d> polygon) {
      for (std::size_t i = 0; i < polygon.size(); ++i)
        path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? 'M' : 'L', polygon[i].x(), polygon[i].y());
      path += 'Z';
    };
    if (part.convex) {
      add(hullOf(points));
    } else {
      for (const Triangle& t : part.mesh.triangles) {
        std::array<Vector2d, 3> corners = {points[static_cast<std::size_t>(t[0])],
                                           points[static_cast<std::size_t>(t[1])],
                                           points[static_cast<std::size_t>(t[2])]};
        // All triangles get the same orientation, so that together they fill the area that any of
        // them covers.
        const Vector2d u = corners[1] - corners[0], w = corners[2] - corners[0];
        if (u.x() * w.y() - u.y() * w.x() < 0) std::swap(corners[1], corners[2]);
        add(corners);
      }
    }
    out_ += fmt::format("<path class=\"{}{}\" fill-opacity=\"{}\" d=\"{}\"/>\n", style,
                        part.convex ? " outline" : "", opacity, path);
  }

  void writeTrail() {
    if (trail_.size() < 2) return;
    out_ += "<polyline class=\"trail\" stroke-width=\"1.5\" points=\"";
    for (const Vector3d& p : trail_) {
      const Vector2d at = onPage(p);
      out_ += fmt::format("{:.1f},{:.1f} ", at.x(), at.y());
    }
    out_ += "\"/>\n";
  }

  /// The nearest pair of the whole motion, or of an end that is not valid.
  const planner::StateCheck* nearest() const {
    const planner::StateCheck* found = nullptr;
    for (const Moment& m : subject_.timeline.moments)
      if (m.check.pair >= 0 &&
          (found == nullptr || m.check.clearance.upper < found->clearance.upper))
        found = &m.check;
    for (const End& end : subject_.ends)
      if (end.check.pair >= 0 && end.check.verdict != planner::Verdict::kFree) found = &end.check;
    return found;
  }
  void writeNearest() {
    const planner::StateCheck* pair = nearest();
    if (pair == nullptr) return;
    const Vector2d a = onPage(pair->closest.point_a), b = onPage(pair->closest.point_b);
    out_ += fmt::format(
        "<line class=\"near\" stroke-width=\"2\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" "
        "y2=\"{:.1f}\"/>\n<circle class=\"near\" r=\"5\" cx=\"{:.1f}\" cy=\"{:.1f}\"/>\n",
        a.x(), a.y(), b.x(), b.y(), 0.5 * (a.x() + b.x()), 0.5 * (a.y() + b.y()));
  }

  const Subject& subject_;
  std::vector<Part> parts_;
  std::vector<collision::Shape> shapes_;
  std::vector<std::size_t> world_;
  std::vector<Pose> planes_;                  ///< of half-spaces, X_WP
  std::vector<Pose> start_, goal_;            ///< no goal: empty
  std::vector<std::pair<int, Pose>> placed_;  ///< all that is known of an unreachable goal
  std::vector<std::vector<Pose>> ghosts_;
  std::vector<Vector3d> trail_;
  std::ptrdiff_t tip_ = -1;
  Eigen::AlignedBox3d box_;   ///< that the views show [m]
  bool is_cut_ = false;       ///< the world goes on beyond it
  std::size_t left_out_ = 0;  ///< objects that are not drawn
  double scale_ = 1;
  Vector2d origin_ = Vector2d::Zero();
  Vector3d right_, up_;
  std::string out_;
};

}  // namespace

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '>') {
      result += "&gt;";
    } else if (c == '"') {
      result += "&quot;";
    } else if (static_cast<unsigned char>(c) >= 0x20) {  // XML allows no other control characters
      result += c;
    }
  }
  return result;
}

void expectPicture(const std::string& file) { checkOutputFile(file, kPictureEndings); }

std::string pictureSvg(const Subject& subject, bool only_picture) {
  return Picture(subject).text(only_picture);
}

}  // namespace leeway::tools::view
