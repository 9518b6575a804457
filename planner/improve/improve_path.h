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

/// How every path is made better, in place: a move puts other points between two of its waypoints,
/// its edges are proven, the measure compares, and the move is kept or left. Derived classes say
/// which moves there are and what better means. The path's ends never change.
class PathImprover {
 protected:
  using Point = std::vector<double>;

  /// Other points between two waypoints, in place of those that are there.
  struct Move {
    std::size_t first, last;
    std::span<const Point> points;
  };

  /// `stop` is asked before each `turn`-th edge; once it says so, nothing is taken any more.
  PathImprover(EdgeCertifier& certifier, Waypoints& path, const std::function<bool()>& stop,
               int turn = 1)
      : certifier_(certifier),
        space_(certifier.scene().space()),
        path_(path),
        stop_(stop),
        turn_(turn) {}
  PathImprover(const PathImprover&) = delete;
  PathImprover& operator=(const PathImprover&) = delete;
  virtual ~PathImprover() = default;

  /// Whether the move is taken: it may gain, its edges are proven, it gains. O(waypoints), beside
  /// the proofs.
  bool take(const Move& move);
  bool isOver();

  /// The measure: cheap bounds before the proofs, ...
  virtual bool mayGain(const Move&) { return true; }
  /// ... the proof of one edge, by default of its margins, ...
  virtual bool proves(const Move& move, std::size_t edge);
  /// ... what remains to be compared, ...
  virtual bool gains(const Move&) { return true; }
  /// ... and what is kept beside the waypoints, which change after that.
  virtual void keep(const Move&) {}

  /// Where edge k of a move begins; k = points + 1 is the end of the last.
  const Point& pointOf(const Move& move, std::size_t k) const;
  double lengthOf(const Move& move) const;
  double lengthBetween(std::size_t first, std::size_t last) const;
  Point between(std::size_t edge, double t) const;
  /// A place moved by `scale` times a direction, as far as the limits let it; empty where the
  /// limits of an orientation do not.
  Point advanced(const Point& from, std::span<const double> direction, double scale) const;

  /// Puts others in place of the elements from `begin` to `end`, the latter excluded.
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

/// The scene with all margins of these pairs at least `margin` [m].
std::shared_ptr<const CompiledScene> raised(const CompiledScene& scene, Pairs of, double margin);

}  // namespace leeway::planner
