// Where OpenImageIO is linked there is nothing to open: the libraries, the Python module, the
// tests.

#include "pictures/ahead.h"

namespace fumarole::pictures {

void open_ahead() {}

AtEnd::~AtEnd() = default;

}  // namespace fumarole::pictures
