#include <array>

#include "collision/base/rounding.h"
#include "collision/deform/query/descent_state.h"
#include "collision/deform/query/float_box.h"
#include "collision/mesh/descent/branch_and_bound.h"

namespace leeway::collision {

namespace {

// A node or a leaf (as in DeformTree::Node), or the whole of a rigid B.
struct Part {
  std::int32_t ref;
  FloatBox box;  // in the body's frame
};

struct PartPair {
  Part a, b;
  double lower;  // proven for everything below
};

double sizeOf(const FloatBox& box) { return (highOf(box) - lowOf(box)).norm(); }

class PairDescent {
 public:
  explicit PairDescent(DescentState& state) : state_(state), a_(state.a), b_(state.b) {}

  void run(double root) {
    open_.push({{0, floatBox(a_.low, a_.high)}, {0, floatBox(b_.low, b_.high)}, root});
    for (PartPair pair; open_.next(state_, pair);) {
      expand(pair);
      // Some of the pair's pieces may not have been compared.
      if (state_.isDone()) state_.settle(pair);
    }
    open_.settleRest(state_);
  }

 private:
  static bool isLeaf(const DeformSide& side, const Part& part) {
    return isRigid(side) || DeformTree::isLeaf(part.ref);
  }

  Probe probeOf(const Part& part) const {
    return state_.probeOf(lowOf(part.box), highOf(part.box), state_.placement.growth);
  }

  // Splits the larger part; compares leaves.
  void expand(const PartPair& pair) {
    const bool leaf_a = isLeaf(a_, pair.a), leaf_b = isLeaf(b_, pair.b);
    state_.visit();
    if (leaf_a && leaf_b) {
      compareLeaves(pair);
    } else if (leaf_a || (!leaf_b && sizeOf(pair.b.box) >= sizeOf(pair.a.box))) {
      splitB(pair);
    } else {
      splitA(pair);
    }
  }

  void splitB(const PartPair& pair) {
    WideBox room;
    const WideBox& box = state_.boxes_b.boxes(pair.b.ref, room);
    const WideBox* const boxes = &box;
    WideBounds bounds;
    const Probe probe = probeOf(pair.a);
    state_.kernels.childBounds(probe, *b_.snapshot->tree, b_.snapshot->vertices.data(),
                               {&pair.b.ref, 1}, &boxes, roundedUpToFloat(state_.bar()), &bounds);
    state_.tighten(pair.b.ref, probe, bounds);
    const DeformTree::Node& node = b_.snapshot->tree->node(pair.b.ref);
    const std::size_t first = open_.size();
    for (int column = 0; column < kWidth && node.child[column] != DeformTree::kNone; ++column) {
      const double lower = std::max(pair.lower, static_cast<double>(bounds.lower[column]));
      open_.pushSibling(state_, first,
                        {pair.a, {node.child[column], floatBox(box, column)}, lower});
    }
  }

  void splitA(const PartPair& pair) {
    WideBox room;
    const WideBox& box = state_.boxes_a.boxes(pair.a.ref, room);
    const DeformTree::Node& node = a_.snapshot->tree->node(pair.a.ref);
    const std::size_t first = open_.size();
    for (int column = 0; column < kWidth && node.child[column] != DeformTree::kNone; ++column) {
      const Part part{node.child[column], floatBox(box, column)};
      const double lower = lowerBound(probeOf(part), pair.b.box.low, pair.b.box.high);
      open_.pushSibling(state_, first, {part, pair.b, std::max(pair.lower, lower)});
    }
  }

  void compareLeaves(const PartPair& pair) {
    const DeformTree& tree_a = *a_.snapshot->tree;
    const DeformTree::Leaf& leaf_a = tree_a.leaf(DeformTree::leafOf(pair.a.ref));
    int begin_b = kWholeBody, end_b = kWholeBody + 1;
    if (!isRigid(b_)) {
      const DeformTree::Leaf& leaf_b = b_.snapshot->tree->leaf(DeformTree::leafOf(pair.b.ref));
      begin_b = leaf_b.slot_begin;
      end_b = leaf_b.slot_end;
    }
    WideBox box_a;
    deformKernels().triangles(tree_a, a_.snapshot->vertices.data(), leaf_a.slot_begin,
                              leaf_a.slot_end, box_a);
    for (int slot_a = leaf_a.slot_begin; slot_a < leaf_a.slot_end; ++slot_a) {
      const Part part{pair.a.ref, floatBox(box_a, slot_a - leaf_a.slot_begin)};
      WideBounds bounds;
      if (isRigid(b_)) {
        bounds.lower[0] = -std::numeric_limits<float>::infinity();  // B may be unbounded
      } else {
        state_.kernels.triangleBounds(probeOf(part), *b_.snapshot->tree,
                                      b_.snapshot->vertices.data(), begin_b, end_b, bounds);
      }
      state_.compareWithLeaf(slot_a, begin_b, end_b, pair.lower, bounds);
      if (state_.isDone()) return;
    }
  }

  DescentState& state_;
  const DeformSide& a_;
  const DeformSide& b_;
  // Every pair that is popped pushes at most eight, which are one level deeper on one side.
  BranchAndBound<PartPair, (kWidth - 1) * (2 * DeformTree::kMaxDepth) + kWidth> open_;
};

}  // namespace

void descendPairs(DescentState& state, double root) { PairDescent(state).run(root); }

}  // namespace leeway::collision
