#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/deform/motion/key_track.h"
#include "collision/deform/motion/motion_input.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

constexpr MotionKind kLatticeKind = MotionKind::kLattice;
constexpr int kLargestDegree = 16;

// The Bernstein polynomials of `degree` at u in [0, 1], to out[0 ... degree]: de Casteljau's
// triangle of convex combinations, in which nothing cancels. An error e of u changes the values by
// at most 2 degree e in total; every row adds four units.
void bernstein(int degree, double u, double* out) {
  const double v = 1 - u;
  out[0] = 1;
  for (int row = 1; row <= degree; ++row) {
    out[row] = u * out[row - 1];
    for (int i = row - 1; i > 0; --i) out[i] = v * out[i] + u * out[i - 1];
    out[0] = v * out[0];
  }
}

// The parameters are the coordinates of the control points.
class LatticeVertices final : public VertexMotion {
 public:
  LatticeVertices(const LatticeMotion& motion, KeyTrack track)
      : VertexMotion(kLatticeKind, static_cast<int>(motion.rest.size()),
                     static_cast<int>(3 * motion.keys[0].control_points.size()),
                     {track.times().begin(), track.times().end()}),
        cells_{motion.cells[0], motion.cells[1], motion.cells[2]},
        track_(std::move(track)) {
    for (const LatticeMotion::Key& key : motion.keys) {
      std::vector<double> row;
      row.reserve(3 * key.control_points.size());
      for (const Vector3d& p : key.control_points) row.insert(row.end(), {p.x(), p.y(), p.z()});
      size_ = std::max(size_, largestCoordinate(key.control_points));
      controls_.push_back(std::move(row));
    }
    weighVertices(motion);
    measureSegments();
  }

  void parameters(double time, std::span<double> out) const override {
    track_.blend(controls_, time, out);
  }

  void vertices(std::span<const double> parameters, int first,
                std::span<Vector3d> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = blended(parameters, static_cast<std::size_t>(first) + i);
  }

  double speedBound(double t0, double t1) const override { return track_.largest(speeds_, t0, t1); }

  double accelerationBound(double t0, double t1) const override {
    if (track_.jumps(t0, t1)) return std::numeric_limits<double>::infinity();
    return track_.largest(accelerations_, t0, t1);
  }

  double rounding(double t0, double t1) const override {
    if (!(t0 <= t1)) return std::numeric_limits<double>::infinity();
    return roundedUp(2 * (blendError() + 2 * kShareRounding + 8) * kUnitRoundoff * size_, 8);
  }

 private:
  // A bound on the error of a coordinate of blended(), in units of kUnitRoundoff times the largest
  // control coordinate. An axis adds 2 degree times the 4 units of its u, 4 units for each row of
  // the triangle, and one for each product and sum.
  double blendError() const { return 16.0 * (cells_[0] + cells_[1] + cells_[2]) + 32; }

  void weighVertices(const LatticeMotion& motion) {
    stride_ = 3;
    for (const int cells : cells_) stride_ += static_cast<std::size_t>(cells);
    weights_.resize(stride_ * motion.rest.size());
    for (std::size_t v = 0; v < motion.rest.size(); ++v) {
      double* out = weights_.data() + stride_ * v;
      for (int axis = 0; axis < 3; ++axis) {
        const double low = motion.box_lower[axis], high = motion.box_upper[axis];
        bernstein(cells_[static_cast<std::size_t>(axis)],
                  std::clamp((motion.rest[v][axis] - low) / (high - low), 0.0, 1.0), out);
        out += cells_[static_cast<std::size_t>(axis)] + 1;
      }
    }
  }

  Vector3d blended(std::span<const double> control, std::size_t vertex) const {
    const double* bx = weights_.data() + stride_ * vertex;
    const double* by = bx + cells_[0] + 1;
    const double* bz = by + cells_[1] + 1;
    const double* p = control.data();
    double sum[3] = {0, 0, 0};
    for (int z = 0; z <= cells_[2]; ++z) {
      double plane[3] = {0, 0, 0};
      for (int y = 0; y <= cells_[1]; ++y) {
        double row[3] = {0, 0, 0};
        for (int x = 0; x <= cells_[0]; ++x, p += 3) {
          for (int k = 0; k < 3; ++k) row[k] += bx[x] * p[k];
        }
        for (int k = 0; k < 3; ++k) plane[k] += by[y] * row[k];
      }
      for (int k = 0; k < 3; ++k) sum[k] += bz[z] * plane[k];
    }
    return {sum[0], sum[1], sum[2]};
  }

