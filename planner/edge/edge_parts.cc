// Finer passes of lanes. A plane parts two hulls over a part of the edge where none parts them over
// all of a lane: what a pass leaves open but apart is divided among the lanes of the next pass,
// which looks at nothing else.

#include <algorithm>
#include <bit>

#include "planner/base/tolerances.h"
#include "planner/edge/edge_certifier_impl.h"

namespace leeway::planner {

std::optional<EdgeCheck> EdgeCertifier::Impl::certifyParts() {
  std::size_t next = 0;
  for (int passes = 0; next < edge_parts.size() && passes < kLanePasses; ++passes) {
    const EdgePart& first = edge_parts[next];
    if (first.width <= kFinestPart) break;
    if (work.isSpent())
      return makeCheck(Verdict::kUndecided, part_pairs[at(first.begin)], first.from);
    const EdgeLanes::Parts parts = takeParts(next);
    const collision::LaneSweep::Contact contact = lanes.sweepParts(parts, pass_pairs);
    if (contact.id >= 0) return makeCheck(parts, contact);
    if (const auto check = searchContacts(parts)) return check;
    if (!listParts(parts)) return makeCheck(Verdict::kUndecided, -1, parts.from[0]);
  }
  if (!listPartsLeft(next)) return makeCheck(Verdict::kUndecided, -1, edge_parts[next].from);
  return std::nullopt;
}

EdgeLanes::Parts EdgeCertifier::Impl::takeParts(std::size_t& next) {
  // One, two or four parts of one width; each is divided so that all lanes are full.
  const double width = edge_parts[next].width;
  std::size_t count = 1;
  while (count < std::min<std::size_t>(4, edge_parts.size() - next) &&
         edge_parts[next + count].width == width)
    ++count;
  const int share = collision::kLanes / (count == 3 ? 4 : static_cast<int>(count));
  EdgeLanes::Parts parts;
  parts.width = width / share;
  parts.share = share;
  pass_pairs.clear();
  for (std::size_t k = 0; k < count; ++k, ++next) {
    const EdgePart& part = edge_parts[next];
    const int lane = static_cast<int>(k) * share;
    for (int i = 0; i < share; ++i) parts.from[lane + i] = part.from + i * parts.width;
    const std::uint32_t mask = ((1U << share) - 1) << lane;
    for (int i = part.begin; i < part.end; ++i) {
      const int id = part_pairs[at(i)];
      const auto known = std::find_if(pass_pairs.begin(), pass_pairs.end(),
                                      [id](const auto& pair) { return pair.id == id; });
      if (known == pass_pairs.end())
        pass_pairs.push_back({id, mask});
      else
        known->lanes |= mask;
    }
  }
  return parts;
}

bool EdgeCertifier::Impl::listParts(const EdgeLanes::Parts& parts) {
  if (open_pairs.size() + lanes.open().size() * collision::kLanes > open_pairs.capacity())
    return false;
  for (int first = 0; first < collision::kLanes; first += parts.share) {
    if (!listWideOpen(parts, first)) return false;
    for (int lane = first; lane < first + parts.share; ++lane)
      if (!listLane(parts, lane, first)) return false;
  }
  return true;
}

bool EdgeCertifier::Impl::isWideOpen(const collision::LaneSweep::Open& pair, int first,
                                     int share) const {
  const std::uint32_t mask = ((1U << share) - 1) << first;
  return share > 1 && 2 * std::popcount(pair.lanes & mask) > share;
}

bool EdgeCertifier::Impl::listWideOpen(const EdgeLanes::Parts& parts, int first) {
  bool has_interval = false;
  for (const collision::LaneSweep::Open& pair : lanes.open()) {
    if (!isWideOpen(pair, first, parts.share)) continue;
    if (!has_interval && !addInterval(parts.from[first], parts.width * parts.share)) return false;
    has_interval = true;
    open_pairs.push_back(pair.id);
    intervals.back().end = static_cast<int>(open_pairs.size());
  }
  return true;
}

bool EdgeCertifier::Impl::listLane(const EdgeLanes::Parts& parts, int lane, int first) {
  // After the pass over the whole edge, listOpenLanes() has those that finer passes will not part.
  const bool is_whole_edge = parts.share == 1;
  if (part_pairs.size() + lanes.open().size() > part_pairs.capacity()) return false;
  const auto begin = static_cast<int>(part_pairs.size());
  bool has_interval = false;
  for (const collision::LaneSweep::Open& pair : lanes.open()) {
    if ((pair.lanes >> lane & 1U) == 0 || isWideOpen(pair, first, parts.share)) continue;
    if (is_whole_edge ? isForParts(pair) : pair.apart) {
      part_pairs.push_back(pair.id);
    } else if (!is_whole_edge) {
      if (!has_interval && !addInterval(parts.from[lane], parts.width)) return false;
      has_interval = true;
      open_pairs.push_back(pair.id);
      intervals.back().end = static_cast<int>(open_pairs.size());
    }
  }
  const auto end = static_cast<int>(part_pairs.size());
  if (begin == end) return true;
  if (edge_parts.size() == edge_parts.capacity()) return false;
  edge_parts.push_back({parts.from[lane], parts.width, begin, end});
  return true;
}

bool EdgeCertifier::Impl::listPartsLeft(std::size_t& next) {
  for (; next < edge_parts.size(); ++next) {
    const EdgePart& part = edge_parts[next];
    if (!addInterval(part.from, part.width) ||
        open_pairs.size() + at(part.end - part.begin) > open_pairs.capacity())
      return false;
    open_pairs.insert(open_pairs.end(), part_pairs.begin() + part.begin,
                      part_pairs.begin() + part.end);
    intervals.back().end = static_cast<int>(open_pairs.size());
  }
  return true;
}

}  // namespace leeway::planner
