#include "collision/mesh/topology/components.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "collision/base/numbers.h"
#include "collision/mesh/topology/cycles.h"
#include "collision/mesh/topology/union_find.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;

// A surface that departs from a plane by less than this share of its size is flat: a sheet, not a
// solid.
constexpr double kFlatShare = 1e-6;
// A triangle with less height than this share of an edge's length is a line.
constexpr double kLine = 1e-12;

bool collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

class Components {
 public:
  Components(std::span<const Vector3d> vertices, std::vector<Triangle>& triangles, double thickness)
      : vertices_(vertices),
        triangles_(triangles),
        thickness_(thickness),
        edges_(sortedEdges(triangles, vertices.size())),
        sets_(triangles.size()) {
    findRepeated();
    connect();
    orient();
    findCycle();
    number();
    turn();
    joinOthers();
    weigh();
    findOpenEdges();
  }

  MeshComponents take() && { return std::move(result_); }

 private:
  struct Link {
    std::int32_t triangle;
    bool same_direction;  // both triangles run along the edge in this direction, so one of them
                          // must be flipped
  };
  // The triangles across the edges that a triangle shares with exactly one other.
  struct Links {
    std::array<Link, 3> link;
    std::size_t count = 0;
    void add(const Link& l) { link[count++] = l; }
    std::span<const Link> all() const { return {link.data(), count}; }
  };

  const Vector3d& corner(std::int32_t t, std::size_t k) const {
    return vertices_[at(triangles_[at(t)][k])];
  }
  bool counts(std::int32_t t) const { return twin_[at(t)] < 0; }

  // Calls visit(uses) for each edge with its triangles, without repeated and collapsed ones.
  template <class Visit>
  void forEachEdge(const Visit& visit) const {
    std::vector<EdgeUse> left;
    for (std::size_t i = 0, end = 0; i < edges_.size(); i = end) {
      bool all = true;
      for (end = i; end < edges_.size() && edges_[end].low == edges_[i].low &&
                    edges_[end].high == edges_[i].high;
           ++end)
        all = all && counts(edges_[end].triangle);
      std::span<const EdgeUse> uses(edges_.data() + i, end - i);
      if (!all) {
        left.clear();
        for (const EdgeUse& e : uses)
          if (counts(e.triangle)) left.push_back(e);
        uses = left;
      }
      if (!uses.empty()) visit(uses);
    }
  }

  std::int32_t across(const EdgeUse& e) const {
    return triangles_[at(e.triangle)][at((e.side + 2) % 3)];
  }

  void findRepeated() {
    twin_.assign(triangles_.size(), -1);
    std::map<std::int32_t, std::int32_t> first;  // by the corner across the edge
    forEachEdge([&](std::span<const EdgeUse> uses) {
      if (uses.size() == 2 && across(uses[0]) != across(uses[1])) return;
      if (uses.size() < 2) return;
      first.clear();
      for (const EdgeUse& e : uses) {
        const auto [kept, is_new] = first.emplace(across(e), e.triangle);
        if (!is_new && counts(e.triangle)) twin_[at(e.triangle)] = kept->second;
      }
    });
  }

  void connect() {
    links_.resize(triangles_.size());
    forEachEdge([&](std::span<const EdgeUse> uses) {
      if (uses.size() != 2) return;
      sets_.unite(uses[0].triangle, uses[1].triangle);
      const bool same = uses[0].forward == uses[1].forward;
      links_[at(uses[0].triangle)].add({uses[1].triangle, same});
      links_[at(uses[1].triangle)].add({uses[0].triangle, same});
    });
    patch_.assign(triangles_.size(), -1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (collapsed(triangles_[i]) || twin_[i] >= 0) continue;
      const std::size_t r = at(sets_.find(static_cast<std::int32_t>(i)));
      if (r == i) patch_[i] = patches_++;  // its lowest triangle
      patch_[i] = patch_[r];
    }
  }

