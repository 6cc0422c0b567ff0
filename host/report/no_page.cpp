// This file takes the place of the page where the build has none (VIEWPEEL_BUILD_REPORT off): the text is empty.
#include "report/page_text.h"

namespace viewpeel {

const std::string_view kPageText = "";

}  // namespace viewpeel
