#include <memory>
#include <string>
#include <utility>

#include "collision/deform/motion/blended_motion.h"
#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {

std::shared_ptr<const VertexMotion> VertexMotion::morph(MorphMotion motion) {
  MotionSource source = motion;
  constexpr MotionKind kKind = MotionKind::kMorph;
  if (motion.references.empty()) refuse(kKind, "no references; at least 1 is needed");
  const std::size_t vertex_count = motion.references[0].size();
  requireVertices(kKind, vertex_count);
  for (std::size_t k = 0; k < motion.references.size(); ++k) {
    const std::string name = "reference " + std::to_string(k);
    requireCount(kKind, name, motion.references[k].size(), vertex_count, "vertices");
    requireUsable(kKind, name + ", vertex", motion.references[k]);
  }
  std::vector<double> times = timesOf(motion.keys);
  requireKeys(kKind, times);
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < motion.keys.size(); ++i) {
    requireRow(kKind, i, motion.keys[i].weights, motion.references.size(), "weight");
    rows.push_back(std::move(motion.keys[i].weights));
  }
  return withSource(std::make_shared<BlendedMotion>(
                        kKind, BlendedMotion::Field{}, std::move(motion.references),
                        KeyTrack(std::move(times), motion.interpolation), std::move(rows)),
                    std::move(source));
}

}  // namespace leeway::collision
