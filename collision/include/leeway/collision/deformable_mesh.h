#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

class VertexMotion;             // vertex_motion.h
struct DeformableSnapshotImpl;  // private to collision/

/// How the hierarchy of a deforming mesh follows its vertices. The choice never changes an answer.
enum class DeformStrategy : unsigned char {
  kAuto,           ///< chosen by the kind of motion and a cost model; see UpdateStatistics::reason
  kRebuild,        ///< from scratch, surface area heuristic over bins (Wald 2007)
  kRebuildLinear,  ///< from scratch, along a Morton curve (Lauterbach et al. 2009)
  kRefit,          ///< one backward sweep over the array of nodes (van den Bergen 1997)
  kHybrid,         ///< upper levels bottom-up; lower levels when a query reaches them (Larsson and
                   ///< Akenine-Moller 2001)
  kLazy,           ///< every node when a query reaches it, from the vertices below it (Larsson and
                   ///< Akenine-Moller 2001)
  kMorph,    ///< volumes of the references, blended as the vertices are (Larsson and Akenine-Moller
             ///< 2003); see DeformOptions::volume; needs a morphing motion
  kSkinned,  ///< boxes from the bones (Kavan and Zara 2005); needs a skinned motion
  kReduced,  ///< volumes from the reduced coordinates (James and Pai 2004); see
             ///< DeformOptions::volume; needs a reduced motion or waves
  kRestructure,  ///< refit; subtrees that no longer fit are rebuilt (Larsson and Akenine-Moller
                 ///< 2006; Yoon, Curtis, Manocha 2007)
  kOctree,       ///< no tree: triangles in the overlap of two boxes, split by an implicit octree
                 ///< (Smith et al. 1995)
};

/// "auto", "rebuild", "rebuild-linear", "refit", "hybrid", "lazy", "morph", "skinned", "reduced",
/// "restructure", "octree": the word used in files and messages.
const char* toString(DeformStrategy strategy);
/// The strategy with this name; nullopt for any other word.
std::optional<DeformStrategy> deformStrategy(std::string_view word);

/// The volumes that kMorph and kReduced blend. The choice never changes an answer.
enum class DeformVolume : unsigned char {
  kBox,   ///< axis-aligned
  kDop,   ///< boxes with their twelve edges cut off: 18-DOPs
  kBall,  ///< the fewest numbers, but the loosest fit around sheets
};

/// "box", "dop", "ball": the word used in files and messages.
const char* toString(DeformVolume volume);
/// The volume with this name; nullopt for any other word.
std::optional<DeformVolume> deformVolume(std::string_view word);

/// The part of a deforming mesh that stays constant: its triangles. Vertices are not welded,
/// because two vertices at one place may separate later. Solid parts are found as for TriangleMesh,
/// but BY INDEX, and for all times: a closed part stays closed. Other components are surfaces
/// without an inside.
class DeformableMesh {
 public:
  using Triangle = std::array<std::int32_t, 3>;

  /// `rest` [m]: the positions for which the first hierarchy is built. Throws InvalidShape if there
  /// are no triangles, if an index is out of range, if a coordinate is not finite or exceeds 1e9 m
  /// in magnitude, or if vertices differ, but by less than 1e-9 m in all coordinates. Vertices may
  /// come closer to each other later. `solid`: as in MeshOptions. O(n log n).
  static std::shared_ptr<const DeformableMesh> make(std::span<const Eigen::Vector3d> rest,
                                                    std::span<const Triangle> triangles,
                                                    bool solid = true);

  std::span<const Eigen::Vector3d> rest() const { return rest_; }
  std::span<const Triangle> triangles() const { return triangles_; }
  int vertexCount() const { return static_cast<int>(rest_.size()); }
  int triangleCount() const { return static_cast<int>(triangles_.size()); }
  int componentCount() const { return static_cast<int>(component_closed_.size()); }
  int closedComponentCount() const;
  bool isClosed(int component) const {
    return component_closed_[static_cast<std::size_t>(component)] != 0;
  }
  /// Component of triangle i.
  int component(int triangle) const {
    return triangle_component_[static_cast<std::size_t>(triangle)];
  }
  /// As TriangleMesh::openEdgeCount().
  std::size_t openEdgeCount() const { return open_edges_; }
  std::uint64_t windingWeight(int triangle) const {
    return winding_weight_.empty() ? 1 : winding_weight_[static_cast<std::size_t>(triangle)];
  }
  /// One vertex of a component.
  int componentVertex(int component) const {
    return component_vertex_[static_cast<std::size_t>(component)];
  }

