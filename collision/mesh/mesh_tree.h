#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "collision/convex/gjk/convex_view.h"
#include "collision/mesh/box_tree.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

/// A patch of a closed component's triangles and a convex hull that contains all of them. The solid
/// has a convex part K such that K lies in the hull and no point of the hull is farther than
/// `excess` from K. If a convex body is at distance d from the hull (negative: minus its depth), it
/// is therefore at least d from the patch and at most d + excess from the solid.
struct ConvexPiece {
  std::vector<std::int32_t> triangles;  ///< ascending
  std::shared_ptr<const ConvexHull> hull;
  double excess = 0;  ///< [m]
};

/// A node of MeshTree: bounds of a range of triangles.
struct MeshNode {
  Eigen::Vector3d center;     ///< of a sphere that contains the triangles [m]
  double radius;              ///< of that sphere, rounded outwards [m]
  Eigen::Vector3d low, high;  ///< their axis-aligned box; exact
  double excess;  ///< upper bound on the distance of the triangles' points outside the core's hull
                  ///< [m]
  double extent;  ///< upper bound on the distance of the core's points from the origin [m]
  std::int32_t core_begin, core_count;
  std::int32_t right;  ///< right child, the left one is the next node; -1: a leaf
  std::int32_t triangle_begin, triangle_end;  ///< slots
  std::int32_t component;                     ///< of all its triangles; -1: they belong to several

  bool isLeaf() const { return right < 0; }
};

/// The part of a MeshTree that takes time to compute; everything else follows from it and the mesh.
/// A mesh file (mesh_file.h) stores this part of the tree.
struct MeshTreePlan {
  struct Node {
    double radius = 0;        ///< as MeshNode's
    double excess = 0;        ///< as MeshNode's
    std::int32_t split = -1;  ///< the first slot of the right child; -1: a leaf
    std::int32_t core_count = 0;
  };
  std::vector<std::int32_t> order;  ///< the triangle in each slot
  std::vector<Node> nodes;          ///< in preorder; node 0 has all slots
  std::vector<std::int32_t> core;   ///< vertices of the nodes' cores, node by node
};

/// A plan in other memory, for example in a file.
struct MeshTreePlanView {
  std::span<const std::int32_t> order;
  std::span<const MeshTreePlan::Node> nodes;
  std::span<const std::int32_t> core;

  MeshTreePlanView() = default;
  MeshTreePlanView(const MeshTreePlan& plan)  // NOLINT(google-explicit-constructor)
      : order(plan.order), nodes(plan.nodes), core(plan.core) {}
};

/// Plans a tree. O(n log n). Arguments as in TriangleMesh.
MeshTreePlan planTree(std::span<const Eigen::Vector3d> vertices,
                      std::span<const std::array<std::int32_t, 3>> triangles);

/// Whether a plan from a file is valid for a mesh with these numbers of vertices and triangles: a
/// tree of limited depth over all slots, existing numbers, finite sizes. O(n).
bool isPlan(const MeshTreePlanView& plan, std::size_t vertices, std::size_t triangles);

/// A binary hierarchy over the triangles of a mesh. A node is bounded by the hull of a few of the
/// mesh's own vertices, its core, grown by a proven excess. One convex query then bounds the
/// distance of a whole nearly convex part, and queries that allow the excess need not descend
/// further. Compare convex covers and surface decompositions (S. A. Ehmann, M. C. Lin, "Accurate
/// and fast proximity queries between polyhedra using convex surface decomposition", 2001); here
/// parts need not be convex, and the excess measures their deviation. Nodes are in an array in
/// preorder: each left child follows its parent.
class MeshTree {
 public:
  using Triangle = std::array<std::int32_t, 3>;

  /// Limit on the length of a path from the root to a leaf; traversals size their stacks by it.
  static constexpr int kMaxDepth = 80;
  /// Queries test a leaf's triangles one by one.
  static constexpr std::int32_t kLeafTriangles = 2;
  /// Limit on the points of a core. A support function over this many points costs about as much as
  /// the rest of a GJK step.
  static constexpr int kCoreVertices = 32;

  /// Arguments as in TriangleMesh; a plan for which isPlan() is true; the hull of all vertices.
  /// O(n).
  MeshTree(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles,
           std::span<const std::int32_t> triangle_component, const MeshTreePlanView& plan,
           std::shared_ptr<const ConvexHull> hull);

