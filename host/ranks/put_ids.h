#pragma once
#include <viewpeel/ids.h>
#include "ranks/message.h"

namespace viewpeel {

// These write and read ids as a part of a message. Names are left out, because only results need them.
void putIds(MessageWriter& out, const Ids& ids);
Ids getIds(MessageReader& in);

}  // namespace viewpeel