 private:
  DeformableMesh() = default;
  std::vector<Eigen::Vector3d> rest_;
  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> triangle_component_, component_vertex_;
  std::vector<std::uint8_t> component_closed_;
  std::vector<std::uint64_t> winding_weight_;  // empty: 1 each
  std::size_t open_edges_ = 0;
};

/// The outcome of an update.
enum class UpdateStatus : unsigned char {
  kUpdated,
  kWrongVertexCount,  ///< the number of vertices differs from the mesh's
  kNotFinite,         ///< a vertex is NaN, infinite or beyond 1e9 m; see badVertex()
  kBadTime,   ///< the time is NaN or infinite, or `speed_bound` or `moved` is NaN or negative
  kNoMotion,  ///< update(time) or evaluate(time) without a motion
};
const char* toString(UpdateStatus status);  ///< a few words for messages

/// Statistics of the last update.
struct UpdateStatistics {
  DeformStrategy strategy = DeformStrategy::kRebuild;  ///< what the update did; never kAuto
  /// Why kAuto chose it, or that the first snapshot is refitted, in a few words; otherwise "asked
  /// for".
  const char* reason = "";
  std::int64_t nodes_touched = 0;      ///< nodes whose bounds were computed [count]
  std::int64_t vertices_touched = 0;   ///< reads of vertices for bounds, repeats included [count]
  std::int64_t triangles_rebuilt = 0;  ///< triangles in subtrees that were rebuilt [count]
  /// Cost of a random query by the surface area heuristic, divided by the cost after the last full
  /// rebuild. It grows as a hierarchy decays; 0 if it was not measured. No unit.
  double decay = 0;
};

struct DeformOptions {
  DeformStrategy strategy = DeformStrategy::kAuto;
  /// Used by kMorph and kReduced; all other strategies use boxes.
  DeformVolume volume = DeformVolume::kBox;
  /// kHybrid leaves subtrees of up to this many triangles to the queries [count]; at least 0. 0
  /// selects a default.
  int hybrid_split = 0;
  /// kRestructure rebuilds a subtree when the surface area of its root's children, divided by that
  /// of the box around them, has grown by this factor since the subtree was built. No unit; above
  /// 1.
  double restructure_factor = 1.6;
  /// The speed bound of a snapshot holds for this long after the snapshot's time [s]; finite, at
  /// least 0.
  double speed_horizon = 1;
  /// The number of queries between two updates that kAuto expects [count]; at least 0.
  int expected_queries = 12;
};

/// A deforming mesh at one time. Immutable: any number of threads may read it while the next
/// snapshot is made.
class DeformableSnapshot {
 public:
  const DeformableMesh& mesh() const;
  std::span<const Eigen::Vector3d> vertices() const;  // [m]
  double time() const;                                // [s]
  /// No vertex moves faster than this from time() to time() + DeformOptions::speed_horizon [m/s];
  /// infinite if no bound is known.
  double speedBound() const;
  /// Unique in this process, > 0.
  std::uint64_t id() const;
  DeformStrategy strategy() const;
  /// A box that holds the mesh, rounded outwards [m].
  const Eigen::Vector3d& low() const;
  const Eigen::Vector3d& high() const;

  const DeformableSnapshotImpl& impl() const { return *impl_; }  ///< for the engine's own queries

 private:
  friend struct DeformableSnapshotImpl;
  DeformableSnapshotImpl* impl_ = nullptr;
};

