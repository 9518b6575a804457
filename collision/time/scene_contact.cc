// The first contact of any pair of a scene.

#include <algorithm>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/scene/scene_access.h"
#include "leeway/collision/time_of_contact.h"

namespace leeway::collision {
namespace {

/// One pair of the scene, with its margin added to that of the request.
ContactResult contactOfPair(const Scene& scene, int p, std::span<const RigidMotion* const> motions,
                            ContactRequest request, Workspace& workspace) {
  const ScenePair& pair = scene.pairs()[static_cast<std::size_t>(p)];
  const Body& body_a = scene.bodies()[static_cast<std::size_t>(pair.body_a)];
  const Body& body_b = scene.bodies()[static_cast<std::size_t>(pair.body_b)];
  const Still still_a(body_a.X_WB), still_b(body_b.X_WB);
  const RigidMotion* given_a = motions[static_cast<std::size_t>(pair.body_a)];
  const RigidMotion* given_b = motions[static_cast<std::size_t>(pair.body_b)];
  const SceneGeometry of_a = SceneAccess::geometry(scene, pair.body_a, pair.geometry_a);
  const SceneGeometry of_b = SceneAccess::geometry(scene, pair.body_b, pair.geometry_b);
  const Geometry &a = of_a.geometry(), &b = of_b.geometry();
  const MountedMotion motion_a(given_a != nullptr ? *given_a : still_a, a.X_BG);
  const MountedMotion motion_b(given_b != nullptr ? *given_b : still_b, b.X_BG);
  request.margin += pair.margin;
  ContactResult result =
      timeOfContact(a.shape, motion_a, b.shape, motion_b, request, SceneAccess::scratch(workspace),
                    &SceneAccess::cache(workspace, p));
  result.pair = p;
  return result;
}

}  // namespace

ContactResult timeOfContact(const Scene& scene, std::span<const RigidMotion* const> motions,
                            const ContactRequest& request, Workspace& workspace) {
  ContactResult first;
  if (motions.size() != scene.bodies().size()) return first;
  first.status = ContactStatus::kFree;
  first.time = {kInfinity, kInfinity};
  double undecided = kInfinity;  // the earliest time from which on a pair is undecided
  int undecided_pair = -1, queries = 0;
  for (auto pair = scene.pairs().begin(); pair != scene.pairs().end(); ++pair) {
    const int p = static_cast<int>(pair.number());
    ContactRequest rest = request;
    rest.end = std::min(rest.end, first.time.upper);
    rest.query_limit = std::max(0, request.query_limit - queries);
    ContactResult result = contactOfPair(scene, p, motions, rest, workspace);
    queries += result.queries;
    if (result.status == ContactStatus::kInvalid) {
      result.queries = queries;
      return result;
    }
    if (result.status == ContactStatus::kUndecided && result.time.lower < undecided) {
      undecided = result.time.lower;
      undecided_pair = result.pair;
    }
    if (result.status == ContactStatus::kContact) {
      // Followed only to first.time.upper; the previous contact may still be the earlier one.
      const double lower = std::min(first.time.lower, result.time.lower);
      first = result;
      first.time.lower = lower;
    }
  }
  first.queries = queries;
  if (undecided < first.time.lower) {
    if (first.status != ContactStatus::kContact) {
      first.status = ContactStatus::kUndecided;
      first.pair = undecided_pair;
    }
    first.time.lower = undecided;
  }
  return first;
}

}  // namespace leeway::collision
