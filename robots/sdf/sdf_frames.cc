#include "robots/sdf/sdf_frames.h"

#include <algorithm>
#include <utility>

#include "robots/urdf/urdf_document.h"

namespace leeway::robots {

namespace {

using tinyxml2::XMLElement;

constexpr std::string_view kModelFrame = "__model__";
constexpr int kNotLookedUp = -2;  // in place of a frame

}  // namespace

std::string SdfScope::whole(const std::string& name) const {
  if (name == kModelFrame) return model;
  const std::string end = "::" + std::string(kModelFrame);
  if (name.ends_with(end)) return prefix + name.substr(0, name.size() - end.size());
  return prefix + name;
}

int SdfFrames::add(SdfFrame frame) {
  const auto [entry, is_new] = by_name_.emplace(frame.name, static_cast<int>(frames_.size()));
  if (!is_new) {
    const SdfFrame& first = (*this)[entry->second];
    // SDF 1.6 and before let a joint have the name of a link.
    const bool is_joint = frame.kind == SdfFrame::Kind::kJoint;
    if (frame.kind != first.kind && (is_joint || first.kind == SdfFrame::Kind::kJoint) &&
        frame.scope.source->minor <= 6) {
      if (is_joint) {
        frame.name += "_joint_frame";
        return add(std::move(frame));
      }
      const int joint = std::exchange(entry->second, static_cast<int>(frames_.size()));
      push(std::move(frame));
      SdfFrame& renamed = frames_[static_cast<std::size_t>(joint)];
      renamed.name += "_joint_frame";
      by_name_.emplace(renamed.name, joint);
      return static_cast<int>(frames_.size()) - 1;
    }
    frame.file->fail(*frame.element, "a second " + inQuotes(frame.name) + ", the first is a <" +
                                         first.element->Name() + "> in " +
                                         lineOf(first.element->GetLineNum()) +
                                         "; names must be unique");
  }
  push(std::move(frame));
  return static_cast<int>(frames_.size()) - 1;
}

void SdfFrames::push(SdfFrame frame) {
  frames_.push_back(std::move(frame));
  bases_.push_back(kNotLookedUp);
}

int SdfFrames::find(const std::string& whole, const XmlFile& file, const XMLElement& at) const {
  const auto found = by_name_.find(whole);
  if (found != by_name_.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [name, index] : by_name_) names.push_back(name);
  const std::string nearest = suggestion(whole, names);
  file.fail(
      at,
      "<" + std::string(at.Name()) + "> names " + inQuotes(whole) + ", which is not defined; " +
          (nearest.empty() ? "the name of a link, joint, frame or nested model would be accepted"
                           : nearest));
}

int SdfFrames::baseOf(int frame) const {
  int& base = bases_[static_cast<std::size_t>(frame)];
  const SdfFrame& f = (*this)[frame];
  if (base == kNotLookedUp) base = f.base.empty() ? -1 : find(f.base, *f.file, *f.element);
  return base;
}

std::vector<int> SdfFrames::chain(int frame) const {
  std::vector<int> all;
  for (int next = frame; next >= 0; next = baseOf(next)) {
    all.push_back(next);
    if (all.size() > frames_.size()) {
      const SdfFrame& f = (*this)[frame];
      f.file->fail(*f.element, "the pose of " + inQuotes(f.name) +
                                   " leads in a circle: each frame is given in another one of the "
                                   "circle; a pose that leads to the model would be accepted");
    }
  }
  return all;
}

Pose SdfFrames::inBase(int frame) const {
  const SdfFrame& f = (*this)[frame];
  if (f.placed.empty()) return f.X_BF;
  if (const auto known = in_base_.find(frame); known != in_base_.end()) return known->second;
  const int placed = find(f.placed, *f.file, *f.element);
  const std::vector<int> way = chain(placed);
  if (std::find(way.begin(), way.end(), frame) == way.end())
    f.file->fail(*f.element, "the placement_frame " + inQuotes(f.placed) +
                                 " does not belong to the model; one of its frames would be "
                                 "accepted");
  return in_base_.emplace(frame, f.X_BF * relative(placed, frame)).first->second;
}

Pose SdfFrames::relative(int a, int b) const {
  std::vector<int> to_a = chain(a), to_b = chain(b);
  while (!to_a.empty() && !to_b.empty() && to_a.back() == to_b.back()) {
    to_a.pop_back();
    to_b.pop_back();
  }
  const auto product = [&](const std::vector<int>& frames) {
    Pose X;
    for (auto f = frames.rbegin(); f != frames.rend(); ++f)
      X = f == frames.rbegin() ? inBase(*f) : X * inBase(*f);
    return X;
  };
  if (to_a.empty()) return product(to_b);
  const Pose X_A = product(to_a).inverse();
  return to_b.empty() ? X_A : X_A * product(to_b);
}

int SdfFrames::linkOf(int frame) const {
  int next = frame;
  for (std::size_t steps = 0; steps <= frames_.size(); ++steps) {
    const SdfFrame& f = (*this)[next];
    if (f.kind == SdfFrame::Kind::kLink) return next;
    if (f.kind == SdfFrame::Kind::kModel && f.scope.is_static) return -1;
    if (f.attached_to.empty())
      f.file->fail(*f.element, "model " + inQuotes(f.name) +
                                   " has no link that its frame moves with; a <link> is needed");
    next = find(f.attached_to, *f.file, *f.element);
  }
  const SdfFrame& f = (*this)[frame];
  f.file->fail(*f.element, inQuotes(f.name) +
                               " is attached to itself by way of others; a frame that is attached "
                               "to a link would be accepted");
}

}  // namespace leeway::robots
