// A result that cannot be written is still in memory: on a terminal another place is asked for.
#pragma once
#include <functional>
#include <string>

namespace viewpeel::program {

// Calls `write` with the file's name. If that fails and a person sits at the terminal, it asks for another place until
// one takes the result, or the answer is empty.
//   In: may_ask: the program may ask; remedy: what to do where nobody is asked, after the message
//   Out: the file that was written    Throws: Error output, with the remedy.
std::string writeSomewhere(const std::string& file, const std::function<void(const std::string&)>& write, bool may_ask,
                           const std::string& remedy);

}  // namespace viewpeel::program
