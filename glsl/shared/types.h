// Types of the structs that C++ and GLSL share, laid out by std140. A vec3 stands at the begin of
// 16 bytes with a scalar behind it, and a vec2 at the begin of 8: no bool, no mat3. Of doubles,
// twice as many bytes each.
#ifdef __cplusplus
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
namespace fumarole::shared {
using uint = std::uint32_t;
using vec2 = glm::vec2;
using vec3 = glm::vec3;
using vec4 = glm::vec4;
using ivec2 = glm::ivec2;
using ivec3 = glm::ivec3;
using ivec4 = glm::ivec4;
using mat4 = glm::mat4;
using dvec2 = glm::dvec2;
using dvec4 = glm::dvec4;
using dmat4 = glm::dmat4;
}  // namespace fumarole::shared
#define FUM_SHARED_BEGIN namespace fumarole::shared {
#define FUM_SHARED_END }
#define FUM_SHARED_FUNCTION inline
#define FUM_STD140 alignas(16)  // a struct's size is a multiple of 16 bytes
#else
#define FUM_SHARED_BEGIN
#define FUM_SHARED_END
#define FUM_SHARED_FUNCTION
#define FUM_STD140
#endif
