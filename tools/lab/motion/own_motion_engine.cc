#include "tools/lab/motion/own_motion_engine.h"

#include <algorithm>
#include <limits>

#include "collision/base/numbers.h"

namespace leeway::tools::report {
namespace {

using collision::ContactRequest;
using collision::ContactResult;
using collision::ContactStatus;
using collision::Scratch;

Scratch& scratch() {
  thread_local Scratch instance;
  return instance;
}

ContactAnswer answerOf(const ContactResult& result) {
  // A rejected input is not free.
  if (result.status == ContactStatus::kInvalid) return {false, true, 0, kInfinity};
  return {result.status == ContactStatus::kContact, result.status == ContactStatus::kUndecided,
          result.time.lower, result.time.upper};
}

class OwnQuery : public ContactQuery {
 public:
  explicit OwnQuery(const ContactSpec& spec) : spec_(spec) { request_.margin = spec.margin; }

  ContactAnswer ask() override {
    if (!spec_.triangles.empty())
      return answerOf(timeOfContact(spec_.triangles[0], spec_.triangles[1], request_, scratch()));
    // Later pairs are followed up to the first contact found; with nearly simultaneous contacts,
    // either may be first.
    ContactRequest request = request_;
    ContactAnswer first, open;
    for (const auto& pair : spec_.pairs) {
      const MovingBody &a = spec_.bodies[pair[0]], &b = spec_.bodies[pair[1]];
      const ContactResult result =
          timeOfContact(a.shape->shape, *a.motion, b.shape->shape, *b.motion, request, scratch());
      if (result.status == ContactStatus::kContact) {
        const double lower = first.contact ? first.lower : kInfinity;
        first = answerOf(result);
        first.lower = std::min(first.lower, lower);
        request.end = result.time.upper;
      } else if (result.status != ContactStatus::kFree) {
        const ContactAnswer answer = answerOf(result);
        if (!open.undecided || answer.lower < open.lower) open = answer;
      }
    }
    return open.undecided && (!first.contact || open.lower < first.lower) ? open : first;
  }

 private:
  ContactSpec spec_;
  ContactRequest request_;
};

class OwnEngine : public ContactEngine {
 public:
  const char* name() const override { return "leeway"; }
  bool claimsBounds() const override { return true; }
  std::unique_ptr<ContactQuery> prepare(const ContactSpec& spec) const override {
    return std::make_unique<OwnQuery>(spec);
  }
};

}  // namespace

std::vector<std::unique_ptr<ContactEngine>> makeOwnMotionEngines() {
  std::vector<std::unique_ptr<ContactEngine>> engines;
  engines.push_back(std::make_unique<OwnEngine>());
  return engines;
}

}  // namespace leeway::tools::report
