#pragma once

#include <stdexcept>

#include <fumarole/export.h>

namespace fumarole {

/// What the world did wrong: a file, an option, a scene, a GL that is too old. The message names
/// the file and the place, says what is wrong and what to do about it, in one line. Mistakes of the
/// programmer are asserts, and "not there, which is normal" is a std::optional.
class FUMAROLE_API Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace fumarole
