#pragma once

#include "tools/lab/base/engine.h"
#include "tools/lab/fcl/fcl_shape.h"

namespace leeway::tools::report {

/// FCL's form of a convex shape, hulls as such. Null for meshes and half-spaces (FCL answers
/// contacts with those, no distances).
lab::FclGeometry makeFclShape(const ReportShape& shape);

}  // namespace leeway::tools::report
