#include "planner/contact/contact_slide.h"

#include <algorithm>
#include <cmath>

#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {

ContactSlide::ContactSlide(EdgeCertifier& certifier, const Edge& check, double range)
    : certifier_(certifier),
      scene_(certifier.scene()),
      space_(scene_.space()),
      check_(check),
      range_(range),
      gradients_(scene_),
      workspace_(scene_.scene()),
      inverse_(space_.variables().size()),
      q_(scene_.model().variables.size()),
      X_WL_(scene_.model().links.size()) {
  for (const ConfigurationSpace::Part& part : space_.parts())
    for (int k = 0; k < (part.kind == ConfigurationSpace::Kind::kRotation ? 3 : 1); ++k) {
      const int i = part.first + k;
      inverse_[static_cast<std::size_t>(i)] = 1 / (part.weight * part.weight);
    }
  for (std::vector<double>* point : {&at_, &next_, &place_, &step_, &moved_})
    point->resize(inverse_.size());
}

/// The nearest step that approaches no contact more than allowed: Hildreth's method, one sweep over
/// the contacts at a time.
void ContactSlide::project(std::span<double> step) const {
  double multiplier[kSlideContacts] = {};
  for (int sweep = 0; sweep < kSlideSweeps; ++sweep)
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const Contact& contact = contacts_[c];
      double change = contact.least, squared = 0;
      for (std::size_t i = 0; i < step.size(); ++i) {
        change -= contact.gradient[i] * step[i];
        squared += contact.gradient[i] * contact.gradient[i] * inverse_[i];
      }
      change = std::max(change / squared, -multiplier[c]);
      multiplier[c] += change;
      for (std::size_t i = 0; i < step.size(); ++i)
        step[i] += change * contact.gradient[i] * inverse_[i];
    }
}

template <class IsFree>
void ContactSlide::placeBefore(std::span<const double> from, std::span<const double> to, double t,
                               const IsFree& is_free) {
  double free = 0, met = t;
  for (int i = 0; i < kSlideHalvings; ++i) {
    const double middle = (free + met) / 2;
    space_.interpolate(from, to, middle, place_);
    (is_free() ? free : met) = middle;
  }
  space_.interpolate(from, to, free, place_);
}

collision::DistanceResult ContactSlide::distanceOf(int pair,
                                                   const collision::DistanceRequest& request) {
  const collision::ScenePair of = scene_.scene().pairs()[static_cast<std::size_t>(pair)];
  const int links[] = {scene_.bodyLink(of.body_a), scene_.bodyLink(of.body_b)};
  robots::findChain(scene_.model(), links, chain_);
  scene_.expand(place_, q_);
  robots::chainKinematics(scene_.model(), q_, chain_, X_WL_);
  for (const int body : {of.body_a, of.body_b}) {
    const int link = scene_.bodyLink(body);
    if (link >= 0) workspace_.setPose(body, X_WL_[static_cast<std::size_t>(link)]);
  }
  return collision::pairDistance(scene_.scene(), workspace_, pair, request);
}

EdgeClearance ContactSlide::nearestOfPair(std::span<const double> from, std::span<const double> to,
                                          double t, int pair) {
  const double margin = scene_.scene().pairs()[static_cast<std::size_t>(pair)].margin;
  collision::DistanceRequest request;
  request.threshold = margin;
  request.depth = margin < 0;
  placeBefore(from, to, t, [&] { return distanceOf(pair, request).distance.lower > margin; });
  EdgeClearance found;
  found.pair = pair;
  request = {};
  request.tolerance = kClearanceTolerance;
  found.closest = distanceOf(pair, request);
  found.clearance = found.closest.distance;
  return found;
}

EdgeClearance ContactSlide::nearestBefore(std::span<const double> from, std::span<const double> to,
                                          double t) {
  placeBefore(from, to, t, [&] { return certifier_.decide(place_) == Verdict::kFree; });
  const StateCheck state = certifier_.clearance(place_, kClearanceTolerance);
  EdgeClearance found;
  found.clearance = state.clearance;
  found.pair = state.pair;
  found.closest = state.closest;
  return found;
}

/// Adds the contact between two points, at the place of `check`; false if its gradient is unknown.
bool ContactSlide::meet(std::span<const double> from, std::span<const double> to,
                        const EdgeCheck& check) {
  // The pair of an undecided check may not be in contact.
  const bool is_known = check.verdict == Verdict::kNotFree && check.pair >= 0;
  const EdgeClearance found =
      is_known ? nearestOfPair(from, to, check.t, check.pair) : nearestBefore(from, to, check.t);
  if (found.pair < 0) return false;
  const std::span<const double> gradient = gradients_.find(place_, found, scene_);
  double squared = 0;
  for (std::size_t i = 0; i < gradient.size(); ++i)
    squared += gradient[i] * gradient[i] * inverse_[i];
  if (!(squared > kLeastPushGradient)) return false;
  const double room =
      found.clearance.upper - scene_.scene().pairs()[static_cast<std::size_t>(found.pair)].margin;
  contacts_.push_back({{gradient.begin(), gradient.end()}, kSlideRoom * range_ - room});
  Contact& contact = contacts_.back();
  space_.difference(from, place_, moved_);
  for (std::size_t i = 0; i < moved_.size(); ++i) contact.least += contact.gradient[i] * moved_[i];
  return true;
}

void ContactSlide::slide(std::span<const double> from, std::span<const double> target,
                         std::vector<double>& points) {
  at_.assign(from.begin(), from.end());
  contacts_.clear();
  double left = space_.distance(at_, target), length = range_;
  int misses = 0;
  std::size_t old = 0;  // contacts from earlier places
  for (int edges = 0; edges < kSlideEdges && left > 0 && misses < kSlideMisses; ++edges) {
    space_.difference(at_, target, step_);
    for (double& s : step_) s *= std::min(1.0, length / left);
    project(step_);
    space_.advance(at_, step_, 1, next_);
    for (const ConfigurationSpace::Part& part : space_.parts())
      if (part.kind == ConfigurationSpace::Kind::kLine) {
        double& x = next_[static_cast<std::size_t>(part.first)];
        x = std::clamp(x, space_.lower(part.first), space_.upper(part.first));
      }
    // Measured between the points, because limits shorten some steps.
    const double next_left = space_.distance(next_, target);
    if (!(left - next_left > kSlideGain * std::min(length, left))) {
      // A contact from an earlier place may no longer be in the way.
      if (old == 0) return;
      contacts_.erase(contacts_.begin(), contacts_.begin() + static_cast<std::ptrdiff_t>(old));
      old = 0;
      continue;
    }
    const EdgeCheck check = check_(at_, next_);
    if (check.verdict == Verdict::kFree) {
      space_.difference(at_, next_, step_);
      for (Contact& contact : contacts_)
        for (std::size_t i = 0; i < step_.size(); ++i)
          contact.least -= contact.gradient[i] * step_[i];
      at_ = next_;
      left = next_left;
      points.insert(points.end(), at_.begin(), at_.end());
      misses = 0;
      old = contacts_.size();
      length = std::min(2 * length, range_);
      continue;
    }
    ++misses;
    length /= 2;
    if (contacts_.size() == kSlideContacts) {
      contacts_.erase(contacts_.begin());
      old -= old > 0;
    }
    if (!meet(at_, next_, check)) return;
  }
}

}  // namespace leeway::planner
