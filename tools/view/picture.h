#pragma once

#include <string>

#include "tools/view/subject.h"

namespace leeway::tools::view {

/// Returns three views of start, goal and the motion between them as an SVG document, for papers
/// and logs. `only_picture`: without title and texts, for an index.
std::string pictureSvg(const Subject& subject, bool only_picture = false);

/// Throws robots::InputError if the picture cannot be written: another ending than .svg, or a
/// missing folder. Needs no node.
void expectPicture(const std::string& file);

/// Escapes a user's text for an XML or HTML document.
std::string escaped(const std::string& text);

}  // namespace leeway::tools::view
