#pragma once
#include <viewpeel/ids.h>
#include "ranks/message.h"

namespace viewpeel {

// Ids in a message have no names, which only results need.
void putIds(MessageWriter& out, const Ids& ids);
Ids getIds(MessageReader& in);

}  // namespace viewpeel
