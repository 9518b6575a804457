#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace leeway::collision {

class MeshTree;    // private to collision/
class Shape;       // shape.h
struct BallCover;  // ball_cover.h

/// The outcome of a mesh's decomposition into convex pieces. If pieces are used, queries of bodies
/// at rest (distance, tolerance, depth) test the pieces' hulls first, and triangles only where a
/// piece's excess leaves the question open. The guarantees are the same either way.
struct PieceSummary {
  enum class Use : unsigned char {
    kUsed,
    kOpen,       ///< no component is closed: there is no inside that pieces could fill
    kSmall,      ///< too few triangles for pieces to be faster, and not all components are convex
                 ///< solids
    kConcave,    ///< too many pieces for the number of triangles to be faster
    kLaborious,  ///< finding them takes more work than allowed
    kNotAsked    ///< MeshOptions::decompose was false
  };
  Use use = Use::kSmall;
  int pieces = 0;           ///< hulls, each of four triangles or more
  int loose_triangles = 0;  ///< triangles in no piece
  double excess = 0;        ///< proven: no hull protrudes from the solid by more than this [m]
};

/// How a mesh is made of its triangles.
struct MeshOptions {
  /// Also finds convex pieces, see TriangleMesh::pieces(). This about doubles the time and makes
  /// many queries faster; the guarantees do not depend on it.
  bool decompose = true;
  /// False: a surface without an inside, even where it is closed.
  bool solid = true;
  /// Where the surface is not closed, triangles are added between vertices that are this close to
  /// each other, and between edges and vertices this close to them [m]. They are part of the mesh:
  /// it becomes larger than the given mesh, by points that are at most twice as far from it. 0:
  /// only triangles without area are added, at vertices that lie exactly on edges.
  /// A mesh is refused (InvalidShape) if facets lower than four times this have more than a
  /// hundredth of the area of an open part: welding would join corners of one facet.
  double weld = 0;
};

/// A rigid triangle mesh. Vertices that are exactly equal are joined. The volume that triangles
/// enclose is solid, whatever their orientation: this holds for each part of the mesh whose facets
/// close without a gap, even if parts share edges or facets, or if facets are given twice. Cavities
/// count as solid. All other triangles are surfaces without an inside.
class TriangleMesh {
 public:
  using Triangle = std::array<std::int32_t, 3>;

  /// `vertices` [m]. Throws InvalidShape if there are no triangles, if an index is out of range, if
  /// a coordinate is not finite or exceeds 1e9 in magnitude, or if vertices differ, but by less
  /// than 1e-9 in all coordinates. Triangles without area are kept: they are segments or points
  /// that can be touched. O(n log n), plus up to about 0.1 s for hullExcess().
  static std::shared_ptr<const TriangleMesh> make(std::span<const Eigen::Vector3d> vertices,
                                                  std::span<const Triangle> triangles,
                                                  const MeshOptions& options = {});

  std::span<const Eigen::Vector3d> vertices() const { return vertices_; }
  std::span<const Triangle> triangles() const { return triangles_; }
  int componentCount() const { return static_cast<int>(component_closed_.size()); }
  int closedComponentCount() const;
  bool isClosed(int component) const {
    return component_closed_[static_cast<std::size_t>(component)] != 0;
  }
  /// Component of triangle i.
  int component(int triangle) const {
    return triangle_component_[static_cast<std::size_t>(triangle)];
  }
  /// The number of boundary edges of parts that are neither solid nor flat. Such parts were likely
  /// meant as solids, but queries do not see their inside. 0 if MeshOptions::solid is false.
  std::size_t openEdgeCount() const { return open_edges_; }
  /// How often a crossing of triangle i counts in its component's winding number, modulo 2^61 - 1.
  /// For the engine's own use.
  std::uint64_t windingWeight(int triangle) const {
    return winding_weight_.empty() ? 1 : winding_weight_[static_cast<std::size_t>(triangle)];
  }
  /// A proven upper bound on how far the convex hull protrudes from the mesh: the largest distance
  /// of a point of the hull's facets from the mesh [m].
  double hullExcess() const { return hull_excess_; }
  /// The outcome of MeshOptions::decompose; counts and excess are 0 if pieces are not used.
  const PieceSummary& pieces() const { return pieces_; }
  const MeshTree& tree() const { return *tree_; }  ///< for the engine's own use
  std::size_t bytes() const;                       ///< of memory, hierarchies included

  ~TriangleMesh();

 private:
  friend std::shared_ptr<const BallCover> coverOf(const Shape&);
  friend struct MeshFile;  // private to the library
  TriangleMesh() = default;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> triangle_component_;
  std::vector<std::uint8_t> component_closed_;
  std::vector<std::uint64_t> winding_weight_;  // empty: 1 each
  std::size_t open_edges_ = 0;
  double hull_excess_ = 0;
  PieceSummary pieces_;
  std::unique_ptr<const MeshTree> tree_;
  // Made on first use.
  mutable std::once_flag cover_once_;
  mutable std::shared_ptr<const BallCover> cover_;
};

}  // namespace leeway::collision
