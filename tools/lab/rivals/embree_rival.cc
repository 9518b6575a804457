// Embree 3: dynamic scenes in single precision, refitted or rebuilt, with point queries.

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>

#include "tools/lab/base/rivals.h"

namespace leeway::tools::report {
namespace {

struct Point {
  float x, y, z;
};
Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Point operator*(float s, const Point& a) { return {s * a.x, s * a.y, s * a.z}; }
float dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// Squared distance from p to the triangle, by the Voronoi region that p lies in (Ericson,
/// Real-Time Collision Detection, section 5.1.5).
float squaredDistance(const Point& p, const Point& a, const Point& b, const Point& c) {
  const auto to = [&](const Point& q) { return dot(p - q, p - q); };
  const Point ab = b - a, ac = c - a, ap = p - a;
  const float d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return to(a);
  const Point bp = p - b;
  const float d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return to(b);
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return to(a + (d1 / (d1 - d3)) * ab);
  const Point cp = p - c;
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return to(c);
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return to(a + (d2 / (d2 - d6)) * ac);
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return to(b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b));
  const float scale = 1 / (va + vb + vc);
  return to(a + (vb * scale) * ab + (vc * scale) * ac);
}

/// One single-threaded device for all scenes.
RTCDevice device() {
  static const RTCDevice instance = rtcNewDevice("threads=1,set_affinity=0");
  return instance;
}

class EmbreeFollower final : public MeshFollower {
 public:
  EmbreeFollower(const DeformingSpec& spec, RTCBuildQuality quality)
      : scene_(rtcNewScene(device())) {
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_DYNAMIC);
    // Only a low-quality scene keeps a hierarchy for each geometry, which a refit needs. The
    // geometry is first built at full quality.
    const bool refit = quality == RTC_BUILD_QUALITY_REFIT;
    rtcSetSceneBuildQuality(scene_, refit ? RTC_BUILD_QUALITY_LOW : quality);
    geometry_ = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    vertices_ = static_cast<Point*>(rtcSetNewGeometryBuffer(
        geometry_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Point), spec.rest.size()));
    triangles_ = static_cast<Triangle*>(rtcSetNewGeometryBuffer(geometry_, RTC_BUFFER_TYPE_INDEX, 0,
                                                                RTC_FORMAT_UINT3, sizeof(Triangle),
                                                                spec.triangles.size()));
    for (std::size_t i = 0; i < spec.triangles.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        triangles_[i].corner[k] = static_cast<unsigned>(spec.triangles[i][k]);
    setVertices(spec.rest, 0);
    rtcSetGeometryBuildQuality(geometry_, refit ? RTC_BUILD_QUALITY_MEDIUM : quality);
    rtcCommitGeometry(geometry_);
    rtcAttachGeometry(scene_, geometry_);
    rtcCommitScene(scene_);
    rtcSetGeometryBuildQuality(geometry_, quality);
    rtcCommitGeometry(geometry_);
    rtcCommitScene(scene_);
  }
  ~EmbreeFollower() override {
    rtcReleaseGeometry(geometry_);
    rtcReleaseScene(scene_);
  }
  EmbreeFollower(const EmbreeFollower&) = delete;
  EmbreeFollower& operator=(const EmbreeFollower&) = delete;

  void setVertices(std::span<const Eigen::Vector3d> vertices, double) override {
    for (std::size_t i = 0; i < vertices.size(); ++i) vertices_[i] = toPoint(vertices[i]);
  }

  void update() override {
    rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry_);
    rtcCommitScene(scene_);
  }

  /// Embree has only point queries, so only spheres are supported.
  bool addBody(const collision::Shape& shape) override {
    if (shape.type() != collision::ShapeType::kSphere) return false;
    radii_.push_back(shape.radius());
    return true;
  }

  double distance(int body, const collision::Pose& X_WB) override {
    RTCPointQuery query{};
    const Point center = toPoint(X_WB.translation);
    query.x = center.x, query.y = center.y, query.z = center.z;
    query.radius = std::numeric_limits<float>::infinity();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    Nearest nearest{this, std::numeric_limits<float>::infinity()};
    rtcPointQuery(scene_, &query, &context, visit, &nearest);
    return std::sqrt(static_cast<double>(nearest.squared)) - radii_[static_cast<std::size_t>(body)];
  }

 private:
  struct Triangle {
    unsigned corner[3];
  };
  struct Nearest {
    const EmbreeFollower* self;
    float squared;
  };

  static Point toPoint(const Eigen::Vector3d& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
  }

  static bool visit(RTCPointQueryFunctionArguments* arguments) {
    Nearest& nearest = *static_cast<Nearest*>(arguments->userPtr);
    const EmbreeFollower& self = *nearest.self;
    const unsigned* corner = self.triangles_[arguments->primID].corner;
    const RTCPointQuery& q = *arguments->query;
    const float squared = squaredDistance({q.x, q.y, q.z}, self.vertices_[corner[0]],
                                          self.vertices_[corner[1]], self.vertices_[corner[2]]);
    if (!(squared < nearest.squared)) return false;
    nearest.squared = squared;
    arguments->query->radius = std::sqrt(squared);
    return true;
  }

  RTCScene scene_;
  RTCGeometry geometry_ = nullptr;
  Point* vertices_ = nullptr;
  Triangle* triangles_ = nullptr;
  std::vector<double> radii_;
};

class EmbreeEngine : public MeshEngine {
 public:
  EmbreeEngine(const char* name, RTCBuildQuality quality) : name_(name), quality_(quality) {}
  const char* name() const override { return name_; }
  std::unique_ptr<MeshFollower> follow(const DeformingSpec& spec) const override {
    return std::make_unique<EmbreeFollower>(spec, quality_);
  }
  double tolerance() const override { return 1e-5; }

 private:
  const char* name_;
  RTCBuildQuality quality_;
};

}  // namespace
}  // namespace leeway::tools::report

extern "C" leeway::tools::report::Rivals* leewayMakeRivals5() {
  using namespace leeway::tools::report;
  auto rivals = std::make_unique<Rivals>();
  const auto add = [&](const char* name, RTCBuildQuality quality) {
    rivals->meshes.push_back(std::make_unique<EmbreeEngine>(name, quality));
  };
  add("Embree refit", RTC_BUILD_QUALITY_REFIT);
  add("Embree rebuild low", RTC_BUILD_QUALITY_LOW);
  add("Embree rebuild medium", RTC_BUILD_QUALITY_MEDIUM);
  return rivals.release();
}
