#include "planner/edge/edge_parts.h"

#include <algorithm>
#include <bit>

#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

constexpr std::size_t kMostParts = 512;

}  // namespace

EdgeParts::EdgeParts(EdgeFrames& frames, EdgeLanes& lanes, ContactSearch& contacts,
                     EdgeQueue& queue, const collision::Work& work, std::size_t pairs,
                     std::size_t tasks)
    : frames_(frames), lanes_(lanes), contacts_(contacts), queue_(queue), work_(work) {
  parts_.reserve(kMostParts);
  part_pairs_.reserve(tasks);
  pass_pairs_.reserve(pairs);
}

bool EdgeParts::begin() {
  queue_.clear();
  parts_.clear();
  part_pairs_.clear();
  next_ = 0;
  return addOpenIntervals() && list(EdgeLanes::wholeEdge());
}

int EdgeParts::intervalsPerSweep(const collision::LaneSweep::Open& pair) const {
  double growth = lanes_.growth(frames_.pair(pair.id).motion);
  int width = 1;
  while (width < collision::kLanes && 4 * growth <= kMergedGrowth) {
    growth *= 4;
    width *= 2;
  }
  return width;
}

bool EdgeParts::isSweptOver(const collision::LaneSweep::Open& pair, int interval, int width) const {
  const auto block = [](int first, int count) { return ((1U << count) - 1) << first; };
  const std::uint32_t wanted = block(interval, width);
  if (!frames_.pair(pair.id).by_surfaces)
    return (pair.intervals & wanted) != 0 && intervalsPerSweep(pair) == width;
  // The sweep of surfaces halves long parts itself if that pays, so it gets the widest open blocks.
  if ((pair.intervals & wanted) != wanted) return false;
  if (width == collision::kLanes) return true;
  const std::uint32_t wider = block(interval & ~(2 * width - 1), 2 * width);
  return (pair.intervals & wider) != wider;
}

bool EdgeParts::addOpenIntervals() {
  if (lanes_.isFull()) return false;
  constexpr double h = 1.0 / collision::kLanes;
  for (int width = collision::kLanes, level = 0; width >= 1; width /= 2, ++level)
    for (int interval = 0; interval < collision::kLanes; interval += width)
      for (const collision::LaneSweep::Open& pair : lanes_.open())
        if (!isForParts(pair) && isSweptOver(pair, interval, width) &&
            !queue_.add(pair.id, interval * h, width * h, level))
          return false;
  return true;
}

std::optional<PairVerdict> EdgeParts::certify() {
  for (int passes = 0; next_ < parts_.size() && passes < kLanePasses; ++passes) {
    const Part& first = parts_[next_];
    if (first.width <= kFinestPart) break;
    if (work_.isSpent())
      return PairVerdict{Verdict::kUndecided, part_pairs_[at(first.begin)], first.from};
    const EdgeLanes::Parts parts = take();
    const collision::LaneSweep::Contact contact = lanes_.sweepParts(parts, pass_pairs_);
    if (contact.id >= 0)
      return PairVerdict{Verdict::kNotFree, contact.id, parts.middle(contact.interval)};
    if (const auto verdict = contacts_.search(parts)) return verdict;
    if (!list(parts)) return PairVerdict{Verdict::kUndecided, -1, parts.from[0]};
  }
  if (!addTasks()) return PairVerdict{Verdict::kUndecided, -1, parts_[next_].from};
  return std::nullopt;
}

EdgeLanes::Parts EdgeParts::take() {
  // One, two or four parts of one width; each is divided so that all lanes are used.
  const double width = parts_[next_].width;
  std::size_t count = 1;
  while (count < std::min<std::size_t>(4, parts_.size() - next_) &&
         parts_[next_ + count].width == width)
    ++count;
  const int share = collision::kLanes / (count == 3 ? 4 : static_cast<int>(count));
  EdgeLanes::Parts parts;
  parts.width = width / share;
  parts.share = share;
  pass_pairs_.clear();
  for (std::size_t k = 0; k < count; ++k, ++next_) {
    const Part& part = parts_[next_];
    const int interval = static_cast<int>(k) * share;
    for (int i = 0; i < share; ++i) parts.from[interval + i] = part.from + i * parts.width;
    const std::uint32_t mask = ((1U << share) - 1) << interval;
    for (int i = part.begin; i < part.end; ++i) {
      const int id = part_pairs_[at(i)];
      const auto known = std::find_if(pass_pairs_.begin(), pass_pairs_.end(),
                                      [id](const auto& pair) { return pair.id == id; });
      if (known == pass_pairs_.end())
        pass_pairs_.push_back({id, mask});
      else
        known->intervals |= mask;
    }
  }
  return parts;
}

bool EdgeParts::list(const EdgeLanes::Parts& parts) {
  for (int first = 0; first < collision::kLanes; first += parts.share) {
    if (!listWideOpen(parts, first)) return false;
    for (int interval = first; interval < first + parts.share; ++interval)
      if (!listInterval(parts, interval, first)) return false;
  }
  return true;
}

bool EdgeParts::isWideOpen(const collision::LaneSweep::Open& pair, int first, int share) {
  const std::uint32_t mask = ((1U << share) - 1) << first;
  return share > 1 && 2 * std::popcount(pair.intervals & mask) > share;
}

bool EdgeParts::listWideOpen(const EdgeLanes::Parts& parts, int first) {
  for (const collision::LaneSweep::Open& pair : lanes_.open())
    if (isWideOpen(pair, first, parts.share) &&
        !queue_.add(pair.id, parts.from[first], parts.width * parts.share))
      return false;
  return true;
}

bool EdgeParts::listInterval(const EdgeLanes::Parts& parts, int interval, int first) {
  // After the pass over the whole edge, addOpenIntervals() handles the pairs that finer passes
  // cannot separate.
  const bool is_whole_edge = parts.share == 1;
  if (part_pairs_.size() + lanes_.open().size() > part_pairs_.capacity()) return false;
  const auto begin = static_cast<int>(part_pairs_.size());
  for (const collision::LaneSweep::Open& pair : lanes_.open()) {
    if ((pair.intervals >> interval & 1U) == 0 || isWideOpen(pair, first, parts.share)) continue;
    if (is_whole_edge ? isForParts(pair) : pair.apart) {
      part_pairs_.push_back(pair.id);
    } else if (!is_whole_edge && !queue_.add(pair.id, parts.from[interval], parts.width)) {
      return false;
    }
  }
  const auto end = static_cast<int>(part_pairs_.size());
  if (begin == end) return true;
  if (parts_.size() == parts_.capacity()) return false;
  parts_.push_back({parts.from[interval], parts.width, begin, end});
  return true;
}

bool EdgeParts::addTasks() {
  for (; next_ < parts_.size(); ++next_) {
    const Part& part = parts_[next_];
    for (int i = part.begin; i < part.end; ++i)
      if (!queue_.add(part_pairs_[at(i)], part.from, part.width)) return false;
  }
  return true;
}

}  // namespace leeway::planner
