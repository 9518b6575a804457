#include "collision/deform/tree/tree_fit.h"

#include <algorithm>

#include "collision/base/numbers.h"

namespace leeway::collision {
namespace {

float halfArea(float x, float y, float z) { return x * y + y * z + z * x; }

// Half the surface areas of the children, summed, and of the box around them.
struct Areas {
  float children = 0, whole = 0;
};

Areas areasOf(const WideBox& box) {
  Areas areas;
  float low[3], high[3];
  for (int k = 0; k < 3; ++k) {
    low[k] = *std::min_element(box.low[k], box.low[k] + kWidth);
    high[k] = *std::max_element(box.high[k], box.high[k] + kWidth);
  }
  areas.whole = halfArea(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  for (int column = 0; column < kWidth; ++column) {
    if (!(box.low[0][column] <= box.high[0][column])) break;  // empty columns are last
    areas.children +=
        halfArea(box.high[0][column] - box.low[0][column], box.high[1][column] - box.low[1][column],
                 box.high[2][column] - box.low[2][column]);
  }
  return areas;
}

}  // namespace

void measureFit(const DeformTree& tree, std::span<const WideBox> boxes, std::vector<float>& fit) {
  fit.resize(tree.nodes().size());
  for (std::size_t i = 0; i < fit.size(); ++i) {
    const Areas areas = areasOf(boxes[i]);
    fit[i] = areas.whole > 0 ? areas.children / areas.whole : 0;
  }
}

double surfaceCost(std::span<const WideBox> boxes, std::int32_t count) {
  double children = 0;
  for (std::int32_t i = 0; i < count; ++i)
    children += static_cast<double>(areasOf(boxes[at(i)]).children);
  const auto whole = static_cast<double>(areasOf(boxes[0]).whole);
  return whole > 0 ? children / whole : 0;
}

void findDecayed(const DeformTree& tree, std::span<const float> fit, std::span<const float> before,
                 double factor, std::vector<std::int32_t>& roots) {
  roots.clear();
  std::vector<std::int32_t> stack{0};
  while (!stack.empty()) {
    const std::int32_t id = stack.back();
    stack.pop_back();
    if (static_cast<double>(fit[at(id)]) > factor * static_cast<double>(before[at(id)])) {
      roots.push_back(id);
      continue;
    }
    for (const std::int32_t child : tree.node(id).child) {
      if (child >= 0) stack.push_back(child);
    }
  }
}

}  // namespace leeway::collision