/// Owner of a deforming mesh. One thread updates it; any thread may read its snapshots, which may
/// outlive it. The memory of released snapshots is reused. Once there are as many snapshots as are
/// held at a time (at least two), updates by kRefit, kHybrid, kLazy, kMorph, kSkinned, kReduced and
/// kOctree allocate nothing.
class Deformable {
 public:
  /// `motion` may be null: the caller then provides the vertices. The first snapshot has the rest
  /// vertices, at time 0. Throws std::invalid_argument if the motion has another number of
  /// vertices, if it does not allow the strategy (the message lists those that it does), or if an
  /// option is out of range.
  Deformable(std::shared_ptr<const DeformableMesh> mesh,
             std::shared_ptr<const VertexMotion> motion = nullptr,
             const DeformOptions& options = {});
  ~Deformable();
  Deformable(Deformable&&) noexcept;
  Deformable& operator=(Deformable&&) noexcept;

  /// Moves the vertices to their positions in the motion at `time` [s]. Unless it returns kUpdated,
  /// the last good snapshot stays.
  UpdateStatus update(double time);
  /// Moves the vertices to the given positions [m], which are checked and copied. `speed_bound`
  /// [m/s] may be infinite.
  UpdateStatus update(std::span<const Eigen::Vector3d> vertices, double time,
                      double speed_bound = std::numeric_limits<double>::infinity());

  /// The first half of update(time): fills nextVertices() from the motion; commit() does the rest.
  /// Returns kUpdated, kBadTime or kNoMotion.
  UpdateStatus evaluate(double time);

  /// update(vertices) without a copy: the vertices of the next snapshot [m], undefined at first.
  /// Fill all of them, then commit(). Valid until the next commit() or update().
  std::span<Eigen::Vector3d> nextVertices();
  /// The caller's guarantees about the vertices in nextVertices().
  enum class Vertices : unsigned char {
    kUnchecked,  ///< nothing: all are checked, by the update itself if it reads all of them
                 ///< (kRefit; kHybrid without `moved`), otherwise in a separate pass
    kFinite,     ///< coordinates are finite and up to 1e9 m. If that is wrong, the update is
                 ///< refused, or queries near those vertices return a lower bound of -infinity: an
                 ///< occupied place is never reported as free
  };
  /// Makes the next snapshot from nextVertices(). `speed_bound` [m/s] may be infinite. `moved` [m]:
  /// no vertex is farther than this from its place in snapshot(). With `moved`, kHybrid (also when
  /// kAuto chooses it) reads few vertices; queries read the vertices near them. A `moved` that is
  /// too small makes answers wrong, so leave it out when in doubt. `moved` is ignored after
  /// evaluate(), because the motion provides it.
  UpdateStatus commit(double time, double speed_bound = std::numeric_limits<double>::infinity(),
                      Vertices vertices = Vertices::kUnchecked,
                      double moved = std::numeric_limits<double>::infinity());

  /// The last good state; never null.
  std::shared_ptr<const DeformableSnapshot> snapshot() const;
  const UpdateStatistics& statistics() const;
  /// The first bad vertex of the last update, if that returned kNotFinite; else -1.
  int badVertex() const;
  const std::shared_ptr<const DeformableMesh>& mesh() const;
  const std::shared_ptr<const VertexMotion>& motion() const;
  const DeformOptions& options() const;
  std::size_t bytes() const;  ///< memory of all hierarchies, their bounds and snapshots

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Makes room in a thread's scratch for the nodes that queries of this snapshot and of later ones
/// of its owner find on demand. May allocate: O(nodes); O(1) when there is room. Queries without it
/// are correct, but compute the same nodes repeatedly. A Workspace calls it for its scene.
void prepare(Scratch& scratch, const DeformableSnapshot& snapshot);

/// The least distance between two triangles of the mesh that share no vertex [m]; at most 0 where
/// they cross (the depth is not found). (inf, inf) if the mesh has no such triangles. Witness
/// points are in the mesh's frame; triangle_a < triangle_b. Never throws or allocates.
DistanceResult selfDistance(const DeformableSnapshot& snapshot, const DistanceRequest& request,
                            Scratch& scratch, PairCache* cache = nullptr);

}  // namespace leeway::collision
