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

/// How the hierarchy of a deforming mesh follows its vertices. No choice changes an answer.
enum class DeformStrategy : unsigned char {
  kAuto,           ///< by the kind of motion and a written cost model; see UpdateStatistics::reason
  kRebuild,        ///< from scratch, surface area heuristic over bins (Wald 2007)
  kRebuildLinear,  ///< from scratch, along a Morton curve (Lauterbach et al. 2009)
  kRefit,          ///< one backward sweep over the array of nodes (van den Bergen 1997)
  kHybrid,         ///< upper levels bottom-up, lower ones when a query arrives there (Larsson and
                   ///< Akenine-Moller 2001)
  kLazy,           ///< a node finds its own vertices when a query arrives there (the same)
  kMorph,    ///< volumes of the references blended as the vertices are (Larsson and Akenine-Moller
             ///< 2003), of the kind DeformOptions::volume; needs a morphing motion
  kSkinned,  ///< boxes from the bones (Kavan and Zara 2005); needs a skinned motion
  kReduced,  ///< volumes, likewise, from the reduced coordinates (James and Pai 2004); needs a
             ///< reduced motion or waves
  kRestructure,  ///< refit, and subtrees that no longer fit are built anew (Larsson and
                 ///< Akenine-Moller 2006; Yoon, Curtis, Manocha 2007)
  kOctree,       ///< no tree: triangles in the overlap of two boxes, split by an implicit octree
                 ///< (Smith et al. 1995)
};

/// "auto", "rebuild", "rebuild-linear", "refit", "hybrid", "lazy", "morph", "skinned", "reduced",
/// "restructure", "octree": the word used in files and messages; and back.
const char* toString(DeformStrategy strategy);
std::optional<DeformStrategy> deformStrategy(std::string_view word);

/// The volumes that kMorph and kReduced blend. No choice changes an answer.
enum class DeformVolume : unsigned char {
  kBox,   ///< along x, y, z
  kDop,   ///< boxes cut along the six diagonals of their sides, too: 18 planes (18-DOPs)
  kBall,  ///< the least numbers, the loosest around sheets
};

/// "box", "dop", "ball": the word used in files and messages; and back.
const char* toString(DeformVolume volume);
std::optional<DeformVolume> deformVolume(std::string_view word);

/// What stays when a mesh deforms: which triangles there are. Vertices are not welded (two that
/// rest on each other may part): a component whose edges, BY INDEX, are each shared by exactly two
/// triangles of opposite direction is closed and counts as a solid at any time; the others are
/// surfaces without an inside. Triangles are turned, where need be, so that the neighbours in a
/// closed component agree.
class DeformableMesh {
 public:
  using Triangle = std::array<std::int32_t, 3>;

  /// `rest` [m]: where the first hierarchy is built. Throws InvalidShape for no triangles, an index
  /// out of range, or a coordinate that is not finite or exceeds 1e15 in magnitude. O(n log n).
  static std::shared_ptr<const DeformableMesh> make(std::span<const Eigen::Vector3d> rest,
                                                    std::span<const Triangle> triangles);

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
  /// A vertex of component c.
  int componentVertex(int component) const {
    return component_vertex_[static_cast<std::size_t>(component)];
  }

 private:
  DeformableMesh() = default;
  std::vector<Eigen::Vector3d> rest_;
  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> triangle_component_, component_vertex_;
  std::vector<std::uint8_t> component_closed_;
};

/// What an update came to.
enum class UpdateStatus : unsigned char {
  kUpdated,
  kWrongVertexCount,  ///< not one vertex for each of the mesh's
  kNotFinite,         ///< a vertex is NaN, infinite or beyond 1e15 m; `bad_vertex` tells which
  kBadTime,   ///< the time is NaN or infinite, or the speed bound or what vertices moved NaN or < 0
  kNoMotion,  ///< update(time) without a motion
};
const char* toString(UpdateStatus status);  ///< a few words for messages

/// What the last update did.
struct UpdateStatistics {
  DeformStrategy strategy = DeformStrategy::kRebuild;  ///< what was done; never kAuto
  const char* reason = "";             ///< why `auto` chose it, in a few words; else "asked for"
  std::int64_t nodes_touched = 0;      ///< whose bounds were computed
  std::int64_t vertices_touched = 0;   ///< reads of vertices for bounds, repeats included
  std::int64_t triangles_rebuilt = 0;  ///< in subtrees that were built anew
  /// Surface area of the nodes, each times its number of children, over that of the whole at the
  /// last full rebuild; 0: not measured. Grows as a hierarchy decays. No unit.
  double decay = 0;
};

