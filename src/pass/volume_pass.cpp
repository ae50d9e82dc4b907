#include "pass/volume_pass.h"

namespace fumarole::pass {

void Toolbox::draw_fullscreen(const char* fragment_file, const gl::Defines& defines) const
{
    device->UseProgram(programs.get({"pass/fullscreen.vert", fragment_file}, defines).id());
    device->BindVertexArray(fullscreen.id());
    device->DrawArrays(GL_TRIANGLES, 0, 3);
}

gl::Defines Toolbox::scattering_defines(const Settings& s) const
{
    gl::Defines defines = media.defines();
    for (const gl::Defines& more : {lights.defines(), volumes.defines(s)})
        defines.insert(defines.end(), more.begin(), more.end());
    const auto add = [&](bool condition, const char* name) {
        if (condition)
            defines.emplace_back(name, "");
    };
    add(s.volume_shadows && lights.count() > 0, "VOLUME_SHADOWS");
    add(s.world_light && lights.world_radiance() != glm::vec3(0.0f), "WORLD_LIGHT");
    add(s.shadow_range == Settings::ShadowRange::light, "SHADOW_TO_LIGHT");
    add(s.least_extinction > 0, "LEAST_EXTINCTION");
    return defines;
}

bool Toolbox::monochrome(const Settings& s) const
{
    return s.targets == Settings::Targets::mono ||
           (s.targets == Settings::Targets::automatic && !media.traits().colored_extinction);
}

}  // namespace fumarole::pass
