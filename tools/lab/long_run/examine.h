#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/lab/long_run/cases.h"
#include "tools/lab/long_run/independent.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::accuracy {

struct Tally {
  std::int64_t cases = 0;
  std::int64_t answers = 0;      // to the queries of these cases, each checked
  std::int64_t overlapping = 0;  // the truth is below 0
  std::int64_t unsafe = 0;       // intervals that exclude the truth
  std::int64_t failures = 0;     // any other violated guarantee of distance.h
  std::int64_t open = 0;         // default tolerance not reached
  std::int64_t oracle = 0;       // answers that quadruple precision proves
  std::int64_t unproven = 0;     // neither proven nor refuted, because the oracle's bounds are
                                 // wider

  void add(const Tally& t);
};

/// Queries one case in every way a caller can. Checks the answers in extended precision, against
/// each other and, on request, against the quadruple-precision oracle. A failed check prints its
/// reproduction to stderr.
class Examiner {
 public:
  /// `says` prefixes each message.
  void examine(const Case& c, oracle::Random& random, bool with_oracle, const std::string& says,
               Tally& tally);
  /// Set this to report also cases that stay open.
  bool verbose = false;

 private:
  struct Ask {
    collision::DistanceRequest request;
    collision::PairCache* cache = nullptr;
    bool swapped = false;
    const char* how = "plain";
  };
  collision::DistanceResult ask(const Ask& ask);
  void judge(const Ask& ask, const collision::DistanceResult& r);
  void judgePlane(const Ask& ask, const collision::DistanceResult& r);
  void judgeHalfSpace(const Ask& ask, const collision::DistanceResult& r);
  void judgeWitness(const Ask& ask, const collision::DistanceResult& r);
  void tryPlanes(const Ask& ask, const collision::DistanceResult& r, oracle::Random& random);
  void meet(const Ask& ask, const collision::DistanceResult& r);
  void threshold(oracle::Random& random);
  bool proves(const collision::Interval& answer);
  void holdAgainstOracle(const Ask& ask, const collision::DistanceResult& r);
  Real provenAlong(const Eigen::Vector3d& n) const;
  void say(const char* what, const Ask& ask, const collision::DistanceResult& r, Real value,
           std::int64_t& count);

  const Case* case_ = nullptr;
  const std::string* says_ = nullptr;
  Tally* tally_ = nullptr;
  double size_ = 0;  // sizes involved: extents and distance of the frames' origins [m]
  double default_tolerance_ = 0;
  double coordinate_ = 0;  // largest coordinate in the world [m]
  bool half_space_ = false;
  collision::DistanceResult exact_;
  std::optional<oracle::Truth> truth_;  // if the oracle is used: as narrow as required so far
  bool truth_is_final_ = false;         // it was searched to its end
  collision::Scratch scratch_;
  collision::PairCache cache_;
  int said_ = 0;
};

}  // namespace leeway::accuracy
