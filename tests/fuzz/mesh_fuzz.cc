// Any points and triangles: hulls hold their points, meshes are built or refused, and answer as
// their triangles do.

#include <cmath>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tools/truth/oracle/generate.h"
#include "tools/truth/oracle/oracle.h"

namespace {

using namespace leeway;
using Eigen::Vector3d;

void checkHull(const std::vector<Vector3d>& points) {
  std::shared_ptr<const collision::ConvexHull> hull;
  try {
    hull = collision::ConvexHull::compute(points);
  } catch (const collision::InvalidShape&) {
    if (points.empty()) return;
    Vector3d low = points[0], high = low;
    for (const Vector3d& p : points) {
      if (!(p.cwiseAbs().array() <= 1e9).all()) return;  // not finite, or more than is accepted
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    if ((high - low).maxCoeff() < 1e-9) return;
    fuzz::fail("%zu finite points refused", points.size());
  }
  if (hull->vertices().empty()) fuzz::fail("a hull without vertices");
  double largest = 0;
  for (const Vector3d& p : points) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  const collision::Shape shape = collision::Shape::convexHull(hull);
  for (const Vector3d& p : points) {
    const oracle::Truth truth = oracle::signedSeparation(shape, {}, collision::Shape::sphere(0),
                                                         {Eigen::Matrix3d::Identity(), p});
    // Coordinates below 1e-70 count as 0.
    if (truth.lower <= 1e-18 * largest + 2e-70 || !std::isfinite(truth.lower)) continue;
    std::fprintf(stderr, "hull %s of %zu points\n", oracle::replay(shape).c_str(), points.size());
    fuzz::fail("the point %.17g %.17g %.17g lies %.17g outside", p.x(), p.y(), p.z(), truth.lower);
  }
  for (const auto& facet : hull->facets())
    for (const std::int32_t v : facet)
      if (v < 0 || static_cast<std::size_t>(v) >= hull->vertices().size())
        fuzz::fail("facet with vertex %d", v);
  if (!hull->hasNeighbours()) return;
  for (std::size_t i = 0; i < hull->vertices().size(); ++i)
    for (const std::int32_t n : hull->neighbours(static_cast<std::int32_t>(i)))
      if (n < 0 || static_cast<std::size_t>(n) >= hull->vertices().size())
        fuzz::fail("neighbour %d", n);
}

}  // namespace

namespace leeway::fuzz {
std::vector<std::string> seedInputs() { return {}; }
std::vector<std::string> dictionary() { return {}; }
}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static collision::Scratch scratch;
  fuzz::ByteReader bytes({data, size});
  checkHull(fuzz::readPoints(bytes, 40));
  const auto mesh = fuzz::readMesh(bytes);
  if (!mesh) return 0;
  if (!(mesh->hullExcess() >= 0)) fuzz::fail("hull excess %.17g", mesh->hullExcess());
  const collision::Shape shape = collision::Shape::mesh(mesh);
  const collision::Pose X_MP{Eigen::Matrix3d::Identity(), bytes.vector()};
  const collision::Shape point = collision::Shape::sphere(0);
  const auto r = collision::distance(shape, {}, point, X_MP, {}, scratch);
  if (!X_MP.translation.allFinite()) return 0;
  const oracle::Truth truth = oracle::signedSeparation(shape, {}, point, X_MP);
  if (!std::isfinite(truth.lower) || !std::isfinite(truth.upper)) return 0;
  if (r.distance.lower <= truth.upper && r.distance.upper >= truth.lower) return 0;
  std::fprintf(stderr, "%s\npoint %s\n", oracle::replay(shape).c_str(),
               oracle::replay(X_MP).c_str());
  fuzz::fail("truth [%.17g, %.17g] is outside [%.17g, %.17g]", truth.lower, truth.upper,
             r.distance.lower, r.distance.upper);
}
