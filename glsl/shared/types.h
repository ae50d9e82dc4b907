// Types of the structs that C++ and GLSL share, laid out by std140. No bare vec3, no bool, no mat3.
#ifdef __cplusplus
#pragma once
#include <glm/glm.hpp>
namespace fumarole::shared {
using vec4 = glm::vec4;
using ivec4 = glm::ivec4;
using mat4 = glm::mat4;
}  // namespace fumarole::shared
#define FUM_SHARED_BEGIN namespace fumarole::shared {
#define FUM_SHARED_END }
#else
#define FUM_SHARED_BEGIN
#define FUM_SHARED_END
#endif
