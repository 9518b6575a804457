#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "planner/base/waypoints.h"

namespace leeway::planner {

/// Improves a path in place. A move replaces the points between two of its waypoints. Its edges are
/// proven, the measure compares, and the move is kept or discarded. Derived classes define the
/// moves and the measure. The path's ends never change.
class PathImprover {
 public:
  PathImprover(const PathImprover&) = delete;
  PathImprover& operator=(const PathImprover&) = delete;

 protected:
  using Point = std::vector<double>;

  /// New points between two waypoints, which replace the current ones.
  struct Move {
    std::size_t first, last;
    std::span<const Point> points;
  };

  /// `stop` is polled before each `turn`-th edge; once it returns true, no move is taken.
  PathImprover(EdgeCertifier& certifier, Waypoints& path, const std::function<bool()>& stop,
               int turn = 1)
      : certifier_(certifier),
        space_(certifier.scene().space()),
        path_(path),
        stop_(stop),
        turn_(turn) {}
  virtual ~PathImprover() = default;

  /// Takes the move if it may gain, its edges are proven, and it gains; returns whether it does.
  /// O(waypoints), in addition to the proofs.
  bool take(const Move& move);
  bool isOver();

  /// The measure: cheap bounds before the proofs, ...
  virtual bool mayGain(const Move&) { return true; }
  /// ... the proof of one edge, by default of its margins, ...
  virtual bool proves(const Move& move, std::size_t edge);
  /// ... the comparison after the proofs, ...
  virtual bool gains(const Move&) { return true; }
  /// ... and an update of data in addition to the waypoints, which change after it.
  virtual void keep(const Move&) {}

  /// The start of edge k of a move; k = points + 1 is the end of the last edge.
  const Point& pointOf(const Move& move, std::size_t k) const;
  double lengthOf(const Move& move) const;
  double lengthBetween(std::size_t first, std::size_t last) const;
  Point between(std::size_t edge, double t) const;
  /// A place moved by `scale` times a direction, as far as the limits allow; empty if the limits of
  /// an orientation do not allow it.
  Point advanced(const Point& from, std::span<const double> direction, double scale) const;

  /// Replaces the elements from `begin` to `end`, the latter excluded, by others.
  template <typename T, typename Others>
  static void replace(std::vector<T>& all, std::size_t begin, std::size_t end,
                      const Others& others) {
    const auto from = all.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto at = all.erase(from, all.begin() + static_cast<std::ptrdiff_t>(end));
    all.insert(at, others.begin(), others.end());
  }

  EdgeCertifier& certifier_;
  const ConfigurationSpace& space_;
  Waypoints& path_;
  bool is_over_ = false;

 private:
  const std::function<bool()>& stop_;
  int turn_, asked_ = 0;
};

/// The scene with the margins of these pairs raised to at least `margin` [m].
std::shared_ptr<const CompiledScene> raised(const CompiledScene& scene, Pairs of, double margin);

}  // namespace leeway::planner