  // Flood fill: finds the triangles that must be flipped so that those of a patch agree.
  void orient() {
    turned_.assign(triangles_.size(), -1);
    is_surface_.assign(at(patches_), 0);
    std::vector<std::int32_t> queue;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (patch_[i] < 0 || turned_[i] >= 0) continue;
      turned_[i] = 0;
      queue.assign(1, static_cast<std::int32_t>(i));
      for (std::size_t k = 0; k < queue.size(); ++k) {
        for (const Link& link : links_[at(queue[k])].all()) {
          const auto wanted =
              static_cast<signed char>(turned_[at(queue[k])] ^ (link.same_direction ? 1 : 0));
          signed char& other = turned_[at(link.triangle)];
          if (other >= 0) {
            if (other != wanted) is_surface_[at(patch_[i])] = 1;
            continue;
          }
          other = wanted;
          queue.push_back(link.triangle);
        }
      }
    }
  }

  void findCycle() {
    std::vector<BorderEquation> equations;
    BorderEquation border;
    forEachEdge([&](std::span<const EdgeUse> uses) {
      if (uses.size() == 2) return;
      border.clear();
      for (const EdgeUse& e : uses)
        border.push_back(
            {patch_[at(e.triangle)], e.forward == (turned_[at(e.triangle)] == 0) ? 1 : -1});
      std::sort(border.begin(), border.end(),
                [](const BorderTerm& a, const BorderTerm& b) { return a.patch < b.patch; });
      std::size_t kept = 0;
      for (std::size_t i = 0, end = 0; i < border.size(); i = end) {
        BorderTerm all{border[i].patch, 0};
        for (end = i; end < border.size() && border[end].patch == all.patch; ++end)
          all.times += border[end].times;
        if (all.times != 0) border[kept++] = all;
      }
      border.resize(kept);
      if (border.size() == 1) is_surface_[at(border[0].patch)] = 1;
      if (border.size() < 2) return;
      if (border[0].times < 0)  // equal equations have equal signs
        for (BorderTerm& term : border) term.times = -term.times;
      equations.push_back(border);
    });
    for (std::int32_t p = 0; p < patches_; ++p)
      if (is_surface_[at(p)] != 0) equations.push_back({{p, 1}});
    // Short equations first, because they settle the most.
    const auto key = [](const BorderEquation& e) { return e.size(); };
    const auto less = [&](const BorderEquation& a, const BorderEquation& b) {
      if (key(a) != key(b)) return key(a) < key(b);
      return std::lexicographical_compare(
          a.begin(), a.end(), b.begin(), b.end(), [](const BorderTerm& l, const BorderTerm& r) {
            return l.patch != r.patch ? l.patch < r.patch : l.times < r.times;
          });
    };
    std::sort(equations.begin(), equations.end(), less);
    equations.erase(std::unique(equations.begin(), equations.end(),
                                [&](const auto& a, const auto& b) { return !less(a, b); }),
                    equations.end());
    cycle_ = largestCycle(at(patches_), equations);
  }

  bool isSolid(std::int32_t t) const {
    return patch_[at(t)] >= 0 && cycle_.weight[at(patch_[at(t)])] != 0;
  }

  // A cluster of the cycle is a component; surfaces form components by edge connection.
  void number() {
    std::vector<std::int32_t> first_of_cluster(at(patches_), -1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const auto t = static_cast<std::int32_t>(i);
      if (!isSolid(t)) continue;
      std::int32_t& first = first_of_cluster[at(cycle_.cluster[at(patch_[i])])];
      if (first < 0) first = t;
      sets_.unite(first, t);
    }
    forEachEdge([&](std::span<const EdgeUse> uses) {
      std::int32_t before = -1;
      for (const EdgeUse& e : uses) {
        if (isSolid(e.triangle)) continue;
        if (before >= 0) sets_.unite(before, e.triangle);
        before = e.triangle;
      }
    });
    result_.component.assign(triangles_.size(), -1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (twin_[i] >= 0) continue;
      const std::size_t r = at(sets_.find(static_cast<std::int32_t>(i)));
      if (r == i) {
        result_.component[i] = static_cast<std::int32_t>(result_.closed.size());
        result_.closed.push_back(isSolid(static_cast<std::int32_t>(i)) ? 1 : 0);
      }
      result_.component[i] = result_.component[r];
    }
  }

  // Turns the triangles of solids outwards, and sets their weights accordingly.
  void turn() {
    const std::size_t count = result_.closed.size();
    std::vector<std::uint8_t> is_unit(count, 1);  // of components: all weights are 1 or -1
    std::vector<Vector3d> middle(count, Vector3d::Zero());
    std::vector<double> size(count, 0);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const auto t = static_cast<std::int32_t>(i);
      if (!isSolid(t)) continue;
      const std::size_t c = at(result_.component[i]);
      const std::uint64_t w = cycle_.weight[at(patch_[i])];
      if (w != 1 && w != kCyclePrime - 1) is_unit[c] = 0;
      middle[c] += corner(t, 0) - corner(sets_.find(t), 0);
      size[c] += 1;
    }
    // Six times the volume between a patch and the middle of its component. Only the sign is used,
    // and it does not affect what is inside.
    std::vector<double> volume(at(patches_), 0), total(count, 0);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const auto t = static_cast<std::int32_t>(i);
      if (!isSolid(t)) continue;
      const std::size_t c = at(result_.component[i]);
      const Vector3d origin = corner(sets_.find(t), 0) + middle[c] / size[c];
      const Vector3d a = corner(t, 0) - origin, b = corner(t, 1) - origin,
                     d = corner(t, 2) - origin;
      const double part = (turned_[i] == 0 ? 1 : -1) * a.dot(b.cross(d));
      volume[at(patch_[i])] += part;
      total[c] += cycle_.weight[at(patch_[i])] == 1 ? part : -part;
    }
    weight_of_patch_ = cycle_.weight;
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (!isSolid(static_cast<std::int32_t>(i))) continue;
      const std::size_t c = at(result_.component[i]), p = at(patch_[i]);
      const bool flip = is_unit[c] != 0 ? (cycle_.weight[p] == 1) == (total[c] < 0) : volume[p] < 0;
      if (flip) weight_of_patch_[p] = kCyclePrime - cycle_.weight[p];
      if (is_unit[c] != 0) weight_of_patch_[p] = 1;
      if (flip != (turned_[i] == 1)) std::swap(triangles_[i][1], triangles_[i][2]);
    }
  }

  // A triangle that repeats another one joins its component. A triangle with a repeated corner
  // joins a component that has one of its corners, if any.
  void joinOthers() {
    std::vector<std::int32_t>& component = result_.component;
    std::vector<std::int32_t> of_vertex(vertices_.size(), -1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (twin_[i] >= 0) component[i] = component[at(twin_[i])];
      if (collapsed(triangles_[i])) continue;
      for (const std::int32_t v : triangles_[i]) {
        if (of_vertex[at(v)] < 0) of_vertex[at(v)] = component[i];
      }
    }
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (!collapsed(triangles_[i])) continue;
      for (const std::int32_t v : triangles_[i]) {
        if (of_vertex[at(v)] >= 0) component[i] = of_vertex[at(v)];
      }
    }
    // Renumbers the remaining components.
    std::vector<std::int32_t> renumbered(result_.closed.size(), -1);
    std::vector<std::uint8_t> kept;
    for (std::int32_t& c : component) {
      if (renumbered[at(c)] < 0) {
        renumbered[at(c)] = static_cast<std::int32_t>(kept.size());
        kept.push_back(result_.closed[at(c)]);
      }
      c = renumbered[at(c)];
    }
    result_.closed = std::move(kept);
  }

  void weigh() {
    bool all_one = true;
    for (std::size_t i = 0; i < triangles_.size() && all_one; ++i) {
      all_one = twin_[i] < 0 &&
                (!isSolid(static_cast<std::int32_t>(i)) || weight_of_patch_[at(patch_[i])] == 1);
    }
    if (all_one) return;
    result_.weight.assign(triangles_.size(), 1);
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (twin_[i] >= 0)
        result_.weight[i] = 0;
      else if (isSolid(static_cast<std::int32_t>(i)))
        result_.weight[i] = weight_of_patch_[at(patch_[i])];
    }
  }

  void findOpenEdges() {
    std::vector<std::uint8_t> is_open(vertices_.size(), 0);
    // Edges where a surface with an area ends, and edges where it does not continue as one sheet.
    // The latter belong to parts that close, but have no known inside (Klein bottles, and cases
    // that took too long).
    std::size_t ends = 0, joints = 0;
    bool any = false, has_area = false;
    forEachEdge([&](std::span<const EdgeUse> uses) {
      std::size_t open = 0, with_area = 0;
      for (const EdgeUse& e : uses) {
        if (isSolid(e.triangle)) continue;
        ++open;
        with_area += hasArea(e.triangle) ? 1U : 0U;
      }
      has_area = has_area || with_area > 0;
      if (with_area > 0 && open != 2) ++joints;
      if (open % 2 == 0) return;
      is_open[at(uses[0].low)] = is_open[at(uses[0].high)] = 1;
      ends += with_area > 0 ? 1U : 0U;
      any = true;
    });
    if (has_area && !isFlat())
      result_.open_edges = ends > 0 ? ends : std::max<std::size_t>(joints, 1);
    if (!any) return;
    forEachEdge([&](std::span<const EdgeUse> uses) {
      if (is_open[at(uses[0].low)] != 0 || is_open[at(uses[0].high)] != 0)
        result_.seams.emplace_back(uses[0].low, uses[0].high);
    });
  }

  Vector3d areaNormal(std::int32_t t) const {
    return (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0));
  }
  bool hasArea(std::int32_t t) const {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, (corner(t, (k + 1) % 3) - corner(t, k)).norm());
    return areaNormal(t).norm() > longest * std::max(2 * thickness_, kLine * longest);
  }

  // Whether all triangles that are in no solid lie in one plane. A sheet, with or without holes,
  // has open edges by design, and ignoring them hides no solid. A solid that has lost facets still
  // has others, in at least three planes; if it has lost all but one plane, the file has no data
  // about it.
  bool isFlat() const {
    const auto forEachOpen = [&](const auto& visit) {
      for (std::size_t i = 0; i < triangles_.size(); ++i)
        if (result_.closed[at(result_.component[i])] == 0) visit(static_cast<std::int32_t>(i));
    };
    Vector3d normal = Vector3d::Zero(), point = Vector3d::Zero();
    double largest = 0, extent = 0, departure = 0;
    forEachOpen([&](std::int32_t t) {
      const Vector3d n = areaNormal(t);
      if (!(n.norm() > largest)) return;
      largest = n.norm();
      normal = n / largest;
      point = corner(t, 0);
    });
    forEachOpen([&](std::int32_t t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3d from = corner(t, k) - point;
        extent = std::max(extent, from.norm());
        departure = std::max(departure, std::abs(normal.dot(from)));
      }
    });
    return departure <= kFlatShare * extent;
  }

  std::span<const Vector3d> vertices_;
  std::vector<Triangle>& triangles_;
  double thickness_;
  std::vector<EdgeUse> edges_;
  std::vector<std::int32_t> twin_;  // for each triangle, the one that it repeats, or -1
  UnionFind sets_;                  // of triangles: first patches, then components
  std::vector<Links> links_;
  std::vector<std::int32_t> patch_;  // of each triangle; -1: repeated or collapsed
  std::int32_t patches_ = 0;
  std::vector<signed char> turned_;
  std::vector<std::uint8_t> is_surface_;  // patches that cannot be oriented, or that have a border
                                          // alone
  PatchCycle cycle_;
  std::vector<std::uint64_t> weight_of_patch_;  // for the final orientation of its triangles
  MeshComponents result_;
};

}  // namespace

