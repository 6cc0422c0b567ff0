// kPageText is the page without a result. The build makes it from page/ (page/build.mjs); without a page it is empty.
#pragma once
#include <string_view>

namespace viewpeel {

// The HTML has kPageGap in one place, where the result belongs.
extern const std::string_view kPageText;
constexpr std::string_view kPageGap = "<!--contents-->";

}  // namespace viewpeel
