#pragma once

#include <string>

namespace fumarole::test {

/// Media lit by a sun before a wall: quick to draw and quick to refer to.
/// @param resolution, media as a scene file spells them @param more surfaces, after a comma
inline std::string fog_scene(const std::string& resolution, const std::string& media,
                             const std::string& more = "")
{
    return R"({
  "resolution": )" +
           resolution + R"(,
  "camera": {"position": [0, -8, 1], "look_at": [0, 0, 1], "up": [0, 0, 1], "vfov_deg": 30,
             "near": 0.1, "far": 100, "projection": "perspective"},
  "world_radiance": [0, 0, 0],
  "lights": [
    {"type": "sun", "direction_to_light": [-1, -1, 1], "irradiance_W_per_m2": [3, 3, 3]}
  ],
  "media": [)" +
           media + R"(],
  "surfaces": [{"type": "box", "min": [-9, 2, -9], "max": [9, 3, 9], "albedo": [0.5, 0.5, 0.5]})" +
           more + "]\n}\n";
}

}  // namespace fumarole::test
