#include "transparent/convex.h"

#include <algorithm>
#include <glm/glm.hpp>

#include <fumarole/bounds.h>

namespace fumarole::transparent {

Winding convex_winding(const Mesh& mesh)
{
    constexpr std::size_t kMostCompared = 1 << 22;  // some milliseconds
    constexpr double kSlack = 1e-6, kNoArea = 1e-12;
    if (mesh.triangles.size() / 3 * mesh.positions.size() > kMostCompared)
        return Winding::none;
    double size = 0;
    for (const glm::vec3& p : mesh.positions)
        size = std::max(size, glm::length(glm::dvec3(p) - glm::dvec3(mesh.positions.front())));
    Winding winding = Winding::none;
    for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
        const auto corner = [&](std::size_t k) {
            return glm::dvec3(mesh.positions[mesh.triangles[i + k]]);
        };
        const glm::dvec3 a = corner(0);
        const glm::dvec3 across = glm::cross(corner(1) - a, corner(2) - a);
        const double area = glm::length(across);
        if (!(area > kNoArea * size * size))
            continue;                   // no ray meets it
        double before = 0, behind = 0;  // the farthest from its plane
        for (const glm::vec3& p : mesh.positions) {
            const double place = glm::dot(across / area, glm::dvec3(p) - a);
            before = std::max(before, place);
            behind = std::max(behind, -place);
        }
        if ((before > kSlack * size) == (behind > kSlack * size))
            return Winding::none;
        const Winding own =
            behind > kSlack * size ? Winding::counter_clockwise : Winding::clockwise;
        if (winding != Winding::none && winding != own)
            return Winding::none;
        winding = own;
    }
    return winding;
}

}  // namespace fumarole::transparent