std::vector<EdgeUse> sortedEdges(std::span<const Triangle> triangles, std::size_t vertices) {
  std::vector<std::int32_t> begin(vertices + 1, 0);
  const auto forEachEdge = [&](const auto& visit) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Triangle& t = triangles[i];
      if (collapsed(t)) continue;
      for (std::size_t k = 0; k < 3; ++k) visit(i, k, t[k], t[(k + 1) % 3]);
    }
  };
  forEachEdge([&](std::size_t, std::size_t, std::int32_t from, std::int32_t to) {
    ++begin[at(std::min(from, to)) + 1];
  });
  for (std::size_t v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
  std::vector<EdgeUse> edges(at(begin.back()));
  std::vector<std::int32_t> next(begin.begin(), begin.end() - 1);
  forEachEdge([&](std::size_t i, std::size_t k, std::int32_t from, std::int32_t to) {
    const std::int32_t low = std::min(from, to);
    edges[at(next[at(low)]++)] = {low, std::max(from, to), static_cast<std::int32_t>(i),
                                  static_cast<std::int32_t>(k), from < to};
  });
  for (std::size_t v = 0; v < vertices; ++v) {
    std::sort(edges.begin() + begin[v], edges.begin() + begin[v + 1],
              [](const EdgeUse& a, const EdgeUse& b) {
                return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
              });
  }
  return edges;
}

MeshComponents findComponents(std::span<const Vector3d> vertices, std::vector<Triangle>& triangles,
                              double thickness) {
  return Components(vertices, triangles, thickness).take();
}

}  // namespace leeway::collision
