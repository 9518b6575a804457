#include "collision/simd/hull_scan.h"

#include "collision/hull_support.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/simd/hull_scan.cc"
#include "collision/simd/targets.h"
//
#include <hwy/foreach_target.h>
//
#include "collision/simd/scan-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {

int scanHull(const HullSupport& support, const Vector& d) {
  return scanColumns(support.x(), support.y(), support.z(), support.length(), d.x(), d.y(), d.z());
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(scanHull);

int scanFarthest(const HullSupport& support, const Vector& direction) {
  return HWY_DYNAMIC_DISPATCH(scanHull)(support, direction);
}

}  // namespace leeway::collision
#endif
