// A result that cannot be written is still in memory, so the program asks on a terminal for another place.
#pragma once
#include <functional>
#include <string>

namespace viewpeel::program {

// Calls `write` with the file's name. Where that fails and stdin is a terminal, it asks for another name until one
// works or the answer is empty.
//   In: may_ask: whether the program may ask; remedy: ends the message where it does not
//   Out: the file that was written    Throws: Error output, with the remedy.
std::string writeSomewhere(const std::string& file, const std::function<void(const std::string&)>& write, bool may_ask,
                           const std::string& remedy);

}  // namespace viewpeel::program
