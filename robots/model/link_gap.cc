#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "collision/base/sine_cosine.h"
#include "leeway/robots/model.h"
#include "robots/base/tolerances.h"
#include "robots/model/same_robot.h"

namespace leeway::robots {
namespace {

/// The arcs that hold all angles of a range, rounding included. Each arc once if the range has more
/// than a turn.
struct ArcRange {
  std::int64_t first = 0;
  int count = LinkGap::kArcs;

  explicit ArcRange(const LinkGap::Range& range) {
    const double slack = kGapSlack * (1 + std::abs(range.from) + std::abs(range.to));
    constexpr double kScale = LinkGap::kArcs / collision::kTwoPi;
    const double low = std::floor((std::min(range.from, range.to) - slack) * kScale),
                 high = std::floor((std::max(range.from, range.to) + slack) * kScale);
    // Written so that NaN takes all arcs.
    if (!(high - low < LinkGap::kArcs) || !(std::abs(low) < 1e9)) return;
    first = static_cast<std::int64_t>(low);
    count = static_cast<int>(high - low) + 1;
  }
  std::size_t operator[](int i) const {
    return static_cast<std::size_t>(((first + i) % LinkGap::kArcs + LinkGap::kArcs) %
                                    LinkGap::kArcs);
  }
};

}  // namespace

double LinkGap::over(const Range& angles, const Range& others) const {
  const ArcRange arcs(angles), other_arcs(others);
  float least = std::numeric_limits<float>::infinity();
  for (int i = 0; i < arcs.count; ++i) {
    const std::size_t arc = arcs[i];
    if (gaps[arc] > 0) {
      least = std::min(least, gaps[arc]);
      continue;
    }
    for (int k = 0; k < other_arcs.count; ++k)
      if (cells[arc * kArcs + other_arcs[k]] == 0) return 0;
    least = std::min(least, cell_gap);
  }
  return static_cast<double>(least);
}

void Model::keepGaps(std::vector<LinkGap> gaps) {
  link_gaps_ = std::move(gaps);
  gaps_of_ = std::make_shared<const RobotDescription>(*this);
}

const std::vector<LinkGap>& Model::linkGaps() const {
  static const std::vector<LinkGap> none;
  const bool holds = gaps_of_ != nullptr && areSameBodies(*this, *gaps_of_);
  return holds ? link_gaps_ : none;
}

}  // namespace leeway::robots
