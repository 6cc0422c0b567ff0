// Stands in for the page where it is not built.
#include "report/page_text.h"

namespace viewpeel {

const std::string_view kPageText = "";

}  // namespace viewpeel
