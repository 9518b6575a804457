#pragma once

#include <string>

#include "robots/load/visual_shapes.h"
#include "tools/view/subject.h"

namespace leeway::tools::view {

/// Returns an HTML document that needs no other files. `compared`: another path of the same
/// problem, shown beside the first; null: none. `visuals`: of the robot, drawn over what is
/// checked; null: none. The library must have the page (see expectPage()).
std::string page(const Subject& subject, const Subject* compared = nullptr,
                 const robots::VisualShapes* visuals = nullptr);

/// Throws robots::InputError if the page cannot be written: another ending than .html, a missing
/// folder, or a library that was built without node. Callers call it before their work.
void expectPage(const std::string& file);

}  // namespace leeway::tools::view