  std::span<const MeshNode> nodes() const { return nodes_; }
  const MeshNode& node(int i) const { return nodes_[static_cast<std::size_t>(i)]; }
  ConvexView nodeView(const MeshNode& node) const {
    ConvexView view;
    view.core = Core::kPoints;
    view.points = core_.data() + node.core_begin;
    view.count = node.core_count;
    view.center = node.center;
    view.extent = node.extent;
    view.excess = node.excess;
    return view;
  }
  /// The three corners of the triangle in a slot. Slots number the triangles in the order of the
  /// leaves.
  const Eigen::Vector3d* corners(int slot) const {
    return corners_.data() + 3 * static_cast<std::size_t>(slot);
  }
  ConvexView triangleView(int slot) const {
    ConvexView view;
    view.core = Core::kPoints;
    view.points = corners(slot);
    view.count = 3;
    view.center = (view.points[0] + view.points[1] + view.points[2]) / 3;
    view.extent = extent_;
    return view;
  }
  /// The hull of all vertices, which is sufficient for many queries if the mesh is nearly convex.
  ConvexView hullView() const {
    ConvexView view;
    view.core = Core::kPoints;
    view.points = hull_->vertices().data();
    view.count = static_cast<int>(hull_->vertices().size());
    view.hull = hull_.get();
    view.support = &hull_->support();
    view.center = nodes_[0].center;
    view.extent = extent_;
    return view;
  }
  /// The triangles and convex pieces under oriented boxes, for pairs of meshes, whose coordinates
  /// are relative to middle(). Only after makeBoxes().
  const BoxTree& boxes() const { return *boxes_; }
  /// The middle of the box of all vertices.
  Eigen::Vector3d middle() const { return 0.5 * nodes_[0].low + 0.5 * nodes_[0].high; }
  /// Makes boxes() and stores the pieces. Call once, before the first query. O(n log n).
  void makeBoxes(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles,
                 std::span<const ConvexPiece> pieces);
  /// For a mesh from a file, instead of makeBoxes(): add each piece, then take the boxes (null if
  /// they do not belong to this mesh). False if these are not usable.
  void addPiece(std::shared_ptr<const ConvexHull> hull, double excess);
  bool takeBoxes(std::unique_ptr<const BoxTree> boxes);
  /// The hull that hullView() shows.
  const ConvexHull& hull() const { return *hull_; }
  /// Convex pieces (convex_pieces.h); none if they are not worthwhile.
  int pieceCount() const { return static_cast<int>(pieces_.size()); }
  const ConvexView& pieceView(int piece) const {
    return pieces_[static_cast<std::size_t>(piece)].view;
  }
  const ConvexHull& pieceHull(int piece) const {
    return *pieces_[static_cast<std::size_t>(piece)].hull;
  }
  double pieceExcess(int piece) const { return pieces_[static_cast<std::size_t>(piece)].excess; }
  struct Component {
    Eigen::Vector3d low, high;  ///< its box; exact
    Eigen::Vector3d point;      ///< one of its vertices
  };
  std::span<const Component> components() const { return components_; }
  std::int32_t triangleOf(int slot) const { return triangle_of_[static_cast<std::size_t>(slot)]; }
  std::int32_t slotOf(int triangle) const { return slot_of_[static_cast<std::size_t>(triangle)]; }
  int triangleCount() const { return static_cast<int>(triangle_of_.size()); }
  /// Upper bound on the distance of the mesh's vertices from the origin [m].
  double extent() const { return extent_; }
  std::size_t bytes() const;

 private:
  void placeTriangles(std::span<const Eigen::Vector3d> vertices,
                      std::span<const Triangle> triangles,
                      std::span<const std::int32_t> triangle_component);
  void makeNodes(const MeshTreePlanView& plan, std::span<const std::int32_t> triangle_component);
  std::vector<double> fillCores(const MeshTreePlanView& plan,
                                std::span<const Eigen::Vector3d> vertices);

  struct Piece {
    std::shared_ptr<const ConvexHull> hull;
    ConvexView view;
    double excess;
  };

  std::pmr::vector<MeshNode> nodes_{largeArrays()};
  std::vector<Piece> pieces_;
  std::pmr::vector<Eigen::Vector3d> core_{largeArrays()};
  std::pmr::vector<Eigen::Vector3d> corners_{largeArrays()};
  std::vector<std::int32_t> triangle_of_, slot_of_;
  std::vector<Component> components_;
  std::shared_ptr<const ConvexHull> hull_;
  std::unique_ptr<const BoxTree> boxes_;
  double extent_ = 0;
};

}  // namespace leeway::collision
