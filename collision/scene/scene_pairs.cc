// The pairs of a scene: a list, and runs of moving geometries over what stands still.

#include "leeway/collision/scene_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/greatest.h"
#include "collision/base/numbers.h"

namespace leeway::collision {
namespace {

double grown(double margin, double growth) { return std::max(margin, 0.0) + growth; }

}  // namespace

std::size_t ScenePairs::leftOutBefore(std::size_t position) const {
  const auto after = std::partition_point(left_out_.begin(), left_out_.end(),
                                          [&](const LeftOut& l) { return l.begin < position; });
  if (after == left_out_.begin()) return 0;
  const LeftOut& last = *std::prev(after);
  return last.before + std::min(position, last.end) - last.begin;
}

bool ScenePairs::isLeftOut(std::size_t position) const {
  const auto after = std::partition_point(left_out_.begin(), left_out_.end(),
                                          [&](const LeftOut& l) { return l.end <= position; });
  return after != left_out_.end() && after->begin <= position;
}

std::size_t ScenePairs::runBegin(std::size_t run) const {
  const std::size_t position = run * places_;
  return listed_.size() + position - leftOutBefore(position);
}

ScenePairs::Place ScenePairs::placeOf(std::size_t number) const {
  const std::size_t kept = number - listed_.size();
  std::size_t position = kept;
  const auto after =
      std::partition_point(left_out_.begin(), left_out_.end(),
                           [&](const LeftOut& l) { return l.begin - l.before <= kept; });
  if (after != left_out_.begin()) {
    const LeftOut& last = *std::prev(after);
    position += last.before + last.end - last.begin;
  }
  return {position / places_, position % places_};
}

std::int32_t ScenePairs::numberOf(std::size_t run, std::size_t place) const {
  const std::size_t position = run * places_ + place;
  if (isLeftOut(position)) return -1;
  return static_cast<std::int32_t>(listed_.size() + position - leftOutBefore(position));
}

double ScenePairs::marginAt(std::size_t position) const {
  const auto own = std::partition_point(own_.begin(), own_.end(),
                                        [&](const Own& o) { return o.position < position; });
  if (own != own_.end() && own->position == position) return own->margin;
  return runs_[position / places_].margin;
}

ScenePair ScenePairs::at(std::size_t position) const {
  const Run& run = runs_[position / places_];
  const std::size_t place = position % places_;
  const Geometry still = geometryIn(place);
  return {run.body, run.geometry, still.body, still.geometry, marginAt(position)};
}

ScenePair ScenePairs::ofRun(std::size_t number) const {
  const Place place = placeOf(number);
  return at(place.run * places_ + place.place);
}

double ScenePairs::leastMargin(int first_body, bool with) const {
  double least = kInfinity;
  // A pair with NaN is never free, and there: 0 says so, and is cautious.
  const auto take = [&least](double margin) {
    least = std::min(least, std::isnan(margin) ? 0.0 : margin);
  };
  for (const ScenePair& pair : listed_)
    if ((std::max(pair.body_a, pair.body_b) >= first_body) == with) take(pair.margin);
  // All of a run are with a body from first_still_ on.
  if (with != (first_still_ >= first_body)) return least;
  auto own = own_.begin();
  for (std::size_t run = 0; run < runs_.size(); ++run) {
    // A run's margin counts only where some pair has it.
    std::size_t without_own = runBegin(run + 1) - runBegin(run);
    for (; own != own_.end() && own->position < (run + 1) * places_; ++own, --without_own)
      take(own->margin);
    if (without_own > 0) take(runs_[run].margin);
  }
  return least;
}

double ScenePairs::mostMargin() const {
  double margin = -kInfinity;
  for (const ScenePair& pair : listed_) margin = greatest(margin, pair.margin);
  for (std::size_t run = 0; run < runs_.size(); ++run)
    margin = greatest(margin, mostMarginOfRun(run));
  return margin;
}

double ScenePairs::mostMarginOfRun(std::size_t run) const {
  double margin = -kInfinity;
  std::size_t without_own = runBegin(run + 1) - runBegin(run);
  auto own = std::partition_point(own_.begin(), own_.end(),
                                  [&](const Own& o) { return o.position < run * places_; });
  for (; own != own_.end() && own->position < (run + 1) * places_; ++own, --without_own)
    margin = greatest(margin, own->margin);
  return without_own > 0 ? greatest(margin, runs_[run].margin) : margin;
}

void ScenePairs::setLeftOut(const std::vector<std::size_t>& positions) {
  std::vector<LeftOut> left_out;
  for (const std::size_t position : positions) {
    if (!left_out.empty() && left_out.back().end == position)
      ++left_out.back().end;
    else
      left_out.push_back({position, position + 1, 0});
  }
  left_out_.clear();
  leaveOut(std::move(left_out));
}

void ScenePairs::listAll() {
  std::vector<ScenePair> all;
  all.reserve(size_);
  for (std::size_t number = 0; number < size_; ++number) all.push_back((*this)[number]);
  *this = ScenePairs();
  listed_ = std::move(all);
  size_ = listed_.size();
}

void ScenePairs::raise(double margin, int first_body) {
  const auto raised = [&](double& m) { m = std::max(m, margin); };  // NaN stays
  for (ScenePair& pair : listed_)
    if (std::max(pair.body_a, pair.body_b) >= first_body) raised(pair.margin);
  // All of a run are with a body from first_still_ on; callers ask for all of these or more.
  for (Run& run : runs_) raised(run.margin);
  for (Own& own : own_) raised(own.margin);
}

void ScenePairs::grow(int body, int geometry, double growth, std::size_t first_place) {
  for (ScenePair& pair : listed_)
    if ((pair.body_a == body && pair.geometry_a == geometry) ||
        (pair.body_b == body && pair.geometry_b == geometry))
      pair.margin = grown(pair.margin, growth);
  if (runs_.empty()) return;
  if (body < first_still_) {
    for (std::size_t run = 0; run < runs_.size(); ++run) {
      if (runs_[run].body != body || runs_[run].geometry != geometry) continue;
      runs_[run].margin = grown(runs_[run].margin, growth);
      for (Own& own : own_)
        if (own.position / places_ == run) own.margin = grown(own.margin, growth);
    }
    return;
  }
  std::vector<Own> changed;
  for (std::size_t run = 0; run < runs_.size(); ++run) {
    const std::size_t position = run * places_ + first_place + static_cast<std::size_t>(geometry);
    if (!isLeftOut(position)) changed.push_back({position, grown(marginAt(position), growth)});
  }
  setOwn(changed);
}

void ScenePairs::setOwn(const std::vector<Own>& margins) {
  // New ones come first among equals, and stay.
  const auto before = [](const Own& x, const Own& y) { return x.position < y.position; };
  std::vector<Own> merged;
  merged.reserve(own_.size() + margins.size());
  std::merge(margins.begin(), margins.end(), own_.begin(), own_.end(), std::back_inserter(merged),
             before);
  merged.erase(std::unique(merged.begin(), merged.end(),
                           [](const Own& x, const Own& y) { return x.position == y.position; }),
               merged.end());
  own_ = std::move(merged);
}

void ScenePairs::addPlaces(std::size_t count) {
  const std::size_t before = places_;
  places_ += count;
  for (Own& own : own_) own.position += own.position / before * count;
  std::vector<LeftOut> moved;
  for (const LeftOut& l : left_out_) {
    for (std::size_t begin = l.begin; begin < l.end;) {  // it may go over from run to run
      const std::size_t run = begin / before, end = std::min(l.end, (run + 1) * before);
      moved.push_back({begin + run * count, end + run * count, 0});
      begin = end;
    }
  }
  left_out_.clear();
  leaveOut(std::move(moved));
}

void ScenePairs::leaveOut(std::vector<LeftOut> more) {
  more.insert(more.end(), left_out_.begin(), left_out_.end());
  std::sort(more.begin(), more.end(),
            [](const LeftOut& x, const LeftOut& y) { return x.begin < y.begin; });
  left_out_.clear();
  std::size_t count = 0;
  for (const LeftOut& l : more) {
    if (l.begin == l.end) continue;  // of a body without geometries
    if (left_out_.empty() || left_out_.back().end < l.begin)
      left_out_.push_back({l.begin, l.begin, count});
    LeftOut& last = left_out_.back();
    count += std::max(last.end, l.end) - last.end;
    last.end = std::max(last.end, l.end);
  }
  std::erase_if(own_, [&](const Own& own) { return isLeftOut(own.position); });
  size_ = listed_.size() + runs_.size() * places_ - count;
}

void ScenePairs::keep(const std::function<bool(const ScenePair&)>& keeps, std::size_t most_listed) {
  std::erase_if(listed_, [&](const ScenePair& pair) { return !keeps(pair); });
  std::vector<std::size_t> left_out;
  for (std::size_t position = 0; position < runs_.size() * places_; ++position)
    if (isLeftOut(position) || !keeps(at(position))) left_out.push_back(position);
  setLeftOut(left_out);
  if (hasRuns() && size_ <= most_listed) listAll();
}

}  // namespace leeway::collision
