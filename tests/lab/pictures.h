#pragma once

#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <nlohmann/json.hpp>
#include <string>

namespace leeway::tools::testing {

/// Whether a report with this answer drew its pictures: matplotlib may be missing.
inline bool hasPictures(const nlohmann::json& told) {
  return told["missing"].dump().find("matplotlib") == std::string::npos;
}

/// Expects a well-formed picture with at least as many panels.
inline void expectPicture(const std::string& svg, int panels_at_least) {
  tinyxml2::XMLDocument document;
  ASSERT_EQ(document.Parse(svg.c_str()), tinyxml2::XML_SUCCESS);
  int panels = 0;
  for (std::size_t at = svg.find("id=\"axes_"); at != std::string::npos;
       at = svg.find("id=\"axes_", at + 1))
    ++panels;
  EXPECT_GE(panels, panels_at_least);
}

}  // namespace leeway::tools::testing
