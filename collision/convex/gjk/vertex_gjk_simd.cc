#include <cmath>

#include "collision/convex/gjk/vertex_gjk.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/convex/gjk/vertex_gjk_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
//
#include "collision/base/dispatch.h"
#include "collision/base/tolerances.h"
#include "collision/convex/gjk/vertex_cores-inl.h"
#include "collision/convex/gjk/vertex_search-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {
namespace {

// Passes on the end of a search; the simplex is empty if there is none.
HWY_INLINE void leave(const Search<PlacedCores>& search, const PlacedCores& cores, GjkEnd end,
                      Progress& progress, Simplex& simplex) {
  Carriers found;
  offerPlane(search, end, progress, found);
  Triple w = {0, 0, 0}, a = {0, 0, 0};
  for (int i = 0; i < found.count; ++i) {
    const Triple &here_w = found.w[i], here_a = cores.pointOfA(found.indices[i]);
    SupportPoint& s = simplex.points[simplex.slot[i]];
    s.w = Vector(here_w.x, here_w.y, here_w.z);
    s.a = Vector(here_a.x, here_a.y, here_a.z);
    s.index_a = found.indices[i].a;
    s.index_b = found.indices[i].b;
    s.placement = 0;
    simplex.lambda[i] = found.weight[i];
    w = w + found.weight[i] * here_w;
    a = a + found.weight[i] * here_a;
  }
  simplex.count = found.count;
  if (end == GjkEnd::kInside) {  // (A polytope will find a better witness.)
    const SupportPoint& s = simplex.points[simplex.slot[0]];
    progress.offerWitness(s.w.norm(), s.w, s.a);
  } else if (found.count > 0) {
    simplex.nearest = Vector(w.x, w.y, w.z);
    simplex.norm_squared = squared(w);
    progress.offerWitness(std::sqrt(simplex.norm_squared), simplex.nearest, Vector(a.x, a.y, a.z));
  }
}

}  // namespace

GjkEnd vertexSteps(Difference<false>& difference, const Vector& direction, Progress& progress,
                   const PairCache* carried, Simplex& simplex) {
  const CoreQuery& query = progress.query();
  const PlacedCores cores(difference, carried == nullptr);
  Search<PlacedCores> search(cores, query.request, query.lower_offset, query.upper_offset,
                             progress.iterations);
  const GjkEnd end =
      search.run(tripleOf(direction), carried, {difference.hintA(), difference.hintB()});
  difference.setHints(search.lastIndices().a, search.lastIndices().b);
  leave(search, cores, end, progress, simplex);
  if (end == GjkEnd::kInside) return end;
  return simplex.count > 0 && progress.enough() ? GjkEnd::kEnough : end;
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(vertexSteps);

bool fits(const Difference<false>& difference, const PairCache& cache) {
  return fits(cache, vertexCount(difference.viewA()), vertexCount(difference.viewB()));
}

GjkEnd runVertexGjk(Difference<false>& difference, const Vector& direction,
                    const PairCache* carried, Progress& progress, Simplex& simplex) {
  if (progress.iterations >= progress.query().request.iteration_limit) return GjkEnd::kLimit;
  const GjkEnd end =
      LEEWAY_DISPATCH(vertexSteps)(difference, direction, progress, carried, simplex);
  if (end == GjkEnd::kStagnated && simplex.count > 0) reduceAll(simplex, simplex.count);
  return end;
}

}  // namespace leeway::collision
#endif
