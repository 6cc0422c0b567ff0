// The page's own text, which the build makes of page/ (page/build.mjs), or which is empty.
#pragma once
#include <string_view>

namespace viewpeel {

// The page of HTML; kPageGap stands once in it, where the contents belong.
extern const std::string_view kPageText;
constexpr std::string_view kPageGap = "<!--contents-->";

}  // namespace viewpeel
