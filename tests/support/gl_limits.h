#pragma once

#include <string>
#include <vector>

#include <fumarole/gl.h>

namespace fumarole::test {

/// The functions of a context, but glLinkProgram looks at what each program that links takes: more
/// than OpenGL 4.5 promises of every driver goes into `excess`, a line each. Only the grids of a
/// scene may take more texture units, where the driver has them: the scene is then refused
/// elsewhere.
gl::GetProc with_limits(gl::GetProc functions, std::vector<std::string>& excess);

}  // namespace fumarole::test