struct DeformOptions {
  DeformStrategy strategy = DeformStrategy::kAuto;
  /// Of kMorph and kReduced; all others have boxes.
  DeformVolume volume = DeformVolume::kBox;
  /// Triangles in a subtree below which kHybrid leaves nodes to the queries [count]; 0: chosen. At
  /// least 0.
  int hybrid_split = 0;
  /// kRestructure builds a subtree anew when its nodes' surface area, compared with that of its own
  /// box, has grown by this factor since it was built. No unit; above 1.
  double restructure_factor = 1.6;
  /// The speed bound of a snapshot holds from its time on for this long [s]; finite, at least 0.
  double speed_horizon = 1;
  /// Queries a frame that `auto` expects [count]; at least 0.
  int expected_queries = 12;
};

/// A deforming mesh at one time: constant, and read by any number of threads while the next is
/// made.
class DeformableSnapshot {
 public:
  const DeformableMesh& mesh() const;
  std::span<const Eigen::Vector3d> vertices() const;  // [m]
  double time() const;                                // [s]
  /// No vertex moves faster than this from time() to time() + speed_horizon [m/s]; infinite when
  /// nothing is known.
  double speedBound() const;
  /// Another number for every snapshot of this process, > 0.
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

/// Owner of a deforming mesh. One thread updates; snapshots may be read by any thread, and outlive
/// the owner. Memory of a snapshot that nobody holds any more is used again, so that an update by
/// kRefit, kHybrid, kLazy, kMorph, kSkinned, kReduced or kOctree allocates nothing once as many
/// snapshots exist as are held at a time (at least two).
class Deformable {
 public:
  /// `motion` may be null (vertices are then given by the caller). The first snapshot is of the
  /// rest vertices, at time 0. Throws std::invalid_argument for a motion with another number of
  /// vertices, a strategy that the motion does not have (the message says which it has), or options
  /// out of their ranges.
  Deformable(std::shared_ptr<const DeformableMesh> mesh,
             std::shared_ptr<const VertexMotion> motion = nullptr,
             const DeformOptions& options = {});
  ~Deformable();
  Deformable(Deformable&&) noexcept;
  Deformable& operator=(Deformable&&) noexcept;

  /// To where the motion has the vertices. When anything but kUpdated is returned, the last good
  /// snapshot stays.
  UpdateStatus update(double time);
  /// To vertices given by the caller, which are checked and copied. `speed_bound` [m/s] may be
  /// infinite.
  UpdateStatus update(std::span<const Eigen::Vector3d> vertices, double time,
                      double speed_bound = std::numeric_limits<double>::infinity());

  /// The first half of update(time): fills nextVertices() from the motion and leaves the rest to
  /// commit(). kUpdated, kBadTime or kNoMotion.
  UpdateStatus evaluate(double time);

  /// update(vertices) without a copy: the vertices of the next snapshot, to be filled completely
  /// (what they hold before is undefined) and then taken by commit(). Valid until the next commit()
  /// or update().
  std::span<Eigen::Vector3d> nextVertices();
  /// What is said of vertices that were written into nextVertices().
  enum class Vertices : unsigned char {
    kUnchecked,  ///< they are checked, each of the mesh's: by the update itself where that reads
                 ///< all of them (kRefit; kHybrid of vertices of which no more is said), else in a
                 ///< pass of its own before it
    kFinite,     ///< the caller vouches for finite coordinates up to 1e15. Where that is not so the
                 ///< update is refused, or queries near those vertices answer (-inf, something):
                 ///< nothing is called free that is not
  };
  /// `moved` [m]: the caller vouches that no vertex is farther than this from where snapshot() has
  /// it, so that kHybrid (and kAuto, where it takes that) need not read all of them; what is near a
  /// query is read whatever is said. Wrong where that is not so: leave it out when in doubt. Of a
  /// motion's vertices, after evaluate(), it is known, and not asked.
  UpdateStatus commit(double time, double speed_bound = std::numeric_limits<double>::infinity(),
                      Vertices vertices = Vertices::kUnchecked,
                      double moved = std::numeric_limits<double>::infinity());

  /// The last good state; never null.
  std::shared_ptr<const DeformableSnapshot> snapshot() const;
  const UpdateStatistics& statistics() const;
  /// Of the last refused update, else -1.
  int badVertex() const;
  const std::shared_ptr<const DeformableMesh>& mesh() const;
  const std::shared_ptr<const VertexMotion>& motion() const;
  const DeformOptions& options() const;
  std::size_t bytes() const;  ///< of all hierarchies, their bounds and snapshots

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Makes room in a thread's scratch for the nodes that queries of this snapshot, and of later ones
/// of its owner, fill on demand. May allocate; O(nodes) then, O(1) when there is room. Queries
/// without it are right, but fill the same nodes again and again. Scene's Workspace does it for its
/// scene.
void prepare(Scratch& scratch, const DeformableSnapshot& snapshot);

/// The least distance between two triangles of the mesh that share no vertex; 0 or less where they
/// cross (no depth is told). (inf, inf) when there are no such triangles. Witness points in the
/// mesh's frame, triangles in triangle_a < triangle_b. Never throws or allocates.
DistanceResult selfDistance(const DeformableSnapshot& snapshot, const DistanceRequest& request,
                            Scratch& scratch, PairCache* cache = nullptr);

}  // namespace leeway::collision
