#include "collision/mesh/descent/box_gaps.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/mesh/descent/box_gaps_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "collision/base/dispatch.h"
#include "collision/base/tolerances.h"

// clang-format off
// Rounding, with u = 2^-24, T the vector between the centres and S = |T|_1 + sum of both boxes' halves:
//
//   the query's axes, turned in single precision, err by 5 u a component,
//     which moves its points by                                                 9 u |h|_1
//   the dual basis of axes orthonormal to 2^-21 differs from them by 2^-20     16 u a half
//   sums of up to 10 products                                                  12 u S
//   lengths of axes and of the vector of three gaps                             8 u |T|
//
// In sum less than 48 u S. Along the direction, whose length a rotation's departure may take 1e-6
// from 1, the last is 19 u |T|: less than 60 u S. The query's centre was rounded once: u |center| for
// each coordinate.
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The moving side; for kNothing, `sweep` is not read.
enum class Moves { kNothing, kQuery, kNode };

template <Moves kMoves>
HWY_ATTR void gapsOf(const BoxNode& node, const OrientedBox& q, const float* direction,
                     const BoxSweep* sweep, float* out) {
  const hn::CappedTag<float, BoxNode::kWidth> d;
  using V = hn::Vec<decltype(d)>;
  const auto set = [&](float x) HWY_ATTR { return hn::Set(d, x); };
  const float center_size = std::abs(q.center[0]) + std::abs(q.center[1]) + std::abs(q.center[2]);
  float fixed =
      kBoxRounding * (q.half[0] + q.half[1] + q.half[2]) + kBoxCenterRounding * center_size;
  if (kMoves != Moves::kNothing) fixed += sweep->fixed;
  float query_reach = 0;
  for (int k = 0; k < 3; ++k)
    query_reach += q.half[k] * std::abs(q.axis[k][0] * direction[0] + q.axis[k][1] * direction[1] +
                                        q.axis[k][2] * direction[2]);
  for (std::size_t column = 0; column < BoxNode::kWidth; column += hn::Lanes(d)) {
    V cx = hn::Load(d, node.center[0] + column), cy = hn::Load(d, node.center[1] + column),
      cz = hn::Load(d, node.center[2] + column);
    V wx = hn::Zero(d), wy = wx, wz = wx;
    if (kMoves == Moves::kQuery) {
      wx = set(sweep->way[0]);
      wy = set(sweep->way[1]);
      wz = set(sweep->way[2]);
    } else if (kMoves == Moves::kNode) {
      const auto row = [&](const float* m) HWY_ATTR {
        return hn::Add(hn::Add(hn::Mul(set(m[0]), cx), hn::Mul(set(m[1]), cy)),
                       hn::Mul(set(m[2]), cz));
      };
      wx = hn::Add(row(sweep->turn), set(sweep->way[0]));
      wy = hn::Add(row(sweep->turn + 3), set(sweep->way[1]));
      wz = hn::Add(row(sweep->turn + 6), set(sweep->way[2]));
      const V x = row(sweep->map), y = row(sweep->map + 3), z = row(sweep->map + 6);
      cx = x;
      cy = y;
      cz = z;
    }
    const V tx = hn::Sub(cx, set(q.center[0])), ty = hn::Sub(cy, set(q.center[1])),
            tz = hn::Sub(cz, set(q.center[2]));
    const V g0 = hn::Load(d, node.half[0] + column), g1 = hn::Load(d, node.half[1] + column),
            g2 = hn::Load(d, node.half[2] + column);
    V size = hn::Add(hn::Add(hn::Add(hn::Abs(tx), hn::Abs(ty)), hn::Abs(tz)),
                     hn::Add(hn::Add(g0, g1), g2));
    if (kMoves != Moves::kNothing)
      size = hn::Add(size, hn::Add(hn::Add(hn::Abs(wx), hn::Abs(wy)), hn::Abs(wz)));
    V slack = hn::Add(hn::Mul(set(kBoxRounding), size), set(fixed));
    if (kMoves == Moves::kNode)
      slack = hn::Add(slack, hn::Mul(set(sweep->loose), hn::Load(d, node.radius + column)));
    // The reach of both boxes along the node's axes.
    V reach0 = g0, reach1 = g1, reach2 = g2;
    V gap_q[3];
    // The gap along the line of the centres, times |T|.
    const V squared = hn::Add(hn::Add(hn::Mul(tx, tx), hn::Mul(ty, ty)), hn::Mul(tz, tz));
    V along = squared;
    const V v00 = hn::Load(d, node.axis[0][0] + column),
            v01 = hn::Load(d, node.axis[0][1] + column),
            v02 = hn::Load(d, node.axis[0][2] + column),
            v10 = hn::Load(d, node.axis[1][0] + column),
            v11 = hn::Load(d, node.axis[1][1] + column),
            v12 = hn::Load(d, node.axis[1][2] + column),
            v20 = hn::Load(d, node.axis[2][0] + column),
            v21 = hn::Load(d, node.axis[2][1] + column),
            v22 = hn::Load(d, node.axis[2][2] + column);
    const auto dot = [](V ax, V ay, V az, V bx, V by, V bz) HWY_ATTR {
      return hn::Abs(hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz)));
    };
    for (int k = 0; k < 3; ++k) {
      const V ux = set(q.axis[k][0]), uy = set(q.axis[k][1]), uz = set(q.axis[k][2]);
      const V c0 = dot(ux, uy, uz, v00, v01, v02), c1 = dot(ux, uy, uz, v10, v11, v12),
              c2 = dot(ux, uy, uz, v20, v21, v22);
      const V h = set(q.half[k]);
      reach0 = hn::Add(reach0, hn::Mul(c0, h));
      reach1 = hn::Add(reach1, hn::Mul(c1, h));
      reach2 = hn::Add(reach2, hn::Mul(c2, h));
      V reach = hn::Add(hn::Add(hn::Mul(c0, g0), hn::Mul(c1, g1)), hn::Add(hn::Mul(c2, g2), h));
      if (kMoves != Moves::kNothing) reach = hn::Add(reach, dot(ux, uy, uz, wx, wy, wz));
      const V part = dot(ux, uy, uz, tx, ty, tz);
      along = hn::Sub(along, hn::Mul(h, part));
      gap_q[k] = hn::Sub(part, reach);
    }
    const V part0 = dot(v00, v01, v02, tx, ty, tz), part1 = dot(v10, v11, v12, tx, ty, tz),
            part2 = dot(v20, v21, v22, tx, ty, tz);
    if (kMoves != Moves::kNothing) {
      reach0 = hn::Add(reach0, dot(v00, v01, v02, wx, wy, wz));
      reach1 = hn::Add(reach1, dot(v10, v11, v12, wx, wy, wz));
      reach2 = hn::Add(reach2, dot(v20, v21, v22, wx, wy, wz));
      along = hn::Sub(along, dot(tx, ty, tz, wx, wy, wz));
    }
    const V gap_n0 = hn::Sub(part0, reach0), gap_n1 = hn::Sub(part1, reach1),
            gap_n2 = hn::Sub(part2, reach2);
    along = hn::Sub(along,
                    hn::Add(hn::Add(hn::Mul(part0, g0), hn::Mul(part1, g1)), hn::Mul(part2, g2)));
    const V nx = set(direction[0]), ny = set(direction[1]), nz = set(direction[2]);
    V reach_n = hn::Add(hn::Add(hn::Mul(dot(nx, ny, nz, v00, v01, v02), g0),
                                hn::Mul(dot(nx, ny, nz, v10, v11, v12), g1)),
                        hn::Add(hn::Mul(dot(nx, ny, nz, v20, v21, v22), g2), set(query_reach)));
    if (kMoves != Moves::kNothing) reach_n = hn::Add(reach_n, dot(nx, ny, nz, wx, wy, wz));
    const V gap_n = hn::Sub(dot(nx, ny, nz, tx, ty, tz), reach_n);
    const V zero = hn::Zero(d);
    const auto square = [&](V a, V b, V c) HWY_ATTR {
      const V pa = hn::Max(a, zero), pb = hn::Max(b, zero), pc = hn::Max(c, zero);
      return hn::Add(hn::Add(hn::Mul(pa, pa), hn::Mul(pb, pb)), hn::Mul(pc, pc));
    };
    const V across = hn::Max(
        hn::Sqrt(hn::Max(square(gap_q[0], gap_q[1], gap_q[2]), square(gap_n0, gap_n1, gap_n2))),
        // (Not 0 where the centres coincide.)
        hn::Max(gap_n, hn::Div(along, hn::Max(hn::Sqrt(squared), set(1e-18F)))));
    const V deepest = hn::Max(hn::Max(hn::Max(gap_q[0], gap_q[1]), gap_q[2]),
                              hn::Max(hn::Max(gap_n0, gap_n1), gap_n2));
    hn::StoreU(hn::Sub(hn::IfThenElse(hn::Gt(across, zero), across, deepest), slack), d,
               out + column);
  }
}

HWY_ATTR void gaps(const BoxNode& node, const OrientedBox& q, const float* direction, float* out) {
  gapsOf<Moves::kNothing>(node, q, direction, nullptr, out);
}

HWY_ATTR void sweptGaps(const BoxNode& node, const OrientedBox& q, const BoxSweep& sweep,
                        const float* direction, float* out) {
  if (sweep.of_node)
    gapsOf<Moves::kNode>(node, q, direction, &sweep, out);
  else
    gapsOf<Moves::kQuery>(node, q, direction, &sweep, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(gaps);
HWY_EXPORT(sweptGaps);

void boxGaps(const BoxNode& node, const OrientedBox& query, const BoxDirection& direction,
             float* gap) {
  LEEWAY_DISPATCH(gaps)(node, query, direction.data(), gap);
}

void sweptBoxGaps(const BoxNode& node, const OrientedBox& query, const BoxSweep& sweep,
                  const BoxDirection& direction, float* gap) {
  LEEWAY_DISPATCH(sweptGaps)(node, query, sweep, direction.data(), gap);
}

}  // namespace leeway::collision
#endif
