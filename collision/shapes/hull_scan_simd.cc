#include "collision/shapes/hull_scan.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/shapes/hull_scan_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
//
#include "collision/base/dispatch.h"
#include "collision/shapes/hull_scan-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

int scanHull(const HullSupport& support, const Vector& d, int& hint) {
  return scanSupport(support, d.x(), d.y(), d.z(), hint);
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(scanHull);

int scanFarthest(const HullSupport& support, const Vector& direction, int& hint) {
  return LEEWAY_DISPATCH(scanHull)(support, direction, hint);
}

}  // namespace leeway::collision
#endif
