#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "leeway/collision/time_of_contact.h"
#include "tools/lab/base/engine.h"

namespace leeway::tools::report {

/// An engine's first time of contact, in [0, 1].
struct ContactAnswer {
  bool contact = false;
  bool undecided = false;  ///< a limit or rounding left it open
  /// Time of contact; engines that return a single number set both ends to it.
  double lower = std::numeric_limits<double>::quiet_NaN(), upper = lower;
};

/// A shape and how it moves.
struct MovingBody {
  const ReportShape* shape = nullptr;
  std::shared_ptr<const collision::RigidMotion> motion;
  /// A StraightMotion between its ends. Engines limited to such motions follow others in pieces.
  bool straight = true;
};

/// A query for the first contact of any listed pair of bodies, or of two triangles with moving
/// corners.
struct ContactSpec {
  std::vector<MovingBody> bodies;
  std::vector<std::array<std::size_t, 2>> pairs;
  std::vector<collision::MovingTriangle> triangles;  ///< two if `bodies` is empty
  double margin = 0;  ///< contact begins at this distance [m], for engines with a margin
};

/// One engine's form of one case, prepared off the clock.
class ContactQuery {
 public:
  virtual ~ContactQuery() = default;
  /// May throw, abort or loop; the report counts that.
  virtual ContactAnswer ask() = 0;
};

class ContactEngine {
 public:
  virtual ~ContactEngine() = default;
  virtual const char* name() const = 0;
  /// True: the interval of the time claims to contain the truth.
  virtual bool claimsBounds() const { return false; }
  /// Null if the engine lacks such shapes or motions.
  virtual std::unique_ptr<ContactQuery> prepare(const ContactSpec& spec) const = 0;
};

/// Number of straight pieces for engines limited to straight motions.
inline constexpr int kMotionPieces = 32;

/// First contact by an engine limited to single pairs and straight motions: one pair after the
/// other, each motion in kMotionPieces pieces unless it is straight. `follow(pair, X_WA0, X_WA1,
/// X_WB0, X_WB1)` returns the fraction of the piece at which contact begins, negative if there is
/// none.
template <typename Follow>
ContactAnswer firstOfPieces(const ContactSpec& spec, const Follow& follow) {
  ContactAnswer first;
  for (std::size_t p = 0; p < spec.pairs.size(); ++p) {
    const MovingBody &a = spec.bodies[spec.pairs[p][0]], &b = spec.bodies[spec.pairs[p][1]];
    const int pieces = a.straight && b.straight ? 1 : kMotionPieces;
    for (int k = 0; k < pieces; ++k) {
      const double begin = static_cast<double>(k) / pieces;
      const double end = static_cast<double>(k + 1) / pieces;
      if (first.contact && begin >= first.upper) break;
      const double fraction = follow(p, a.motion->pose(begin), a.motion->pose(end),
                                     b.motion->pose(begin), b.motion->pose(end));
      if (!(fraction >= 0)) continue;
      const double time = begin + fraction * (end - begin);
      if (!first.contact || time < first.upper) first = {true, false, time, time};
      break;
    }
  }
  return first;
}

}  // namespace leeway::tools::report