  // Within a segment, control points move along straight lines, and so do vertices.
  void measureSegments() {
    std::vector<double> difference(controls_[0].size());
    for (std::size_t i = 0; i < track_.segments(); ++i) {
      double largest = 0;
      for (std::size_t k = 0; k < difference.size(); ++k) {
        difference[k] = controls_[i + 1][k] - controls_[i][k];
        largest = std::max(largest, std::abs(difference[k]));
      }
      double longest_squared = 0;
      for (std::size_t v = 0; v < static_cast<std::size_t>(vertexCount()); ++v)
        longest_squared = std::max(longest_squared, squaredLength(blended(difference, v)));
      const double moved =
          std::sqrt(longest_squared) + 2 * (blendError() + 2) * kUnitRoundoff * largest;
      speeds_.push_back(roundedUp(moved * track_.rate(i), 16));
      accelerations_.push_back(roundedUp(moved * track_.rateChange(i), 16));
    }
  }

  std::array<int, 3> cells_;
  KeyTrack track_;
  std::vector<std::vector<double>> controls_;  // one row a key
  double size_ = 0;                            // largest |coordinate| of a control point [m]
  std::size_t stride_ = 0;
  std::vector<double> weights_;                 // vertex by vertex: along x, y, z
  std::vector<double> speeds_, accelerations_;  // one for each segment
};

void requireBox(const LatticeMotion& motion) {
  for (int k = 0; k < 3; ++k) {
    requireUsable(kLatticeKind, "box lower corner", motion.box_lower[k]);
    requireUsable(kLatticeKind, "box upper corner", motion.box_upper[k]);
    if (!(motion.box_lower[k] < motion.box_upper[k])) {
      refuse(kLatticeKind, "box from " + shown(motion.box_lower[k]) + " to " +
                               shown(motion.box_upper[k]) + " along axis " + std::to_string(k) +
                               "; the upper end must be larger");
    }
    if (motion.cells[k] < 1 || motion.cells[k] > kLargestDegree) {
      refuse(kLatticeKind, std::to_string(motion.cells[k]) + " cells along axis " +
                               std::to_string(k) + "; 1 to " + std::to_string(kLargestDegree) +
                               " are accepted");
    }
  }
  for (std::size_t v = 0; v < motion.rest.size(); ++v) {
    const Vector3d& r = motion.rest[v];
    if ((r.array() >= motion.box_lower.array()).all() &&
        (r.array() <= motion.box_upper.array()).all())
      continue;
    refuse(kLatticeKind, "rest vertex " + std::to_string(v) + " at " + shown(r.x()) + " " +
                             shown(r.y()) + " " + shown(r.z()) +
                             " is outside the box; vertices must be within it");
  }
}

}  // namespace

std::shared_ptr<const VertexMotion> VertexMotion::lattice(LatticeMotion motion) {
  requireVertices(kLatticeKind, motion.rest.size());
  requireUsable(kLatticeKind, "rest vertex", motion.rest);
  requireBox(motion);
  std::vector<double> times = timesOf(motion.keys);
  requireKeys(kLatticeKind, times);
  std::size_t wanted = 1;
  for (const int cells : motion.cells) wanted *= static_cast<std::size_t>(cells + 1);
  for (std::size_t i = 0; i < motion.keys.size(); ++i) {
    const std::string name = "key " + std::to_string(i);
    requireCount(kLatticeKind, name, motion.keys[i].control_points.size(), wanted,
                 "control points");
    requireUsable(kLatticeKind, name + ", control point", motion.keys[i].control_points);
  }
  return withSource(
      std::make_shared<LatticeVertices>(motion, KeyTrack(std::move(times), motion.interpolation)),
      motion);
}

}  // namespace leeway::collision
