#include "planner/execute/path_timing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

struct Range {
  double low, high;
  bool empty() const { return !(low <= high); }
};

/// A part of a piece over which d2s/dt2 = u is constant. Below, x is (ds/dt)^2.
struct Cell {
  const CurvePiece* piece;
  int index;  // of the piece
  double begin, length;
};

class Timing {
 public:
  Timing(std::span<const CurvePiece> pieces, std::span<const double> velocity,
         std::span<const double> acceleration)
      : velocity_(velocity), acceleration_(acceleration) {
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      const int count = pieces[p].straight ? 1 : kBendCells;
      const double length = pieces[p].length;
      for (int i = 0; i < count; ++i)
        cells_.push_back({&pieces[p], static_cast<int>(p), length * i / count, length / count});
    }
    limitBackwards();
  }

  std::vector<TimedPhase> phases() const {
    std::vector<TimedPhase> result;
    double time = 0, x = 0;
    // Distances count from the beginning of their piece. In a sum over all pieces, rounding would
    // hide short pieces.
    const auto phase = [&](int piece, double way, double length, double u, double next) {
      const double rate = std::sqrt(x), then = std::sqrt(next);
      x = next;
      if (!(length > 0) || !(rate + then > 0)) return;
      result.push_back({time, piece, way, rate, u});
      time += 2 * length / (rate + then);
    };
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const Cell& cell = cells_[i];
      if (!cell.piece->straight) {
        const double u = accelerations(cell, x, most_[i + 1]).high;
        const double next = std::clamp(x + 2 * cell.length * u, 0.0, most_[i + 1]);
        phase(cell.index, cell.begin, cell.length, u, next);
        continue;
      }
      const double a = straightAcceleration(*cell.piece), gain = 2 * a * cell.length;
      const double next = std::min(most_[i + 1], x + gain);
      const double peak = std::clamp((x + next + gain) / 2, std::max(x, next),
                                     std::max(speedLimit(cell), std::max(x, next)));
      const double rise = std::min((peak - x) / (2 * a), cell.length);
      const double falling = std::max(cell.length - (peak - next) / (2 * a), rise);  // from here on
      phase(cell.index, 0, rise, a, peak);
      phase(cell.index, rise, falling - rise, 0, peak);
      phase(cell.index, falling, cell.length - falling, -a, next);
    }
    result.push_back({time, cells_.back().index, cells_.back().piece->length, 0, 0});
    return result;
  }

 private:
  /// q' at a point of a piece.
  static double slope(const CurvePiece& piece, double s, std::size_t i) {
    const double share = s / piece.length;
    return (1 - share) * piece.first[i] + share * piece.last[i];
  }

  /// The largest x that keeps the velocity limits over the whole cell.
  double speedLimit(const Cell& cell) const {
    double most = kInfinity;
    for (std::size_t i = 0; i < velocity_.size(); ++i) {
      const double steepest = std::max(std::abs(slope(*cell.piece, cell.begin, i)),
                                       std::abs(slope(*cell.piece, cell.begin + cell.length, i)));
      if (steepest > 0) most = std::min(most, velocity_[i] / steepest);
    }
    return most * most;
  }

  double straightAcceleration(const CurvePiece& piece) const {
    double most = kInfinity;
    for (std::size_t i = 0; i < acceleration_.size(); ++i)
      if (piece.first[i] != 0) most = std::min(most, acceleration_[i] / std::abs(piece.first[i]));
    return most;
  }

  /// All u that keep the acceleration limits over the cell from x and end at `next` or less.
  Range accelerations(const Cell& cell, double x, double next) const {
    const double twice = 2 * cell.length;
    Range range{-x / twice, (next - x) / twice};
    for (std::size_t i = 0; i < acceleration_.size(); ++i) {
      const double bend = (cell.piece->last[i] - cell.piece->first[i]) / cell.piece->length;
      // d2q/dt2 = q' u + q'' x at the beginning of the cell. At its end, x has become x + 2 length
      // u.
      const double slopes[2] = {slope(*cell.piece, cell.begin, i),
                                slope(*cell.piece, cell.begin + cell.length, i) + bend * twice};
      for (const double factor : slopes) {
        const double low = -acceleration_[i] - bend * x, high = acceleration_[i] - bend * x;
        if (factor == 0) {
          if (low > 0 || high < 0) return {1, 0};
          continue;
        }
        range.low = std::max(range.low, (factor > 0 ? low : high) / factor);
        range.high = std::min(range.high, (factor > 0 ? high : low) / factor);
      }
    }
    return range;
  }

  /// most_[i]: the largest x at the beginning of cell i from which the end can be reached.
  void limitBackwards() {
    most_.assign(cells_.size() + 1, 0);
    for (std::size_t i = cells_.size(); i-- > 0;) {
      const Cell& cell = cells_[i];
      const double limit = speedLimit(cell);
      most_[i + 1] = std::min(most_[i + 1], limit);
      if (cell.piece->straight) {
        const double gain = 2 * straightAcceleration(*cell.piece) * cell.length;
        most_[i] = std::min(limit, most_[i + 1] + gain);
        continue;
      }
      // The feasible x form an interval from 0: bisection finds its end.
      double low = 0, high = limit;
      if (!accelerations(cell, high, most_[i + 1]).empty()) low = high;
      while (low < high) {  // to adjacent numbers: limits may differ by any power of ten
        const double middle = low + (high - low) / 2;
        if (middle == low || middle == high) break;
        (accelerations(cell, middle, most_[i + 1]).empty() ? high : low) = middle;
      }
      most_[i] = low;
    }
    most_[0] = 0;  // at rest
  }

  std::span<const double> velocity_, acceleration_;
  std::vector<Cell> cells_;
  std::vector<double> most_;
};

}  // namespace

std::vector<TimedPhase> timeOptimal(std::span<const CurvePiece> pieces,
                                    std::span<const double> velocity,
                                    std::span<const double> acceleration) {
  return Timing(pieces, velocity, acceleration).phases();
}

double timeAt(std::span<const TimedPhase> phases, int piece, double way) {
  const auto phase = std::prev(std::upper_bound(
      phases.begin() + 1, phases.end(), way, [piece](double to, const TimedPhase& p) {
        return piece < p.piece || (piece == p.piece && to < p.way);
      }));
  const double rest = phase->piece == piece ? std::max(0.0, way - phase->way) : 0;
  const double then =
      std::sqrt(std::max(0.0, phase->rate * phase->rate + 2 * phase->acceleration * rest));
  const double speed = phase->rate + then;  // 0 at the end; rounding may put `way` beyond it
  return phase->start + (speed > 0 ? 2 * rest / speed : 0);
}

double timeAt(const RestToRest& profile, double way) {
  double low = 0, high = profile.duration();
  if (!(way < 1)) return high;  // rounding reaches it before
  for (int k = 0; k < 100; ++k) {
    const double middle = low + (high - low) / 2;
    (profile.at(middle).way < way ? low : high) = middle;
  }
  return high;
}

}  // namespace leeway::planner
