#include "toolbox.h"

#include <fmt/format.h>

#include <fumarole/errors.h>

#include "run_as.h"
#include "shared/bindings.h"

namespace fumarole {

void Toolbox::bind_block(const PreparedFrame& frame) const
{
    frame_block.write(frame.params);
    device->BindBufferBase(GL_UNIFORM_BUFFER, FRAME_BLOCK, frame_block.id());
}

void Toolbox::bind(const PreparedFrame& frame) const
{
    bind_block(frame);
    gl::bind_texture(device, SCENE_DEPTH_UNIT, frame.host.depth);
    device->BindSampler(SCENE_DEPTH_UNIT, depth_sampler.id());
}

void Toolbox::draw_fullscreen(const char* fragment_file, const gl::Defines& defines) const
{
    device->UseProgram(programs.get({"pass/fullscreen.vert", fragment_file}, defines).id());
    device->BindVertexArray(fullscreen.id());
    device->DrawArrays(GL_TRIANGLES, 0, 3);
}

void Toolbox::dispatch_over(glm::ivec2 pixels, const char* file, const gl::Defines& defines) const
{
    device->UseProgram(programs.get({file}, defines).id());
    const glm::uvec2 groups((pixels + (PICTURE_GROUP - 1)) / PICTURE_GROUP);
    device->DispatchCompute(groups.x, groups.y, 1);
}

gl::Defines Toolbox::scattering_defines(const FrameSettings& s) const
{
    gl::Defines defines = media.defines();
    defines += lights.defines();
    defines += volumes.defines();
    const auto add = [&](bool condition, const char* name) {
        if (condition)
            defines.emplace_back(name, "");
    };
    add(scene_settings.volume_shadows && lights.count() > 0, "kVolumeShadows");
    add(scene_settings.world_light && lights.world_radiance() != glm::vec3(0.0f), "kWorldLight");
    add(scene_settings.shadow_range == SceneSettings::ShadowRange::light, "kShadowToLight");
    add(s.min_extinction > 0, "kMinExtinction");
    add(defines.value_of("kDepthVolume") != nullptr && media.marched_alone(), "kDepthAtPoint");
    return defines;
}

bool Toolbox::monochrome(const FrameSettings& s) const
{
    return s.targets == Settings::Targets::mono ||
           (s.targets == Settings::Targets::automatic && !media.traits().colored_extinction);
}

bool Toolbox::computes(const FrameSettings& s) const
{
    return runs_compute(device, s);
}

void Toolbox::check_loops(int steps, int shadow_steps) const
{
    const int most = device.capabilities().max_loop_turns;
    const medium::MediaTraits& traits = media.traits();
    if (most == 0)
        return;
    // Each loop takes a turn more, to see that it is done.
    double a_light = 1;
    if (scene_settings.volume_shadows && traits.marched > 0 && !volumes.depths())
        a_light +=
            traits.marched * (shadow_steps + 1.0) + shadow_steps * double(traits.noise_turns);
    const double a_step = 2 + traits.noise_turns + lights.count() * a_light;
    if (steps * a_step > most)
        throw Error(fmt::format(
            "{} steps with {} lights of {} shadow steps take {:.0f} turns of a shader's loops, and "
            "{} stops them after {} without a word; lower FrameSettings::steps or "
            "FrameSettings::shadow_steps, or use a GPU",
            steps, lights.count(), shadow_steps, steps * a_step, device.capabilities().renderer,
            most));
}

}  // namespace fumarole
