#include "tools/lab/motion/family_maker.h"

#include <algorithm>
#include <cmath>

namespace leeway::tools::report::motion_families {

void FamilyMaker::keep(const Body& a, Move move_a, const Body& b, Move move_b, Known known) {
  Pose X_WF = placed(sizes(random, -1, 1));
  X_WF.rotation = random.rotation();
  ContactCase c;
  std::array<SlowBody, 2> slow;
  const std::array<std::pair<Body, Move*>, 2> both = {{{a, &move_a}, {b, &move_b}}};
  for (std::size_t i = 0; i < 2; ++i) {
    Move& m = *both[i].second;
    m.start = X_WF * m.start;
    m.travel = X_WF.rotation * m.travel;
    m.axis = (X_WF.rotation * m.axis).normalized();
    const bool still = m.angle == 0 && m.travel.isZero(0);
    std::shared_ptr<const collision::RigidMotion> motion;
    if (still)
      motion = std::make_shared<collision::Still>(m.start);
    else
      motion = std::make_shared<collision::StraightMotion>(m.start, m.at(1));
    c.spec.bodies.push_back({both[i].first.shape, motion, true});
    slow[i] = {both[i].first.slow, [m](double t) { return m.at(t); },
               m.travel.norm() + std::abs(m.angle) * both[i].first.slow->reach};
  }
  c.spec.pairs = {{0, 1}};
  TimeTruth truth{false, 1, 1, true};
  if (known != Known::kFree) truth = slowFirstContact(slow, c.spec.pairs, 0);
  if (known == Known::kApartAtStart && truth.contact && truth.upper == 0) return;
  keep(std::move(c), truth);
}

}  // namespace leeway::tools::report::motion_families
